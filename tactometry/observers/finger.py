"""A simulated finger that holds a force and a speed as well as a person does."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arguments.annotations import Positive, Rate
from ..arguments.constraints import constrained
from ..gates import triangle
from ..session.request import Press, Slide

Array = NDArray[np.float64]
N_TRIES = 100
"""Forces are drawn so often until one falls into the band."""


@dataclass(frozen=True)
class Grip:
    """What a finger did during a stimulus: stamps, forces, places along its path, and its mean speed."""

    times_s: Array
    forces_n: Array
    positions_m: Array
    speed_m_per_s: float


@dataclass(frozen=True)
class Grips:
    """The same of several touches with the same stamps: a row of forces and places, and a speed, for each."""

    times_s: Array
    forces_n: Array
    positions_m: Array
    speeds_m_per_s: Array

    def of(self, i: int) -> Grip:
        return Grip(self.times_s, self.forces_n[i], self.positions_m[i], float(self.speeds_m_per_s[i]))


@dataclass(frozen=True)
@constrained
class SimulatedFinger:
    """A finger whose mean force and speed differ from trial to trial, and whose force wavers within a trial.

    All defaults are unverified choices: coefficients of variation of the mean force between trials (the gate opens
    only inside of the band, so values outside are drawn anew) and of the waver within a trial (correlated over
    `waver_s`), of the mean speed, and of its waver within a trial. `force_factor` and `speed_factor` are habits: how
    many times the force and the speed that are asked the finger presses and slides, where the band lets it.

    Parameters
    ----------
    force_cv : float
        Coefficient of variation of the mean force, from trial to trial.
    waver_cv : float
        Of the force within a trial.
    waver_s : float
        How long the waver stays correlated.
    speed_cv : float
        Of the mean speed, from trial to trial.
    speed_waver_cv : float
        Of the speed within a trial.
    rate_hz : float
        Samples of force and place per second.
    force_factor, speed_factor : float
        How many times the force and the speed that are asked for the finger presses and slides.
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
        """One touch as `request` asks for it, at `rate_hz` for its duration."""
        return self.holds(request, rng.standard_normal((1, self.n_draws(request)))).of(0)

    def n_draws(self, request: Press | Slide) -> int:
        """How many normal numbers a touch takes: for the force, the waver and, of a slide, the speed and its waver."""
        n_samples = self._n_samples(request)
        return N_TRIES + n_samples + (0 if isinstance(request, Press) else 1 + n_samples)

    def _n_samples(self, request: Press | Slide) -> int:
        return max(round(request.duration_s * self.rate_hz), 2)

    def holds(self, request: Press | Slide, drawn: Array) -> Grips:
        """A touch for each row of (n_touches, n_draws) standard normal numbers."""
        n_samples = self._n_samples(request)
        times_s = np.arange(n_samples) / self.rate_hz
        tries, waver, path = np.split(drawn, (N_TRIES, N_TRIES + n_samples), axis=1)
        tolerance = request.tolerance
        ratios = self.force_factor * np.exp(self.force_cv * tries)
        inside = np.abs(ratios - 1) <= tolerance
        first = np.take_along_axis(ratios, inside.argmax(axis=1)[:, None], axis=1)[:, 0]
        # none of a hundred falls into the band: it is narrow, or the habit is far from it
        in_band = np.where(inside.any(axis=1), first, np.clip(self.force_factor, 1 - tolerance, 1 + tolerance))
        means_n = request.target_n * in_band
        forces_n = np.maximum(means_n[:, None] * (1 + self.waver_cv * self._waver(waver)), 0.0)
        if isinstance(request, Press):
            return Grips(times_s, forces_n, np.zeros_like(forces_n), np.zeros(len(drawn)))
        # places along the path, (n_touches, n_samples), and mean speeds, (n_touches,)
        asked_m_per_s = request.speed_m_per_s * self.speed_factor
        means_m_per_s = np.array([asked_m_per_s * math.exp(self.speed_cv * z) for z in path[:, 0].tolist()])
        speeds = means_m_per_s[:, None] * np.maximum(1 + self.speed_waver_cv * self._waver(path[:, 1:]), 0.0)
        # a speed is that of the step behind its sample: nothing follows the last
        steps = speeds[:, :-1]
        paths_m = np.pad(np.cumsum(steps, axis=1) / self.rate_hz, ((0, 0), (1, 0)))
        paths = triangle(paths_m, request.length_m), steps.mean(axis=1)
        return Grips(times_s, forces_n, *paths)

    def _waver(self, drawn: Array) -> Array:
        """A stationary first-order process of unit variance from each row."""
        keep = math.exp(-1 / (self.waver_s * self.rate_hz))
        steps = drawn.T.copy()
        steps[1:] *= math.sqrt(1 - keep**2)  # the first has the variance of the process: stationary from there on
        for n in range(1, len(steps)):
            steps[n] += keep * steps[n - 1]
        return np.ascontiguousarray(steps.T)
