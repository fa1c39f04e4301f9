"""Finding 5: one bit with the audible frequencies filtered is the best in amplitude and noise."""

import math

from ..reproduction import Number, Reproduction
from .four_signals import ASSUMES, DrivenFocus, measured

BEST = "1 bit, filtered"
REFERENCE_M = 10e-6


def numbers() -> list[Number]:
    signals = measured()
    loudest = max(signal.sound_dba for signal in signals.values())
    largest_m = max(signal.amplitude_m for signal in signals.values())
    strong = {name: signal for name, signal in signals.items() if signal.amplitude_m >= largest_m / 2}
    quietest = min(strong, key=lambda name: strong[name].sound_dba)
    return [
        number
        for name, signal in signals.items()
        for number in (
            Number("amplitude, of the largest", name, 100 * signal.amplitude_m / largest_m, "%", "derived"),
            Number("sound, re the loudest", name, signal.sound_dba - loudest, "dB", "derived"),
            Number(
                "sound at 10 um, re one bit", name, _at_10_um(signal) - _at_10_um(signals["1 bit"]), "dB", "derived"
            ),
            Number(
                "quietest of half the amplitude", name, float(name == quietest), "", "derived", *_stated(name, quietest)
            ),
        )
    ]


def _at_10_um(signal: DrivenFocus) -> float:
    """The level if the supply could make each signal reach 10 um."""
    return signal.sound_dba + 20 * math.log10(REFERENCE_M / signal.amplitude_m)


def _stated(name: str, quietest: str) -> tuple[str, bool | None]:
    return ("best in amplitude and noise", name == quietest) if name == BEST else ("", None)


FINDING = Reproduction(
    title="One bit with filtered audible frequencies is the best in amplitude and noise",
    stated="One bit with filtering is the most efficient in amplitude and in reducing sound (page 3).",
    assumes=f"{ASSUMES} The sources do not say how amplitude and sound are weighed: here the quietest signal of "
    "at least half the largest amplitude counts as the best.",
    numbers=numbers,
    outcome="With a given supply it comes out: filtering one bit costs a part of the amplitude and takes much "
    "of the sound, sigma-delta modulation at the same voltage is far below the amplitude of a focus that is "
    "felt. It hangs on that limit: if the voltage could be raised until each signal gives 10 um, the filtered "
    "sigma-delta drive would be the quietest.",
)
