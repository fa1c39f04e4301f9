"""A simulated finger that holds a force and a speed as well as a person does."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactometry.errors import InvalidParameter


@dataclass(frozen=True)
class Grip:
    """What a finger did during a stimulus: force samples at `rate_hz`, and its mean speed."""

    times_s: NDArray[np.float64]
    forces_n: NDArray[np.float64]
    speed_m_per_s: float


@dataclass(frozen=True)
class SimulatedFinger:
    """A finger whose mean force and speed differ from trial to trial, and whose force wavers within a trial.

    All defaults are unverified choices: coefficients of variation of the mean force between trials (the gate opens
    only inside of the band, so values outside are drawn anew) and of the waver within a trial (correlated over
    `waver_s`), and of the speed.
    """

    force_cv: float = 0.15
    waver_cv: float = 0.04
    waver_s: float = 0.2
    speed_cv: float = 0.10
    rate_hz: float = 100.0

    def __post_init__(self) -> None:
        for name in ("force_cv", "waver_cv", "speed_cv"):
            if not 0 <= getattr(self, name) < 1:
                raise InvalidParameter(
                    f"SimulatedFinger.{name}: found {getattr(self, name)}, expected from 0 to below 1"
                )
        for name in ("waver_s", "rate_hz"):
            if not 0 < getattr(self, name) < math.inf:
                raise InvalidParameter(f"SimulatedFinger.{name}: found {getattr(self, name)}, expected above 0")

    def hold(
        self, target_n: float, tolerance: float, speed_m_per_s: float, duration_s: float, rng: np.random.Generator
    ) -> Grip:
        """One touch: force (N) at `rate_hz` for `duration_s`, mean speed (m/s)."""
        n_samples = max(round(duration_s * self.rate_hz), 2)
        mean_n = target_n * self._in_band(tolerance, rng)
        forces_n = mean_n * (1 + self.waver_cv * self._waver(n_samples, rng))
        speed = speed_m_per_s * math.exp(self.speed_cv * float(rng.standard_normal()))
        return Grip(np.arange(n_samples) / self.rate_hz, np.maximum(forces_n, 0.0), speed)

    def _in_band(self, tolerance: float, rng: np.random.Generator) -> float:
        for ratio in np.exp(self.force_cv * rng.standard_normal(100)):
            if abs(ratio - 1) <= tolerance:
                return float(ratio)
        return 1.0

    def _waver(self, n_samples: int, rng: np.random.Generator) -> NDArray[np.float64]:
        """A stationary first-order process of unit variance."""
        keep = math.exp(-1 / (self.waver_s * self.rate_hz))
        steps = rng.standard_normal(n_samples)
        steps[1:] *= math.sqrt(1 - keep**2)
        waver = np.empty(n_samples)
        state = 0.0
        for n, step in enumerate(steps.tolist()):
            state = keep * state + step
            waver[n] = state
        return waver
