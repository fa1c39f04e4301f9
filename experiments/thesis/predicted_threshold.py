"""Threshold of one focus from the sensitivity of the Pacinian channel: finding 1.

A vibration at the threshold A of 250 Hz holds the energy A^2 tau / 2 in the leaky integrator of `temporal_summation`; a
course u as short as a focus the integral of |U(f) W(f)|^2, W being the sensitivity relative to 250 Hz. The area of the
contact counts by 3 dB per doubling. The plate stays together with a linear contact (which pulls by more than presses
it), or it throws the pulp off as its fastest motion ends: the moving mass m = 4/3 rho a^3 of the pulp then flies
against the force F and the resistance R of the pulp, m z'' + R z' = -F, until it is back. All of it follows from the
ranges, and nothing is set to a threshold.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import pi, sqrt
from typing import Final

import numpy as np

from tactometry.stimuli.arrays import FloatArray
from tactometry.stimuli.perception.channels import HEARS_HZ, P, channel_thresholds_db, summation_db
from tactometry.stimuli.scenes.effects.summation import Summation
from tactometry.stimuli.time_reversal.pulp import disc_stiffness
from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE

from .predicted_loss import loss_by_disc
from .ranges import FingerDraw, draws
from .reproduction import Number, band_of
from .setups import FOCUS, UNFILTERED

FORCES_N: Final = (0.5, 1.5, 3.0)
STEP_HZ = 15.0
FREQUENCY_HZ: Final = np.arange(HEARS_HZ[P][0], HEARS_HZ[P][1] + 1, STEP_HZ)
SENSITIVITY: Final = 10 ** (-channel_thresholds_db(FREQUENCY_HZ)[P] / 20)
HOLDS, THROWN, STATED_UM = "contact that holds", "pulp that is thrown", 10.0
FLIGHT_HZ: Final = 500.0
"""Frequency at which the resistance of the pulp is taken in flight, which lasts about a millisecond."""
AMPLITUDES_M: Final = np.geomspace(1e-8, 1e-3, 41)
SHARE_OF_FLIGHT: Final = np.linspace(0.0, 1.0, 61)
N_HALVINGS = 50
CONTACTOR_M2: Final = Summation.reference_m2


@dataclass(frozen=True)
class FocusCourse:
    """Free course of a focus: felt amplitude of 1 m, in m s^0.5, and fastest motion, in 1/s."""

    felt: float
    speed_per_s: float


def focus_course(free_m: FloatArray, rate_hz: float) -> FocusCourse:
    """Return the felt amplitude and the speed per amplitude of a free course."""
    times_s, amplitude_m = np.arange(len(free_m)) / rate_hz, float(np.abs(free_m).max())
    fastest = float(np.abs(np.diff(free_m)).max()) * rate_hz
    return FocusCourse(float(felt(times_s, free_m)) / amplitude_m, fastest / amplitude_m)


def felt(times_s: FloatArray, courses_m: FloatArray) -> FloatArray:
    """Return the roots of the energy (m s^0.5) that courses (..., n_times) leave in the channel."""
    turned = np.exp(-2j * pi * FREQUENCY_HZ[:, None] * times_s[..., None, :])
    spectrum = np.einsum("...ft,...t->...f", turned, courses_m) * (times_s[..., 1] - times_s[..., 0])[..., None]
    return np.asarray(np.sqrt(2 * STEP_HZ * np.sum(np.abs(spectrum * SENSITIVITY) ** 2, axis=-1)))


def flights(
    mass_kg: float, resistance_n_s_per_m: float, force_n: float, speeds: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return times and heights (n, n_times) of a pulp thrown at speeds (m/s) above 0."""
    slows_s, sinks = mass_kg / resistance_n_s_per_m, force_n / resistance_n_s_per_m

    def height_m(t_s: FloatArray) -> FloatArray:
        start = (speeds + sinks).reshape(-1, *[1] * (t_s.ndim - 1))
        return np.asarray(-slows_s * start * np.expm1(-t_s / slows_s) - sinks * t_s)

    rising, landed = slows_s * np.log1p(speeds / sinks), 2 * mass_kg * speeds / force_n
    for _ in range(N_HALVINGS):
        middle = (rising + landed) / 2
        flies = height_m(middle) > 0
        rising, landed = np.where(flies, middle, rising), np.where(flies, landed, middle)
    times_s = landed[:, None] * SHARE_OF_FLIGHT
    return times_s, height_m(times_s)


def thresholds_m(one: FingerDraw, force_n: float, course: FocusCourse, loss: float) -> tuple[float, float]:
    """Return the free focus at threshold: of a pulp that is thrown, and of a contact that holds."""
    load, area_m2 = one.load(force_n), one.area_m2(force_n)
    needed = one.threshold_m * sqrt(one.summation_s / 2) * 10 ** (-summation_db(area_m2, CONTACTOR_M2) / 20)
    s = np.array([2j * pi * FLIGHT_HZ])
    resistance_n_s_per_m = float((disc_stiffness(s, load.radius_m, load.tissue) / s).real.item())
    mass_kg = 4 / 3 * load.tissue.density_kg_per_m3 * load.radius_m**3
    speeds = (1 - loss) * course.speed_per_s * AMPLITUDES_M
    thrown = felt(*flights(mass_kg, resistance_n_s_per_m, force_n, speeds))
    of_thrown = np.exp(np.interp(np.log(needed), np.log(thrown), np.log(AMPLITUDES_M)))
    return float(of_thrown), needed / course.felt


def predicted_threshold(course: FocusCourse) -> Iterator[Number]:
    """Yield thresholds at each force, and their change with force, with bands."""
    disc, drawn = loss_by_disc(A4_PROTOTYPE, FOCUS, UNFILTERED), list(draws())
    found = np.empty((len(FORCES_N), len(drawn), 2))
    for i, force_n in enumerate(FORCES_N):
        for n, one in enumerate(drawn):
            load = one.load(force_n)
            loss = disc.by(load.dynamic_stiffness(disc.s), load.radius_m)
            found[i, n] = thresholds_m(one, force_n, course, loss)
    for k, name in enumerate((THROWN, HOLDS)):
        variant = name == HOLDS
        for force_n, thresholds in zip(FORCES_N, found[..., k], strict=True):
            band = band_of(1e6 * thresholds)
            near = {"stated": "about 10 um", "holds": band.holds(STATED_UM), "is_variant": variant}
            yield band.number(f"threshold, {name}", f"{force_n:g} N", "um", **near)
        band = band_of(20 * np.log10(found[-1, :, k] / found[0, :, k]))
        none = {"stated": "force has no influence", "holds": band.holds(0.0), "is_variant": variant}
        yield band.number(f"threshold from {FORCES_N[0]:g} to {FORCES_N[-1]:g} N", name, "dB", **none)
