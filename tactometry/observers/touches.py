"""The touches of a simulated finger in each trial of a session, computed for many trials at once."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..gates import Compliance, SpeedCompliance, compliances, motions
from ..session.request import Press, Slide
from .finger import Array, Grip, SimulatedFinger

N_AHEAD = 32
"""Trials whose touches are computed together: a block of a session has about as many."""


class KeptTouch(NamedTuple):
    """A touch, how its force was kept, and its speed where that is gated."""

    grip: Grip
    force: Compliance
    speed: SpeedCompliance | None


def kept_touches(finger: SimulatedFinger, request: Press | Slide, drawn: Array) -> list[KeptTouch]:
    """A touch for each row of (n_touches, `finger.n_draws`) standard normal numbers."""
    grips = finger.holds(request, drawn)
    forces = compliances(grips.times_s, grips.forces_n, request.target_n, request.tolerance)
    speeds: list[SpeedCompliance] | list[None] = [None] * len(drawn)
    if isinstance(request, Slide) and request.speed_tolerance is not None:
        speeds = motions(grips.times_s, grips.positions_m, request.speed_m_per_s, request.speed_tolerance)
    each = enumerate(zip(forces, speeds, strict=True))
    return [KeptTouch(grips.of(i), force, speed) for i, (force, speed) in each]


class Touches:
    """What is random in each trial of a session: its touches first, then whatever `rng` is asked for.

    Trial n draws from `rng_of(n)` alone. The numbers of touches are drawn, and touches computed, for the trials that
    follow too, as if they asked alike: a trial that does not has its stream made anew, so that nothing depends on it.
    """

    def __init__(self, finger: SimulatedFinger, rng_of: Callable[[int], np.random.Generator]) -> None:
        self._finger, self._rng_of = finger, rng_of
        self._ahead: dict[int, _Ahead] = {}
        self._computed: dict[tuple[int, int], KeptTouch] = {}
        self._asked: Press | Slide | None = None
        self._per_trial = 1
        self.begin(0)

    def begin(self, n_trials: int) -> None:
        self._n, self._n_touches, self._n_drawn = n_trials, 0, 0
        self._rng: np.random.Generator | None = None

    @property
    def rng(self) -> np.random.Generator:
        """The stream of this trial, behind its touches."""
        if self._rng is None:
            ahead = self._ahead.pop(self._n, None)
            self._rng = ahead.rng if ahead is not None and ahead.drawn.size == self._n_drawn else self._anew()
        return self._rng

    def _anew(self) -> np.random.Generator:
        rng = self._rng_of(self._n)
        rng.standard_normal(self._n_drawn)
        return rng

    def touch(self, request: Press | Slide) -> KeptTouch:
        """The next touch of this trial."""
        asked = replace(request, stimulus="", level=None, interval=None)
        if self._rng is None and (self._n_touches == 0 or asked == self._asked):
            return self._next(asked)
        (one,) = kept_touches(self._finger, request, self.rng.standard_normal((1, self._finger.n_draws(request))))
        return one

    def _next(self, asked: Press | Slide) -> KeptTouch:
        if asked != self._asked:
            self._asked = asked
            self._computed.clear()
        self._per_trial = max(self._per_trial, self._n_touches + 1)
        place = self._n, self._n_touches
        if place not in self._computed:
            size, numbers = self._per_trial * self._finger.n_draws(asked), range(self._n, self._n + N_AHEAD)
            self._ahead = {n: self._drawn(n, size) for n in numbers}
            drawn = np.stack([ahead.drawn for ahead in self._ahead.values()])
            touches = iter(kept_touches(self._finger, asked, drawn.reshape(N_AHEAD * self._per_trial, -1)))
            self._computed = {(n, i): next(touches) for n in numbers for i in range(self._per_trial)}
        self._n_touches += 1
        self._n_drawn += self._finger.n_draws(asked)
        return self._computed.pop(place)

    def _drawn(self, n: int, size: int) -> "_Ahead":
        known = self._ahead.get(n)
        if known is not None and known.drawn.size == size:
            return known
        rng = self._rng_of(n)
        return _Ahead(rng, rng.standard_normal(size))


@dataclass(frozen=True, eq=False)
class _Ahead:
    """The stream of a trial, behind the numbers that were drawn from it."""

    rng: np.random.Generator
    drawn: Array
