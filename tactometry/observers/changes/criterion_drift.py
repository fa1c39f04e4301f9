"""A criterion that drifts."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import exp, sqrt

import numpy as np

from ...arguments.annotations import NotNegative, Positive
from ...arguments.constraints import constrained
from .change import Answer, Shift


@dataclass(frozen=True)
@constrained
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

    sd: NotNegative = 0.3
    n_trials: Positive = 50.0

    def shift(self, n_trials: int, answers: Sequence[Answer], rng: np.random.Generator) -> Shift:
        del answers
        keep = exp(-1 / self.n_trials)
        steps = rng.standard_normal(n_trials + 1)
        weights = keep ** np.arange(n_trials, -1, -1.0)
        weights[1:] *= sqrt(1 - keep**2)  # the first has the variance of the process
        return Shift(criterion=self.sd * float(weights @ steps))
