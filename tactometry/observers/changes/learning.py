"""Learning: a participant becomes more sensitive."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import exp

import numpy as np

from ...arguments.annotations import Finite, Positive
from ...arguments.constraints import constrained
from .change import Answer, Shift


@dataclass(frozen=True)
@constrained
class SlowLearning:
    """At the first trial less sensitive by `gain_db`, after `n_trials` trials by 1/e of it (unverified defaults).

    Parameters
    ----------
    gain_db : float
        By how much less is felt at the first trial.
    n_trials : float
        After so many trials 1/e of it is left.
    """

    gain_db: Finite = 3.0
    n_trials: Positive = 100.0

    def shift(self, n_trials: int, answers: Sequence[Answer], rng: np.random.Generator) -> Shift:
        del answers, rng
        return Shift(sensitivity_db=-self.gain_db * exp(-n_trials / self.n_trials))
