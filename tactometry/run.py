"""The one loop that drives a protocol on any rig."""

from collections.abc import Generator
from typing import Any, Protocol, TypeVar

from tactometry.request import Request
from tactometry.rigs.replay import Replay
from tactometry.rigs.rig import Rig

T = TypeVar("T")
Course = Generator[Request, Any, T]
"""The course of an experiment: it yields requests, receives their answers, and returns what it found."""


class Keeper(Protocol):
    """Where requests and answers are kept; `entries` holds those of an earlier sitting."""

    @property
    def replay(course: Course[T], recording: Replay, *, complete: bool = True) -> T | None:
    """Drive `course` on a recording alone, to its end, or (not `complete`) as far as it goes.

    Raises
    ------
    Diverged
        At the first request that differs from the recording, or where one of the two ends before the other.
    """
    try:
        request = _advance(course, None)
        while complete or recording.n_left:
            request = _advance(course, request.put_to(recording))
    except _Ended as end:
        recording.refuse_rest()
        value: T = end.value  # type: ignore[assignment]
        return value
    return None
