"""Fatigue: a participant becomes less sensitive."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...arguments.require import finite, positive
from .change import Answer, Shift


@dataclass(frozen=True)
class Fatigue:
    """Less sensitive by `loss_db` after `n_trials` trials, in proportion to them (unverified defaults).

    Parameters
    ----------
    loss_db : float
        By how much less is felt after `n_trials`.
    n_trials : float
        The trials after which that is so.
    """

    loss_db: float = 2.0
    n_trials: float = 500.0

    def __post_init__(self) -> None:
        finite("Fatigue", loss_db=self.loss_db)
        positive("Fatigue", n_trials=self.n_trials)

    def shift(self, n_trials: int, answers: Sequence[Answer], rng: np.random.Generator) -> Shift:
        del answers, rng
        return Shift(sensitivity_db=-self.loss_db * n_trials / self.n_trials)
