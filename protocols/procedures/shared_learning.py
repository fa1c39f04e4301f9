"""Procedures that run interleaved and may learn from each other's answers."""

from abc import abstractmethod
from collections.abc import Sequence
from typing import Self

from .procedure import Procedure


class Sharing(Procedure):
    """A procedure to which an answer on another track tells something."""

    @abstractmethod
    def learning_from(self, other: Procedure) -> Self:
        """This procedure, when `other` has just had an answer; unchanged if the two share nothing."""


def after_answer(
    procedures: Sequence[Procedure], index: int, response: int | bool, delivered: float | None = None
) -> tuple[Procedure, ...]:
    """All procedures after an answer to one of them.

    >>> from tactometry.protocols import ConstantStimuli
    >>> first, second = after_answer((ConstantStimuli((1.0,), 1), ConstantStimuli((2.0,), 1)), 0, 1)
    >>> first.finished, second.finished
    (True, False)
    """
    moved = procedures[index].after(response, delivered)
    others = (other.learning_from(moved) if isinstance(other, Sharing) else other for other in procedures)
    return tuple(moved if n == index else other for n, other in enumerate(others))
