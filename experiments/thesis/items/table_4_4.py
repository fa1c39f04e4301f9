"""Table 4.4: electrical power of the four driving signals."""

import math

from ..reproduction import Number, Reproduction
from .four_signals import ASSUMES, DrivenFocus, measured
from .table_4_1 import patch_capacitance_f

REPETITION_HZ = 100.0
N_PATCHES = 32


def numbers() -> list[Number]:
    return [number for name, signal in measured().items() for number in _of(name, signal)]


def _of(name: str, signal: DrivenFocus) -> list[Number]:
    emission = signal.emission
    at_rest = [
        Number("power while emitting", name, signal.power_w, "W", "derived"),
        Number("energy of a focus", name, 1e3 * signal.power_w * emission.reversal_s, "mJ", "derived"),
        Number("mean power, 100 foci/s", name, signal.power_w * emission.reversal_s * REPETITION_HZ, "W", "derived"),
    ]
    if emission.quantiser is not None:
        return at_rest
    return [*at_rest, Number("analytical estimate", name, analytical_w(signal), "W", "derived")]


def analytical_w(signal: DrivenFocus) -> float:
    """Q C 2 V^2 r: r transitions per second of one bit of flat noise (Rice), 2 sqrt((b^3 - a^3) / (3 (b - a)))."""
    low_hz, high_hz = signal.emission.band.f_min_hz, signal.emission.band.f_max_hz
    transitions_hz = 2 * math.sqrt((high_hz**3 - low_hz**3) / (3 * (high_hz - low_hz)))
    return N_PATCHES * patch_capacitance_f() * 2 * signal.emission.voltage_v**2 * transitions_hz


TABLE = Reproduction(
    title="Power consumption of the driving signals",
    stated="That power was measured through a circuit and estimated (pages 7, 13 and 16); its values are not "
    "in our sources.",
    assumes=f"{ASSUMES} A stiff supply that charges the capacitance of Table 4.1 at each transition, without "
    "losses of the amplifier; 100 foci per second for the mean.",
    numbers=numbers,
)
