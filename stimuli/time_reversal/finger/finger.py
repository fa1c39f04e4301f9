"""A finger on the screen: its impedance, what it costs, and when the plate throws it off.

Facts (thesis): 2 N elsewhere than the focus cost 6 % of amplitude, 2 N at the focus up to 30 %. The
default, a damper of 10 N s/m at 2 N with tau = 3.5 ms, is set to meet both in simulation: it is neither
measured nor a prediction. The force law is an unverified default.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from tactometry.arguments.checked import checked
from tactometry.arguments.require import not_negative, positive, within

from ...arrays import ComplexArray, FloatArray
from ..design.closed_forms import one_bit_amplitude_ratio
from ..focusing.emission import Emission
from ..focusing.focusing import drive, focus_amplitude
from ..plate.plate import Plate
from ..responses.load import Attached, PlateLoad
from ..responses.responses import Point
from ..screen.screen import Screen

REFERENCE_FORCE_N: Final = 2.0
RESISTANCE_N_S_PER_M: Final = 10.0
FORCE_EXPONENT: Final = 0.5
PULP_MASS_KG: Final = 1e-4


@checked
@dataclass(frozen=True)
class Finger:
    """A fingertip that presses with `force_n`: R = R_2N (F / 2 N)^p, optional mass and stiffness by the same law.

    It can stand wherever a load can.

    Parameters
    ----------
    x_m, y_m : float
    force_n : float
        At least 0; at 0 nothing touches.
    resistance_n_s_per_m, mass_kg, stiffness_n_per_m : float
        At 2 N, at least 0.
    exponent : float
        From 1/3 (radius of a Hertz contact) to 2/3 (its area); unverified default 1/2.
    """

    x_m: float
    y_m: float
    force_n: float = REFERENCE_FORCE_N
    resistance_n_s_per_m: float = RESISTANCE_N_S_PER_M
    mass_kg: float = 0.0
    stiffness_n_per_m: float = 0.0
    exponent: float = FORCE_EXPONENT

    def __post_init__(self) -> None:
        not_negative(
            "Finger",
            force_n=self.force_n,
            resistance_n_s_per_m=self.resistance_n_s_per_m,
            mass_kg=self.mass_kg,
            stiffness_n_per_m=self.stiffness_n_per_m,
        )
        within("Finger", 0.0, 2.0, exponent=self.exponent)

    def load(self) -> PlateLoad:
        """The local load on the plate.

        >>> Finger(0.1, 0.1, 0.5).load().resistance_n_s_per_m
        5.0
        """
        # 0 ** 0 is 1: with an exponent of 0 a finger that touches nothing would load the plate
        growth = (self.force_n / REFERENCE_FORCE_N) ** self.exponent if self.force_n > 0 else 0.0
        return PlateLoad(
            self.x_m,
            self.y_m,
            self.resistance_n_s_per_m * growth,
            self.mass_kg * growth,
            self.stiffness_n_per_m * growth,
        )

    def weights(self, screen: Screen, f_max_hz: float) -> FloatArray:
        """(n_modes,): the shapes at the contact."""
        return self.load().weights(screen, f_max_hz)

    def dynamic_stiffness(self, s: ComplexArray) -> ComplexArray:
        """Force per displacement (N/m) at complex frequencies s (rad/s)."""
        return self.load().dynamic_stiffness(s)


@checked
def amplitude_loss(
    screen: Screen, focus: Point, loads: Sequence[Attached], emission: Emission, *, relearn: bool = False
) -> float:
    """Share of the focus amplitude that loads take, 1 - A' / A at the focus instant.

    Parameters
    ----------
    relearn : bool
        Learn again with the loads present; by default the drive was learnt without.
    """
    free = emission.responses(screen, [focus])
    loaded = emission.responses(screen, [focus], loads)
    learnt = loaded if relearn else free
    signal = drive(learnt, emission.voltage_v, emission.quantiser)
    plain = drive(free, emission.voltage_v, emission.quantiser)
    return 1 - focus_amplitude(signal, loaded) / focus_amplitude(plain, free)


@checked
def amplitude_ratio_at_focus(plate: Plate, impedance_n_s_per_m: complex) -> float:
    """Closed form of the local part at the focus: |1 / (1 + Z / Z_p)|."""
    return 1 / abs(1 + impedance_n_s_per_m / plate.point_impedance_n_s_per_m)


@checked
def absorbing_tau_s(plate: Plate, impedance_n_s_per_m: complex) -> float:
    """tau_f = 2 M / R_eff, R_eff = Re Z / |1 + Z / Z_p|^2: how fast one contact alone empties the plate.

    >>> from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN
    >>> round(absorbing_tau_s(A4_SCREEN, 10.0) * 1e3)
    51
    """
    effective = complex(impedance_n_s_per_m).real * amplitude_ratio_at_focus(plate, impedance_n_s_per_m) ** 2
    return 2 * plate.mass_kg / effective if effective > 0 else math.inf


@checked
def amplitude_ratio_elsewhere(plate: Plate, impedance_n_s_per_m: complex, tau_s: float, reversal_s: float) -> float:
    """Closed form of absorption alone, 1 bit, learnt without the finger.

    A' / A = tau' (1 - exp(-T / tau')) / (tau (1 - exp(-T / tau))), 1 / tau' = 1 / tau + 1 / tau_f.

    Scattering adds to the loss; relearning removes that part only.
    """
    positive("amplitude_ratio_elsewhere", tau_s=tau_s, reversal_s=reversal_s)
    loaded_tau_s = 1 / (1 / tau_s + 1 / absorbing_tau_s(plate, impedance_n_s_per_m))
    ratio = one_bit_amplitude_ratio(reversal_s, loaded_tau_s) / one_bit_amplitude_ratio(reversal_s, tau_s)
    return float(loaded_tau_s / tau_s * ratio)


@checked
def contact_is_lost(
    amplitude_m: float, frequency_hz: float, force_n: float, pulp_mass_kg: float = PULP_MASS_KG
) -> bool:
    """Whether the pulp leaves the plate: m |d^2u/dt^2| > F with a lumped mass (0.1 g, unverified default).

    >>> contact_is_lost(10e-6, 12.5e3, 6.0), contact_is_lost(10e-6, 12.5e3, 6.5)
    (True, False)
    """
    return ejection_force_n(amplitude_m, frequency_hz, pulp_mass_kg) > force_n


@checked
def ejection_force_n(amplitude_m: float, frequency_hz: float, pulp_mass_kg: float = PULP_MASS_KG) -> float:
    """m w^2 A: the force that a focus of this amplitude can lift."""
    positive("ejection_force_n", pulp_mass_kg=pulp_mass_kg)
    return float(pulp_mass_kg * np.abs(amplitude_m) * (2 * math.pi * frequency_hz) ** 2)
