"""Loop that runs a protocol on any rig."""

from collections.abc import Callable, Generator
from typing import Any, Protocol, TypeVar

from .answer import Done
from .replay import Replay
from .request import A, Feel, Intervene, Request, Rig

T = TypeVar("T")
Course = Generator[Request[Any], Any, T]
"""Generator of an experiment: yields requests, receives their answers, and returns a result."""


class Keeper(Protocol):
    """Store of requests and answers. `replay` contains those of earlier sittings."""

    @property
    def replay(self) -> Replay: ...

    def append(self, request: Request[Any], answer: object) -> None: ...

    def finish(self) -> None: ...


class LiveRig:
    """Base class of rigs, with a private method for each kind of request.

    For example, `answer` passes a `Play` to `_play` and a `Press` to `_feel`.
    """

    def answer(self, request: Request[A]) -> A:
        kind = Feel if isinstance(request, Feel) else type(request)
        method: Callable[[Request[A]], A] = getattr(self, f"_{kind.__name__.lower()}")
        return method(request)

    def _intervene(self, request: Intervene) -> Done:
        """Refuse an intervention, as this rig's answers cannot contain any."""
        raise NotImplementedError(f"{type(self).__name__}: found {request}, and its answers hold no intervention")


class _Ended(Exception):  # noqa: N818
    def __init__(self, value: object) -> None:
        self.value = value


def _advance(course: Course[T], answer: object) -> Request[Any]:
    try:
        return course.send(answer)
    except StopIteration as stop:
        raise _Ended(stop.value) from None


def run(course: Course[T], rig: Rig, journal: Keeper) -> T:
    """Run `course` to its end: replay the journal, then ask `rig`.

    Each answer is in the journal before the next request. The rig is always closed.

    Raises `Diverged` if a request differs from the one in the journal.
    """
    recorded = journal.replay
    try:
        request = _advance(course, None)
        while recorded.goes_on(request):
            request = _advance(course, recorded.answer(request))
        if recorded.elapsed_s:
            rig.resume(recorded.trials, recorded.elapsed_s)
        request = recorded.taken_up(request)
        while True:
            answer = rig.answer(request)
            journal.append(request, answer)  # recorded before the course continues, so that a replay has every answer
            request = _advance(course, answer)
    except _Ended as end:
        recorded.refuse_rest()
        try:
            rig.close()  # close before the journal ends, as the rig records the charge of the last stimulus
        finally:
            journal.finish()
        value: T = end.value  # type: ignore[assignment]
        return value
    finally:
        rig.close()


def replay(course: Course[T], recording: Replay, *, complete: bool = True) -> T | None:
    """Run `course` on a recording only.

    Unless `complete`, it may end where the recording ends. Raises `Diverged` at the first difference, or if one ends
    before the other.
    """
    try:
        request = _advance(course, None)
        while recording.goes_on(request) or complete:
            request = _advance(course, recording.answer(request))
    except _Ended as end:
        recording.refuse_rest()
        value: T = end.value  # type: ignore[assignment]
        return value
    return None
