"""What became of many tracks."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from ..procedures.procedure import Ending
from ..procedures.transition import GOES_ON, ending_of
from .answers import Array

NOT_ASKED = -1


@dataclass(frozen=True, eq=False)
class TrackBatch:
    """What became of tracks.

    Parameters
    ----------
    asked, levels : (n_sets, n_trials) array
        What the rule asked for, and what was delivered; NaN after a track's end.
    answers : (n_sets, n_trials) array of int
        The outcomes, 1 or 0 of most rules, or `NOT_ASKED` after the end.
    endings : (n_sets,) array of int
        As in `tactometry.protocols.procedures.transition`; `ending` says one in words.
    thresholds : (n_sets,) array
        The rule's own estimates; NaN where there is none.
    """

    asked: Array
    levels: Array
    answers: NDArray[np.int8]
    endings: NDArray[np.int8]
    thresholds: Array

    def __len__(self) -> int:
        return len(self.levels)

    @property
    def n_trials(self) -> NDArray[np.int64]:
        """The length of each track, (n_sets,)."""
        return np.asarray((self.answers != NOT_ASKED).sum(axis=1))

    @classmethod
    def blank(cls, shape: tuple[int, ...]) -> Self:
        """Before the first answer."""
        n_sets = shape[0]
        answers, endings = np.full(shape, NOT_ASKED, dtype=np.int8), np.full(n_sets, GOES_ON, dtype=np.int8)
        asked, levels = np.full(shape, np.nan), np.full(shape, np.nan)
        return cls(asked, levels, answers, endings, np.full(n_sets, np.nan))

    def rows(self, sets: slice) -> Self:
        """A part of the sets, which shares their memory."""
        answers, endings = self.answers[sets], self.endings[sets]
        return type(self)(self.asked[sets], self.levels[sets], answers, endings, self.thresholds[sets])

    def ending(self, i: int) -> Ending | None:
        """How a track ended; None if it goes on."""
        return ending_of(int(self.endings[i]))
