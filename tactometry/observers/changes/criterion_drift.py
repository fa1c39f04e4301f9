"""A criterion that drifts."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import exp, sqrt

import numpy as np

from ...arguments.require import not_negative, positive
from .change import Answer, Shift


@dataclass(frozen=True)
class CriterionDrift:
    """A stationary first-order process of standard deviation `sd`, in units of the internal noise, whose correlation
    falls to 1/e over `n_trials` trials (unverified defaults).

    Parameters
    ----------
    sd : float
        Standard deviation of the criterion, in units of the internal noise.
    n_trials : float
        After so many trials its correlation has fallen to 1/e.
    """

    sd: float = 0.3
    n_trials: float = 50.0

    def __post_init__(self) -> None:
        not_negative("CriterionDrift", sd=self.sd)
        positive("CriterionDrift", n_trials=self.n_trials)

    def shift(self, n_trials: int, answers: Sequence[Answer], rng: np.random.Generator) -> Shift:
        del answers
        keep = exp(-1 / self.n_trials)
        steps = rng.standard_normal(n_trials + 1)
        weights = keep ** np.arange(n_trials, -1, -1.0)
        weights[1:] *= sqrt(1 - keep**2)  # the first has the variance of the process
        return Shift(criterion=self.sd * float(weights @ steps))
