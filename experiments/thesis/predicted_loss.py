"""Loss of a focus under a finger from the impedance of soft tissue: finding 2."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import pi
from statistics import fmean
from typing import Final

import numpy as np

from tactometry.stimuli.arrays import ComplexArray, FloatArray
from tactometry.stimuli.time_reversal.focus_loss import FocusLoss, focus_loss
from tactometry.stimuli.time_reversal.focusing.focusing import Emission
from tactometry.stimuli.time_reversal.pulp import PulpLoad, disc_stiffness
from tactometry.stimuli.time_reversal.responses.load import PlateLoad
from tactometry.stimuli.time_reversal.responses.responses import Point
from tactometry.stimuli.time_reversal.screen.attenuation import TAU_S, Attenuation
from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE, Screen

from .ranges import FingerDraw, draws
from .reproduction import Number, band_of
from .setups import ELSEWHERE, FOCUS, RIG_BAND

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
