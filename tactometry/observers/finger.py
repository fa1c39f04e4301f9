"""A simulated finger that holds a force and a speed as well as a person does."""

import math
from dataclasses import dataclass
from itertools import accumulate

import numpy as np
from numpy.typing import NDArray

from ..arguments.require import below_1, positive
from ..gates import triangle
from ..session.request import Press, Slide


@dataclass(frozen=True)
class Grip:
    """What a finger did during a stimulus: stamps, forces, places along its path, and its mean speed."""

    times_s: NDArray[np.float64]
    forces_n: NDArray[np.float64]
    positions_m: NDArray[np.float64]
    speed_m_per_s: float


@dataclass(frozen=True)
class SimulatedFinger:
    """A finger whose mean force and speed differ from trial to trial, and whose force wavers within a trial.

    All defaults are unverified choices: coefficients of variation of the mean force between trials (the gate opens
    only inside of the band, so values outside are drawn anew) and of the waver within a trial (correlated over
    `waver_s`), of the mean speed, and of its waver within a trial. `force_factor` and `speed_factor` are habits: how
    many times the force and the speed that are asked the finger presses and slides, where the band lets it.
    """

    force_cv: float = 0.15
    waver_cv: float = 0.04
    waver_s: float = 0.2
    speed_cv: float = 0.10
    speed_waver_cv: float = 0.05
    rate_hz: float = 100.0
    force_factor: float = 1.0
    speed_factor: float = 1.0

    def __post_init__(self) -> None:
        below_1("SimulatedFinger", force_cv=self.force_cv, waver_cv=self.waver_cv)
        below_1("SimulatedFinger", speed_cv=self.speed_cv, speed_waver_cv=self.speed_waver_cv)
        positive("SimulatedFinger", waver_s=self.waver_s, rate_hz=self.rate_hz)
        positive("SimulatedFinger", force_factor=self.force_factor, speed_factor=self.speed_factor)

    def hold(self, request: Press | Slide, rng: np.random.Generator) -> Grip:
        """One touch as `request` asks for it, at `rate_hz` for its duration."""
        n_samples = max(round(request.duration_s * self.rate_hz), 2)
        mean_n = request.target_n * self._in_band(request.tolerance, rng)
        forces_n = mean_n * (1 + self.waver_cv * self._waver(n_samples, rng))
        times_s = np.arange(n_samples) / self.rate_hz
        positions_m, speed_m_per_s = self._path(request, times_s, rng)
        return Grip(times_s, np.maximum(forces_n, 0.0), positions_m, speed_m_per_s)

    def _path(
        self, request: Press | Slide, times_s: NDArray[np.float64], rng: np.random.Generator
    ) -> tuple[NDArray[np.float64], float]:
        if isinstance(request, Press):
            return np.zeros_like(times_s), 0.0
        mean_m_per_s = (
            request.speed_m_per_s * self.speed_factor * math.exp(self.speed_cv * float(rng.standard_normal()))
        )
        speeds = mean_m_per_s * np.maximum(1 + self.speed_waver_cv * self._waver(times_s.size, rng), 0.0)
        # a speed is that of the step behind its sample: nothing follows the last
        path_m = np.concatenate([[0.0], np.cumsum(speeds[:-1]) / self.rate_hz])
        return triangle(path_m, request.length_m), float(speeds[:-1].mean())

    def _in_band(self, tolerance: float, rng: np.random.Generator) -> float:
        for ratio in self.force_factor * np.exp(self.force_cv * rng.standard_normal(100)):
            if abs(ratio - 1) <= tolerance:
                return float(ratio)
        # none of a hundred falls into the band: it is narrow, or the habit is far from it
        return float(np.clip(self.force_factor, 1 - tolerance, 1 + tolerance))

    def _waver(self, n_samples: int, rng: np.random.Generator) -> NDArray[np.float64]:
        """A stationary first-order process of unit variance."""
        keep = math.exp(-1 / (self.waver_s * self.rate_hz))
        steps = rng.standard_normal(n_samples)
        steps[1:] *= math.sqrt(1 - keep**2)  # the first has the variance of the process: stationary from there on
        return np.array([*accumulate(steps.tolist(), lambda state, step: keep * state + step)])
