"""A procedure as PsychoPy's loops are: what is iterated over, answered to, and known to its experiment handler."""

from collections.abc import Iterator
from typing import Any

from tactometry.protocols.block_state import BlockOptions
from tactometry.protocols.procedures.procedure import Procedure
from tactometry.protocols.tasks.task import TrialOutcome

from .columns import of_trial


class Loop:
    """Levels until the procedure has finished; one that is not answered comes again.

    Parameters
    ----------
    name : str
        Before the names of its columns.
    procedure : Procedure
        At its beginning.
    n_attempts : int
        So many levels in a row without an answer end the loop, as a track of a session.

    Examples
    --------
    >>> from tactometry.protocols import ConstantStimuli
    >>> loop = Loop("trials", ConstantStimuli([3.0], 2).begin())
    >>> for level, felt in zip(loop, [1, 0]):
    ...     loop.addResponse(felt)
    >>> loop.intensities, loop.data, loop.ending
    ([3.0, 3.0], [1, 0], 'trials')
    """

    def __init__(self, name: str, procedure: Procedure, n_attempts: int = BlockOptions.n_attempts) -> None:
        self.name, self.procedure, self._n_attempts = name, procedure, n_attempts
        self.intensities: list[float] = []
        self.data: list[int] = []
        self.thisN = -1
        self.aborted = False
        self._n_unanswered = 0
        self._experiment: Any = None

    def setExp(self, experiment: Any) -> None:  # noqa: N802 - PsychoPy's name
        """Called by `ExperimentHandler.addLoop`."""
        self._experiment = experiment

    @property
    def level(self) -> float | None:
        """The level that is due; None at the end."""
        return None if self.finished else self.procedure.level

    @property
    def finished(self) -> bool:
        return self.aborted or self.procedure.finished

    @property
    def ending(self) -> str | None:
        """How it came to its end; None if it goes on."""
        return "aborted" if self.aborted else self.procedure.ending

    @property
    def threshold(self) -> float | None:
        """What the rule makes of its answers."""
        return self.procedure.threshold

    def __iter__(self) -> Iterator[float]:
        return self

    def __next__(self) -> float:
        if self._n_unanswered >= self._n_attempts:
            self.aborted = True
        if self.finished:
            if self._experiment is not None:
                self._experiment.loopEnded(self)
            raise StopIteration
        self._n_unanswered += 1
        self.thisN += 1
        self.intensities.append(self.procedure.level)
        return self.procedure.level

    def addResponse(self, result: int | bool, intensity: float | None = None) -> None:  # noqa: N802 - PsychoPy's name
        """An answer (1: felt, or correct) to the level that is due, or to the one that was delivered in its place.

        Raises
        ------
        InvalidParameter
            If the procedure takes no such answer.
        """
        self._answer(result, intensity)
        self.addOtherData("response", int(result))

    def _answer(self, result: int | bool, delivered: float | None) -> None:
        self.procedure = self.procedure.after(result, delivered)
        self._n_unanswered = 0
        self.data.append(int(result))

    def hear(self, outcome: TrialOutcome) -> None:
        """What came of a trial, and its row; one that is not valid leaves its level due."""
        for name, value in of_trial(outcome).items():
            self.addOtherData(name, value)
        if outcome.valid and outcome.success is not None:
            delivered = None if outcome.stimulus is None else outcome.stimulus.level_delivered
            self._answer(outcome.success, delivered)

    def addOtherData(self, name: str, value: Any) -> None:  # noqa: N802 - PsychoPy's name
        """A value in the column of this name, for the row that is under way."""
        if self._experiment is not None:
            self._experiment.addData(f"{self.name}.{name}", value)

    addData = addOtherData  # noqa: N815 - PsychoPy's name
