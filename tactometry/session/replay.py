"""A recording that answers, if it is asked what was asked then."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import fields, is_dataclass
from typing import Any

from ..errors import Diverged
from ..trials.trial import Trial, without
from .request import A, Intervene, Record, Request

OF_RECORDING = "use the study, the seed and the version of the recording"


def rows(requests: Iterable[Request[Any]]) -> tuple[Trial, ...]:
    """The rows that requests recorded, as they count after all of them."""
    asked = tuple(requests)
    retracted = {key for request in asked if isinstance(request, Intervene) for key in request.retracted}
    return without((request.trial for request in asked if isinstance(request, Record)), retracted)


class Replay:
    """What answers from `entries`, pairs of (request, answer) in their order.

    `where` names the recording in errors, `lines` the lines of its entries, where they are not 1, 2, 3, ..., and
    `as_kept` is what the recording keeps of a request. The session lasted `lasted_s` at least, s.
    """

    def __init__(
        self,
        entries: Sequence[tuple[Request[Any], Any]],
        where: str = "recording",
        lines: Sequence[int] = (),
        as_kept: Callable[[Request[Any]], Request[Any]] = lambda request: request,
        lasted_s: float = 0.0,
    ) -> None:
        self._entries = entries
        self._as_kept, self._lasted_s = as_kept, lasted_s
        self._where = where
        self._lines = lines or range(1, len(entries) + 1)
        self._next = 0

    @property
    def n_left(self) -> int:
        return len(self._entries) - self._next

    @property
    def trials(self) -> list[Trial]:
        """The recorded rows."""
        return list(rows(request for request, _ in self._entries))

    @property
    def elapsed_s(self) -> float:
        """When the session stopped: the time of the last recorded trial, or of what happened after it."""
        times_s = [answer.at_s for request, answer in self._entries if isinstance(request, Record)]
        return float(max([self._lasted_s, *times_s[-1:]]))

    def refuse_rest(self) -> None:
        """Raise if the recording holds more than was asked."""
        if self.n_left:
            name = _name(self._entries[self._next][0])
            raise self._divergence(f"the recording goes on with {name}, the protocol has ended; {OF_RECORDING}")

    def _divergence(self, what: str) -> Diverged:
        line = self._lines[self._next] if self.n_left else max(self._lines, default=0) + 1
        return Diverged(f"{self._where}, line {line}: {what}")

    def answer(self, request: Request[A]) -> A:
        """What was answered then.

        Raises
        ------
        Diverged
            If the request is not the recorded one, with its line and what differs.
        """
        if not self.n_left:
            ended = f"the recording has ended, the protocol asks for {_name(request)}"
            raise self._divergence(f"{ended}; the session is not complete: go on with --resume")
        recorded, answer = self._entries[self._next]
        asked = self._as_kept(request)  # an older journal kept less of a request
        if asked != recorded:
            raise self._divergence(f"{difference(recorded, asked)}; {OF_RECORDING}")
        self._next += 1
        recorded_answer: A = answer  # the entries are pairs: this answer is of the recorded request's type
        return recorded_answer


def _name(request: object) -> str:
    return type(request).__name__


def difference(recorded: object, asked: object, path: str = "") -> str:
    """Where two requests part, in words."""
    if type(recorded) is not type(asked) or not is_dataclass(recorded):
        name = path or "request"
        shown = (_name(recorded), _name(asked)) if is_dataclass(recorded) else (repr(recorded), repr(asked))
        return f"{name}: the recording holds {shown[0]}, the protocol asks for {shown[1]}"
    for item in fields(recorded):
        then, now = getattr(recorded, item.name), getattr(asked, item.name)
        if then != now:
            return difference(then, now, f"{path or _name(recorded)}.{item.name}")
    return f"{path or _name(recorded)}: equal"
