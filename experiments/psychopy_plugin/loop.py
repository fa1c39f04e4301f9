"""PsychoPy loop over a procedure's levels, and its data rows."""

from collections.abc import Iterator
from typing import Any

from tactometry.protocols.block_state import BlockOptions
from tactometry.protocols.procedures.procedure import Procedure
from tactometry.protocols.tasks.task import Reply, TrialOutcome
from tactometry.questionnaire import ChoiceForm, Questionnaire
from tactometry.session.answer import Played, Touched


class Loop:
    """Iterator over a procedure's levels. Repeats levels without an answer.

    - `name`: Prefix of the loop's columns.
    - `procedure`: Procedure in its initial state.
    - `n_attempts`: Number of successive levels without an answer after which the loop ends.

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
        """Set the experiment handler. `ExperimentHandler.addLoop` calls this."""
        self._experiment = experiment

    @property
    def level(self) -> float | None:
        """Current level, or None at the end."""
        return None if self.finished else self.procedure.level

    @property
    def finished(self) -> bool:
        return self.aborted or self.procedure.finished

    @property
    def ending(self) -> str | None:
        """Reason why the procedure ended, or None before its end."""
        return "aborted" if self.aborted else self.procedure.ending

    @property
    def threshold(self) -> float | None:
        """Threshold that the procedure estimates from the answers."""
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
        """Record the answer to the current level: 1 (felt, correct) or 0.

        `intensity` is the delivered level, if it differs.

        Raises `InvalidParameter` if the procedure does not accept this answer.
        """
        self._answer(result, intensity)
        self.addOtherData("response", int(result))

    def _answer(self, result: int | bool, delivered: float | None) -> None:
        self.procedure = self.procedure.after(result, delivered)
        self._n_unanswered = 0
        self.data.append(int(result))

    def hear(self, outcome: TrialOutcome) -> None:
        """Record a trial's result. An invalid trial repeats its level."""
        for name, value in of_trial(outcome).items():
            self.addOtherData(name, value)
        if outcome.valid and outcome.success is not None:
            delivered = None if outcome.stimulus is None else outcome.stimulus.level_delivered
            self._answer(outcome.success, delivered)

    def addOtherData(self, name: str, value: Any) -> None:  # noqa: N802 - PsychoPy's name
        """Store a value in a column of the current row."""
        if self._experiment is not None:
            self._experiment.addData(f"{self.name}.{name}", value)

    addData = addOtherData  # noqa: N815 - PsychoPy's name


Values = dict[str, float | str]
OF_A_TOUCH = ("level_delivered", "force_mean_n", "force_sd_n", "force_in_band", "speed_mean_m_per_s", "speed_in_band")


def _stated(**values: float | str | None) -> Values:
    """Return the known values, with booleans as 1 and 0."""
    known = {name: value for name, value in values.items() if value is not None}
    return {name: int(value) if isinstance(value, bool) else value for name, value in known.items()}


def of_touch(touch: Touched) -> Values:
    """Return the row values of a touch.

    >>> of_touch(Touched(0.0, 40.0, "c0ffee", force_mean_n=0.52, valid=False, invalid_reason="timeout"))
    {'level_delivered': 40.0, 'force_mean_n': 0.52, 'valid': 0, 'invalid_reason': 'timeout'}
    """
    measured = {name: getattr(touch, name) for name in (*OF_A_TOUCH, "n_gaps")}
    return _stated(**measured, valid=touch.valid, invalid_reason=touch.invalid_reason)


def of_stimulus(played: Played) -> Values:
    """Return the row values of a stimulus that played during a routine.

    >>> of_stimulus(Played(0.0, 40.0, "c0ffee"))
    {'level_delivered': 40.0, 'digest': 'c0ffee'}
    """
    return _stated(level_delivered=played.level_delivered, n_gaps=played.n_gaps, digest=played.digest or None)


def of_trial(outcome: TrialOutcome) -> Values:
    """Return the row values of a trial: counted touch and first answer.

    >>> of_trial(TrialOutcome((), replies=()))
    {'valid': 0}
    """
    reply = outcome.replies[0] if outcome.replies else Reply(None, None)
    row = {} if outcome.stimulus is None else of_touch(outcome.stimulus)
    return row | _stated(
        valid=outcome.valid,
        invalid_reason=outcome.invalid_reason,
        target=outcome.target,
        response=reply.response,
        correct=outcome.correct if outcome.replies else None,
        latency_s=None if reply.answer is None else reply.answer.latency_s,
    )


def of_reply(form: Questionnaire | ChoiceForm, reply: Reply) -> dict[str, float | str | None]:
    """Return the row values of an item, with the category of a choice.

    >>> from tactometry.questionnaire import load_choices
    >>> of_reply(load_choices("demographics"), Reply(None, 1.0, item="handedness"))
    {'item': 'handedness', 'response': 1.0, 'category': 'right'}
    """
    row: dict[str, float | str | None] = {"item": reply.item, "response": reply.response}
    if not isinstance(form, ChoiceForm):
        return row
    item = None if reply.item is None else form.item(reply.item)
    code = 0 if item is None or reply.response is None or item.bounds is not None else int(reply.response)
    return row | {"category": "" if item is None else item.category(code)}
