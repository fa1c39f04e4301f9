"""Fatigue: a participant becomes less sensitive."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...arguments.annotations import Finite, Positive
from ...arguments.constraints import constrained
from .change import Answer, Shift


@dataclass(frozen=True)
@constrained
class Fatigue:
    """Less sensitive by `loss_db` after `n_trials` trials, in proportion to them (unverified defaults).

    Parameters
    ----------
    loss_db : float
        By how much less is felt after `n_trials`.
    n_trials : float
        The trials after which that is so.
    """

    loss_db: Finite = 2.0
    n_trials: Positive = 500.0

    def shift(self, n_trials: int, answers: Sequence[Answer], rng: np.random.Generator) -> Shift:
        del answers, rng
        return Shift(sensitivity_db=-self.loss_db * n_trials / self.n_trials)
