"""Lapses that come in runs: a participant is elsewhere for some trials."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...arguments.annotations import Share
from ...arguments.constraints import constrained
from .change import Answer, Shift


@dataclass(frozen=True)
@constrained
class LapsesInRuns:
    """A chain of two states: attention is lost with the chance `loss_rate` a trial and comes back with `return_rate`;
    meanwhile `lapse_rate` of the answers are at random (unverified defaults). In the long run it is lost in
    ``loss_rate / (loss_rate + return_rate)`` of the trials, for ``1 / return_rate`` trials each time.

    Parameters
    ----------
    loss_rate : float
        Chance a trial that attention is lost.
    return_rate : float
        Chance a trial that it comes back.
    lapse_rate : float
        Share of answers at random meanwhile.
    """

    loss_rate: Share = 0.01
    return_rate: Share = 0.2
    lapse_rate: Share = 0.9

    def shift(self, n_trials: int, answers: Sequence[Answer], rng: np.random.Generator) -> Shift:
        del answers
        is_lost = False
        for chance in rng.random(n_trials + 1).tolist():
            is_lost = chance >= self.return_rate if is_lost else chance < self.loss_rate
        return Shift(lapse_rate=self.lapse_rate if is_lost else 0.0)
