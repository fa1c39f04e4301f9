"""Recording that answers the same requests again."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import fields, is_dataclass, replace
from itertools import takewhile
from typing import Any

from ..errors import Diverged
from ..trials.trial import Trial, without
from .answer import Answer, Done, Marked
from .request import A, Fill, Intervene, Record, Request, Show

OF_RECORDING = "use the study, the seed and the version of the recording"


def rows(requests: Iterable[Request[Any]]) -> tuple[Trial, ...]:
    """Return the rows that requests recorded, as they count in the end."""
    asked = tuple(requests)
    retracted = {key for request in asked if isinstance(request, Intervene) for key in request.retracted}
    return without((request.trial for request in asked if isinstance(request, Record)), retracted)


class Replay:
    """Answers from `entries`, pairs of (request, answer) in order.

    - `where`, `lines`: Name of the recording, and lines of its entries, for errors.
    - `as_kept`: What the recording keeps of a request.
    - `lasted_s`: Least duration of the session, s.
    - `marked`: Marks on the questionnaire page at which it was interrupted.

    Pages without an answer may differ between recording and protocol, so that a later version may show others. Words of
    a questionnaire in languages that the recording does not know may differ too.
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
        """When the session stopped: the time of the last answer, or of a later event."""
        marked_s = [] if self._marked is None else [self._marked.at_s]
        return float(max([self._lasted_s, *marked_s, *(_ended_s(answer) for _, answer in self._entries[-1:])]))

    def goes_on(self, request: Request[Any]) -> bool:
        """Return True if it contains more than pages that the protocol does not show."""
        left = (self._entries[n][0] for n in range(self._next, len(self._entries)))
        if not _is_page(request) and all(map(_is_page, left)):
            self._next = len(self._entries)
        return self.n_left > 0

    def taken_up(self, request: Request[Any]) -> Request[Any]:
        """Return the first request of a resumed sitting: a questionnaire page gets its marks back."""
        marked = self._marked
        if marked is None or not isinstance(request, Fill) or request.form != marked.form:
            return request
        is_page = len(marked.values) == len(request.questions)
        return replace(request, given=marked.values) if is_page else request

    def refuse_rest(self) -> None:
        """Raise if the recording contains more than was asked."""
        if self.n_left:
            name = _name(self._entries[self._next][0])
            raise self._divergence(f"the recording goes on with {name}, the protocol has ended; {OF_RECORDING}")

    def _divergence(self, what: str) -> Diverged:
        line = self._lines[self._next] if self.n_left else max(self._lines, default=0) + 1
        return Diverged(f"{self._where}, line {line}: {what}")

    def answer(self, request: Request[A]) -> A:
        """Return the recorded answer.

        Raises `Diverged`, with line and difference, if the request is not the recorded one.
        """
        if not self.n_left:
            ended = f"the recording has ended, the protocol requests {_name(request)}"
            raise self._divergence(f"{ended}; the session is not complete: continue with --resume")
        asked = self._as_kept(request)  # older journals recorded fewer fields of a request
        n_passed = self._pages_before(asked)
        if n_passed is None:
            return Done(self._at_s)  # type: ignore[return-value]
        self._next += n_passed
        recorded, answer = self._entries[self._next]
        asked = _in_its_languages(asked, recorded)
        if asked != recorded:
            raise self._divergence(f"{difference(recorded, asked)}; {OF_RECORDING}")
        self._next += 1
        self._at_s = _ended_s(answer)
        recorded_answer: A = answer  # each answer has the type of its recorded request
        return recorded_answer

    def _pages_before(self, asked: Request[Any]) -> int | None:
        """Return how many recorded pages to skip; None for a page that the recording lacks."""
        left = (self._entries[n][0] for n in range(self._next, len(self._entries)))
        pages = list(takewhile(_is_page, left))
        if isinstance(asked, Show):
            return pages.index(asked) if asked in pages else None
        return min(len(pages), self.n_left - 1)


def _in_its_languages(asked: Request[Any], recorded: Request[Any]) -> Request[Any]:
    """Limit the words of a questionnaire to the languages of the recorded page."""
    if not (isinstance(asked, Fill) and isinstance(recorded, Fill) and len(asked.questions) == len(recorded.questions)):
        return asked
    questions = []
    for question, then in zip(asked.questions, recorded.questions, strict=True):
        words = {language: said for language, said in question.words.items() if language in then.words}
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
        return f"{name}: the recording has {shown[0]}, the protocol requests {shown[1]}"
    for item in (item for item in fields(recorded) if item.compare):
        then, now = getattr(recorded, item.name), getattr(asked, item.name)
        if then != now:
            return difference(then, now, f"{path or _name(recorded)}.{item.name}")
    return f"{path or _name(recorded)}: equal"
