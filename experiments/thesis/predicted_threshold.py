"""Threshold of one focus from the sensitivity of the Pacinian channel: finding 1.

A vibration at the threshold A of 250 Hz holds the energy A^2 tau / 2 in the leaky integrator of `temporal_summation`; a
course u as short as a focus the integral of |U(f) W(f)|^2, W being the sensitivity relative to 250 Hz. The area of the
contact counts by 3 dB per doubling. The plate stays together with a linear contact (which pulls by more than presses
it), or it throws the pulp off as its fastest motion ends: the moving mass m = 4/3 rho a^3 of the pulp then flies
against the force F and the resistance R of the pulp, m z'' + R z' = -F, until it is back. All of it follows from the
ranges, and nothing is set to a threshold.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import pi, sqrt
from statistics import fmean
from typing import Final

import numpy as np

from tactometry.stimuli.arrays import ComplexArray, FloatArray
from tactometry.stimuli.perception.channels import HEARS_HZ, P, channel_thresholds_db, summation_db
from tactometry.stimuli.scenes.effects.summation import Summation
from tactometry.stimuli.time_reversal.focus_loss import FocusLoss, focus_loss
from tactometry.stimuli.time_reversal.focusing.focusing import Emission
from tactometry.stimuli.time_reversal.pulp import PulpLoad, disc_stiffness
from tactometry.stimuli.time_reversal.responses.load import PlateLoad
from tactometry.stimuli.time_reversal.responses.responses import Point
from tactometry.stimuli.time_reversal.screen.attenuation import TAU_S, Attenuation
from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE, Screen

from .reproduction import Number, band_of
from .setups import ELSEWHERE, FOCUS, RIG_BAND, UNFILTERED
from .spread import FingerDraw, draws

PRESSED_N = 2.0
TAUS_S: Final = (2e-3, TAU_S, 5e-3)
"""Attenuation of the plate, which no source gives: each draw has one of them."""
RADII_M: Final = (4e-3, 5e-3, 6e-3, 7e-3, 8e-3)
"""Radii of the disc, between which losses are interpolated."""
PLACES: Final[Mapping[str, Sequence[Point]]] = {"at the focus": (FOCUS,), "elsewhere": ELSEWHERE}
STATED: Final = {"at the focus": ("up to 30 %", 30.0), "elsewhere": ("about 6 %", 6.0)}
FROM_RANGES, AT_A_POINT = "pulp of soft tissue", "the same, at a point"
FREQUENCIES_HZ: Final = (1e3, 10e3, 25e3, 60e3)


@dataclass(frozen=True)
class LossByDisc:
    """Loss at the focus by a disc at one place, by its radius."""

    discs: tuple[FocusLoss, ...]

    @property
    def s(self) -> ComplexArray:
        return self.discs[0].s

    def by(self, stiffness: ComplexArray, radius_m: float) -> float:
        return float(np.interp(radius_m, RADII_M, [disc.by(stiffness) for disc in self.discs]))


def loss_by_disc(screen: Screen, at_m: Point, emission: Emission) -> LossByDisc:
    """Compute the plate once for discs of all radii."""
    return LossByDisc(tuple(focus_loss(screen, FOCUS, PulpLoad(*at_m, radius), emission) for radius in RADII_M))


def predicted_loss() -> Iterator[Number]:
    """Yield the loss under 2 N with its band, and the impedance."""
    drawn = list(draws())
    for place, places_m in PLACES.items():
        by_disc, by_point = _losses(drawn, places_m).T
        said, stated = STATED[place]
        of_disc, of_point = band_of(100 * by_disc), band_of(100 * by_point)
        yield of_disc.number(place, FROM_RANGES, "%", stated=said, holds=of_disc.holds(stated))
        yield of_point.number(place, AT_A_POINT, "%", is_variant=True)
    for frequency_hz in FREQUENCIES_HZ:
        s = np.array([2j * pi * frequency_hz])
        loads = [one.load(PRESSED_N) for one in drawn]
        size = [abs((disc_stiffness(s, load.radius_m, load.tissue) / s).item()) for load in loads]
        yield band_of(size).number("size of the impedance", f"pulp at {frequency_hz / 1e3:g} kHz", "N s/m")


def _losses(drawn: Sequence[FingerDraw], places_m: Sequence[Point]) -> FloatArray:
    """(n_draws, 2): mean losses over places by a disc, and by the same at a point."""
    screens = [Screen(A4_PROTOTYPE.plate, A4_PROTOTYPE.sources, Attenuation(tau_s)) for tau_s in TAUS_S]
    discs = [[loss_by_disc(screen, at_m, RIG_BAND) for at_m in places_m] for screen in screens]
    points = [[focus_loss(screen, FOCUS, PlateLoad(*at_m), RIG_BAND) for at_m in places_m] for screen in screens]
    losses = []
    for n, one in enumerate(drawn):
        load, tau = one.load(PRESSED_N), n % len(TAUS_S)
        stiffness = load.dynamic_stiffness(discs[tau][0].s)
        by_disc = fmean(disc.by(stiffness, load.radius_m) for disc in discs[tau])
        losses.append((by_disc, fmean(point.by(stiffness) for point in points[tau])))
    return np.array(losses)


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
    result = np.empty((len(FORCES_N), len(drawn), 2))
    for i, force_n in enumerate(FORCES_N):
        for n, one in enumerate(drawn):
            load = one.load(force_n)
            loss = disc.by(load.dynamic_stiffness(disc.s), load.radius_m)
            result[i, n] = thresholds_m(one, force_n, course, loss)
    for k, name in enumerate((THROWN, HOLDS)):
        variant = name == HOLDS
        for force_n, thresholds in zip(FORCES_N, result[..., k], strict=True):
            band = band_of(1e6 * thresholds)
            near = {"stated": "about 10 um", "holds": band.holds(STATED_UM), "is_variant": variant}
            yield band.number(f"threshold, {name}", f"{force_n:g} N", "um", **near)
        band = band_of(20 * np.log10(result[-1, :, k] / result[0, :, k]))
        none = {"stated": "force has no influence", "holds": band.holds(0.0), "is_variant": variant}
        yield band.number(f"threshold from {FORCES_N[0]:g} to {FORCES_N[-1]:g} N", name, "dB", **none)
