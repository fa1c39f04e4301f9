"""The method of constant stimuli."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from tactometry.arguments.require import numbers, repeated, whole
from tactometry.errors import InvalidParameter, counted

from .procedure import MOST_TRIALS, Ending, checked_response, refuse_finished


@dataclass(frozen=True)
class ConstantStimuli:
    """Each of `levels` is presented `repeats` times, in an order that no response changes.

    Without `shuffled` the levels come in their given order, repeat after repeat. Gescheider, Psychophysics: The
    Fundamentals, 3rd ed. (1997), chapter 3. A run whose answers are all 1 or all 0 tells only on which side of its
    levels the threshold lies, and ends as censored.

    Raises
    ------
    InvalidParameter
        If there is no level, a level is not finite or stands twice, `repeats` is below 1, or there are more than
        `MOST_TRIALS`.

    >>> rule = ConstantStimuli(levels=(1.0, 2.0), repeats=1)
    >>> rule.level, rule.after(1).level, rule.after(1).after(0).finished
    (1.0, 2.0, True)
    """

    levels: tuple[float, ...]
    repeats: int
    order: tuple[float, ...] = ()
    n_done: int = 0
    _n_told: tuple[int, int] = (0, 0)

    name = "constant_stimuli"

    def __post_init__(self) -> None:
        numbers("ConstantStimuli.levels", self.levels)
        whole("ConstantStimuli", lowest=1, repeats=self.repeats)
        if not self.levels:
            raise InvalidParameter("ConstantStimuli.levels: found no level, expected at least one")
        n = repeated(self.levels)
        if n is not None:
            raise InvalidParameter(
                f"ConstantStimuli.levels[{n}]: found {self.levels[n]:g} twice, expected each level once; raise repeats "
                "to present it more often"
            )
        if self.repeats * len(self.levels) > MOST_TRIALS:
            raise InvalidParameter(
                f"ConstantStimuli.repeats: found {self.repeats} of {counted(len(self.levels), 'level')}, expected at "
                f"most {MOST_TRIALS} trials in all"
            )
        if not self.order:
            object.__setattr__(self, "order", tuple(self.levels) * self.repeats)

    def shuffled(self, rng: np.random.Generator) -> Self:
        """Block-randomised: within each repeat every level comes once, in random order."""
        blocks: Sequence[np.ndarray] = [rng.permutation(self.levels) for _ in range(self.repeats)]
        return replace(self, order=tuple(float(level) for block in blocks for level in block))

    @property
    def level(self) -> float:
        return self.order[min(self.n_done, len(self.order) - 1)]

    @property
    def finished(self) -> bool:
        return self.n_done >= len(self.order)

    @property
    def ended(self) -> Ending | None:
        if not self.finished:
            return None
        n_no, n_yes = self._n_told
        if n_no == 0 < n_yes:
            return "censored_below"
        return "censored_above" if n_yes == 0 < n_no else "trials"

    @property
    def threshold(self) -> None:
        """None: the rule makes no estimate, a fit does (`tactometry.analysis.threshold.fitting.fit`)."""

    def after(self, response: int | bool, delivered: float | None = None) -> Self:
        """The next presentation; neither argument changes the order."""
        del delivered
        refuse_finished(finished=self.finished, procedure="ConstantStimuli")
        return self.skipped().told(response)

    def told(self, response: int | bool) -> Self:
        """The answer counts, the presentation stays."""
        yes = checked_response(response, "ConstantStimuli")
        n_no, n_yes = self._n_told
        return replace(self, _n_told=(n_no + (not yes), n_yes + yes))

    def skipped(self) -> Self:
        """The next presentation; the present one is left to the block, which comes back to it."""
        return replace(self, n_done=self.n_done + 1)
