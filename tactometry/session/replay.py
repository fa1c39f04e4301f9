"""Replay of a recorded session, which answers the same requests again."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import fields, is_dataclass, replace
from itertools import takewhile
from typing import Any

from ..errors import Diverged
from ..trials.trial import Trial, without
from .answer import Answer, Done, Marked
from .request import A, Fill, Intervene, Record, Request, Show

OF_RECORDING = "use the study, seed and version with which it was recorded"


def rows(requests: Iterable[Request[Any]]) -> tuple[Trial, ...]:
    """Return the rows that requests recorded, after all retractions."""
    every = tuple(requests)
    retracted = {key for request in every if isinstance(request, Intervene) for key in request.retracted}
    return without((request.trial for request in every if isinstance(request, Record)), retracted)


class Replay:
    """Replay of `entries`, (request, answer) pairs in order.

    - `where`, `lines`: Name of the recording and line numbers of its entries, for error messages.
    - `as_kept`: Function that returns the part of a request that the recording contains.
    - `lasted_s`: Minimum duration of the session, s.
    - `marked`: Marks on the questionnaire page at which the session was interrupted.

    Two differences between recording and protocol are allowed, so that later versions can replay it: pages without an
    answer, and questionnaire texts in languages that the recording lacks.
    """

    def __init__(
        self,
        entries: Sequence[tuple[Request[Any], Any]],
        where: str = "recording",
        lines: Sequence[int] = (),
        as_kept: Callable[[Request[Any]], Request[Any]] = lambda request: request,
        lasted_s: float = 0.0,
        marked: Marked | None = None,
    ) -> None:
        self._entries = entries
        self._as_kept, self._lasted_s, self._marked = as_kept, lasted_s, marked
        self._where = where
        self._lines = lines or range(1, len(entries) + 1)
        self._next, self._at_s = 0, 0.0

    @property
    def n_left(self) -> int:
        return len(self._entries) - self._next

    @property
    def trials(self) -> list[Trial]:
        return list(rows(request for request, _ in self._entries))

    @property
    def elapsed_s(self) -> float:
        """Time at which the session stopped: of the last answer, or a later event."""
        marked_s = [] if self._marked is None else [self._marked.at_s]
        return float(max([self._lasted_s, *marked_s, *(_ended_s(answer) for _, answer in self._entries[-1:])]))

    def goes_on(self, request: Request[Any]) -> bool:
        """Return True if recorded requests remain that the protocol must repeat.

        Recorded pages at the end that the protocol no longer shows are skipped.
        """
        left = (self._entries[n][0] for n in range(self._next, len(self._entries)))
        if not _is_page(request) and all(map(_is_page, left)):
            self._next = len(self._entries)
        return self.n_left > 0

    def taken_up(self, request: Request[Any]) -> Request[Any]:
        """Return the first request of a resumed sitting, with marks of its page."""
        marked = self._marked
        if marked is None or not isinstance(request, Fill) or request.form != marked.form:
            return request
        is_page = len(marked.values) == len(request.questions)
        return replace(request, given=marked.values) if is_page else request

    def refuse_rest(self) -> None:
        """Raise `Diverged` if the recording contains further requests."""
        if self.n_left:
            name = _name(self._entries[self._next][0])
            raise self._divergence(f"the recording continues with {name}, but the protocol has ended; {OF_RECORDING}")

    def _divergence(self, what: str) -> Diverged:
        line = self._lines[self._next] if self.n_left else max(self._lines, default=0) + 1
        return Diverged(f"{self._where}, line {line}: {what}")

    def answer(self, request: Request[A]) -> A:
        """Return the recorded answer.

        Raises `Diverged`, with line and difference, if the recorded request is another one.
        """
        if not self.n_left:
            ended = f"the recording has ended, but the protocol requests {_name(request)}"
            raise self._divergence(f"{ended}; the session is not complete: continue with --resume")
        requested = self._as_kept(request)  # older journals recorded fewer fields of a request
        n_passed = self._pages_before(requested)
        if n_passed is None:
            return Done(self._at_s)  # type: ignore[return-value]
        self._next += n_passed
        recorded, answer = self._entries[self._next]
        requested = _in_its_languages(requested, recorded)
        if requested != recorded:
            raise self._divergence(f"{difference(recorded, requested)}; {OF_RECORDING}")
        self._next += 1
        self._at_s = _ended_s(answer)
        recorded_answer: A = answer  # each answer has the type of its recorded request
        return recorded_answer

    def _pages_before(self, asked: Request[Any]) -> int | None:
        """Return how many recorded pages to skip, or None for an unrecorded page."""
        left = (self._entries[n][0] for n in range(self._next, len(self._entries)))
        pages = list(takewhile(_is_page, left))
        if isinstance(asked, Show):
            return pages.index(asked) if asked in pages else None
        return min(len(pages), self.n_left - 1)


def _in_its_languages(asked: Request[Any], recorded: Request[Any]) -> Request[Any]:
    """Limit the texts of a questionnaire to the languages of the recording."""
    if not (isinstance(asked, Fill) and isinstance(recorded, Fill) and len(asked.questions) == len(recorded.questions)):
        return asked
    questions = []
    for question, then in zip(asked.questions, recorded.questions, strict=True):
        words = {language: text for language, text in question.words.items() if language in then.words}
        questions.append(replace(question, words=words))
    return replace(asked, questions=tuple(questions))


def _is_page(request: Request[Any]) -> bool:
    return isinstance(request, Show)


def _ended_s(answer: Any) -> float:
    return float(answer.onset_s + answer.latency_s if isinstance(answer, Answer) else getattr(answer, "at_s", 0.0))


def _name(request: object) -> str:
    return type(request).__name__


def difference(recorded: object, asked: object, path: str = "") -> str:
    """Describe where two requests differ."""
    if type(recorded) is not type(asked) or not is_dataclass(recorded):
        name = path or "request"
        shown = (_name(recorded), _name(asked)) if is_dataclass(recorded) else (repr(recorded), repr(asked))
        return f"{name}: the recording has {shown[0]}, but the protocol requests {shown[1]}"
    for item in (item for item in fields(recorded) if item.compare):
        then, now = getattr(recorded, item.name), getattr(asked, item.name)
        if then != now:
            return difference(then, now, f"{path or _name(recorded)}.{item.name}")
    return f"{path or _name(recorded)}: equal"
