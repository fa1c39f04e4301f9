"""Interventions of the experimenter during and between blocks."""

from collections.abc import Iterable
from typing import Any, Final, TypeVar

from tactometry.session.answer import Done, Intervention
from tactometry.session.request import Intervene, Record, Request, Show
from tactometry.session.run import Course
from tactometry.trials.trial import Trial

T = TypeVar("T")
BETWEEN: Final = "the page that comes next waits for the participant: that is a rest"


def heard(requests: Iterable[Record | Show]) -> Course[tuple[Intervention, ...]]:
    """Make all requests and return the experimenter's interventions."""
    wanted: list[Intervention] = []
    for request in requests:
        done: Done = yield request
        wanted += done.interventions
    return tuple(wanted)


def hearing(course: Course[T], wanted: list[Intervention], felt: list[Trial]) -> Course[T]:
    """Run a course; collect interventions in `wanted`, felt trials in `felt`."""
    answer: Any = None
    while True:
        try:
            request: Request[Any] = course.send(answer)
        except StopIteration as stop:
            value: T = stop.value
            return value
        if isinstance(request, Record) and request.trial.valid and not request.trial.catch:
            felt.append(request.trial)
        answer = yield request
        if isinstance(answer, Done):
            wanted += answer.interventions


def not_asked_again(intervention: Intervention) -> Intervene:
    """Return the request that invalidates a trial of a finished block."""
    trials = () if intervention.trial is None else (intervention.trial,)
    number = "".join(f" {trial}" for _, trial, _ in trials)
    return Intervene(intervention, f"trial{number} does not count, and is not asked again: its block is over", trials)


def between_blocks(wanted: Iterable[Intervention], ahead: str = "") -> Course[bool]:
    """Carry out interventions. Return True if the part `ahead` is skipped."""
    skipped = False
    for intervention in wanted:
        match intervention.wanted:
            case "invalidate":
                yield not_asked_again(intervention)
            case "rest":
                yield Intervene(intervention, BETWEEN)
            case "skip":
                yield Intervene(intervention, f"{ahead} is skipped" if ahead else "there is no block to skip here")
                skipped = bool(ahead)
            case "end":
                yield Intervene(intervention, "the session ends")
                skipped = bool(ahead)
    return skipped
