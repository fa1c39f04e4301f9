"""Simulated finger that holds force and speed with human variability."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..arguments.constraints import Positive, Rate, constrained
from ..gates import Compliance, SpeedCompliance, compliances, motions, triangle
from ..session.request import Press, Slide

Array = NDArray[np.float64]
N_TRIES = 100
"""Largest number of draws of a force until it is in the band."""


@dataclass(frozen=True)
class Grip:
    """Touch: time stamps, forces, positions along the path, and mean speed."""

    times_s: Array
    forces_n: Array
    positions_m: Array
    speed_m_per_s: float


@dataclass(frozen=True)
class Grips:
    """Several touches with the same time stamps, a row each."""

    times_s: Array
    forces_n: Array
    positions_m: Array
    speeds_m_per_s: Array

    def of(self, i: int) -> Grip:
        return Grip(self.times_s, self.forces_n[i], self.positions_m[i], float(self.speeds_m_per_s[i]))


@dataclass(frozen=True)
@constrained
class SimulatedFinger:
    """Finger with variable force and speed.

    Defaults (sources: `finger` in `stimuli/sources.toml`): coefficients of variation of the mean force between
    trials (the gate opens only inside of the band, so values outside are drawn anew) and of the waver within a trial
    (correlated over `waver_s`), of the mean speed, and of its waver within a trial. `force_factor` and `speed_factor`
    are habits: how many times the force and the speed that are asked the finger presses and slides, where the band
    lets it.

    - `force_cv`: Coefficient of variation of the mean force between trials.
    - `waver_cv`: Coefficient of variation of the force within a trial.
    - `waver_s`: Correlation time of the fluctuations within a trial.
    - `speed_cv`: Coefficient of variation of the mean speed between trials.
    - `speed_waver_cv`: Coefficient of variation of the speed within a trial.
    - `rate_hz`: Sampling rate of force and position.
    - `force_factor`: Ratio of the force of the finger to the requested force.
    - `speed_factor`: Ratio of the speed of the finger to the requested speed.
    """

    force_cv: Rate = 0.15
    waver_cv: Rate = 0.04
    waver_s: Positive = 0.2
    speed_cv: Rate = 0.10
    speed_waver_cv: Rate = 0.05
    rate_hz: Positive = 100.0
    force_factor: Positive = 1.0
    speed_factor: Positive = 1.0

    def hold(self, request: Press | Slide, rng: np.random.Generator) -> Grip:
        """Return one touch for a request, sampled at `rate_hz`."""
        return self.holds(request, rng.standard_normal((1, self.n_draws(request)))).of(0)

    def n_draws(self, request: Press | Slide) -> int:
        """Return the number of normal random numbers for one touch."""
        n_samples = self._n_samples(request)
        return N_TRIES + n_samples + (0 if isinstance(request, Press) else 1 + n_samples)

    def _n_samples(self, request: Press | Slide) -> int:
        return max(round(request.duration_s * self.rate_hz), 2)

    def holds(self, request: Press | Slide, drawn: Array) -> Grips:
        """Return a touch for each row of (n_touches, n_draws) normal numbers."""
        n_samples = self._n_samples(request)
        times_s = np.arange(n_samples) / self.rate_hz
        tries, waver, path = np.split(drawn, (N_TRIES, N_TRIES + n_samples), axis=1)

        tolerance = request.tolerance
        ratios = self.force_factor * np.exp(self.force_cv * tries)
        inside = np.abs(ratios - 1) <= tolerance
        first = np.take_along_axis(ratios, inside.argmax(axis=1)[:, None], axis=1)[:, 0]
        # all draws can miss a narrow band, or a band far from the habitual force
        ratios_in_band = np.where(inside.any(axis=1), first, np.clip(self.force_factor, 1 - tolerance, 1 + tolerance))
        means_n = request.target_n * ratios_in_band
        forces_n = np.maximum(means_n[:, None] * (1 + self.waver_cv * self._waver(waver)), 0.0)
        if isinstance(request, Press):
            return Grips(times_s, forces_n, np.zeros_like(forces_n), np.zeros(len(drawn)))

        asked_m_per_s = request.speed_m_per_s * self.speed_factor
        means_m_per_s = np.array([asked_m_per_s * math.exp(self.speed_cv * z) for z in path[:, 0].tolist()])
        speeds = means_m_per_s[:, None] * np.maximum(1 + self.speed_waver_cv * self._waver(path[:, 1:]), 0.0)
        # each speed moves the finger after its sample, so the last speed has no effect
        steps = speeds[:, :-1]
        paths_m = np.pad(np.cumsum(steps, axis=1) / self.rate_hz, ((0, 0), (1, 0)))
        return Grips(times_s, forces_n, triangle(paths_m, request.length_m), steps.mean(axis=1))

    def _waver(self, drawn: Array) -> Array:
        """Return a stationary first-order process of unit variance from each row."""
        keep = math.exp(-1 / (self.waver_s * self.rate_hz))
        steps = drawn.T.copy()
        steps[1:] *= math.sqrt(1 - keep**2)  # the first value already has the variance of the process
        for n in range(1, len(steps)):
            steps[n] += keep * steps[n - 1]
        return np.ascontiguousarray(steps.T)


N_AHEAD = 32
"""Number of trials whose touches are computed together, about as many as in a block."""


class KeptTouch(NamedTuple):
    """Touch with its compliance of force, and of speed if gated."""

    grip: Grip
    force: Compliance
    speed: SpeedCompliance | None


def kept_touches(finger: SimulatedFinger, request: Press | Slide, drawn: Array) -> list[KeptTouch]:
    """Return a touch with its compliance for each row of normal numbers."""
    grips = finger.holds(request, drawn)
    forces = compliances(grips.times_s, grips.forces_n, request.target_n, request.tolerance)
    speeds: list[SpeedCompliance] | list[None] = [None] * len(drawn)
    if isinstance(request, Slide) and request.speed_tolerance is not None:
        speeds = motions(grips.times_s, grips.positions_m, request.speed_m_per_s, request.speed_tolerance)
    each = enumerate(zip(forces, speeds, strict=True))
    return [KeptTouch(grips.of(i), force, speed) for i, (force, speed) in each]


class Touches:
    """Touches of a session, and the random stream of each trial after them.

    Trial n draws only from `rng_of(n)`. Touches of the next trials are computed in advance, assuming the same
    requests. A trial with other requests recreates its stream, so that results do not depend on this.
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
        """Random stream of this trial, after its touches."""
        if self._rng is None:
            ahead = self._ahead.pop(self._n, None)
            if ahead is not None and ahead.drawn.size == self._n_drawn:
                self._rng = ahead.rng
            else:
                self._rng = self._rng_of(self._n)
                self._rng.standard_normal(self._n_drawn)
        return self._rng

    def touch(self, request: Press | Slide) -> KeptTouch:
        """Return the next touch of this trial."""
        requested = replace(request, stimulus="", level=None, interval=None)
        if self._rng is None and (self._n_touches == 0 or requested == self._asked):
            return self._next(requested)
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
    """Random stream of a trial, after the numbers drawn from it."""

    rng: np.random.Generator
    drawn: Array
