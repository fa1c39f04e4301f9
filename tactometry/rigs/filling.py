"""How a page of a questionnaire that is asked for becomes one of the screen, and its marks become values."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field

from ..session.answer import Marked
from ..session.answer_rules import value_at
from ..session.request import Fill
from .pages import form, layout
from .texts import Texts

KEPT_EVERY_S = 0.2
"""Marks that change faster, as those of a drag do, are kept so often."""
Values = tuple[float | None, ...]


def n_positions(request: Fill) -> int:
    """How many places a scale has on the screen."""
    return layout.N_POSITIONS_CONTINUOUS if request.steps is None else request.steps


def form_of(request: Fill, texts: Texts) -> form.Form:
    """The page in the participant's language."""
    first, several = request.page == 1, request.n_pages > 1
    words = form.FormWords(
        hint=texts.message(form.hint_for(request.steps)),
        gaps=texts.message("hint_gaps"),
        stem=texts.in_language(request.stem),
        count=texts.message("page_count", {"page": request.page, "n_pages": request.n_pages}) if several else "",
        back="" if first else texts.message("page_back"),
        leave_open=texts.message("leave_open"),
    )
    return form.Form(
        rows=tuple(texts.question(question) for question in request.questions),
        n_positions=n_positions(request),
        rings=request.steps is not None,
        words=words,
    )


def place_at(value: float | None, request: Fill) -> int | None:
    """The place that is nearest to a value.

    >>> place_at(3.0, Fill("f", (), low=1.0, high=7.0, steps=7))
    2
    """
    if value is None:
        return None
    last = n_positions(request) - 1
    return min(max(round((value - request.low) / (request.high - request.low) * last), 0), last)


def marks_of(request: Fill) -> form.Marks:
    """What stands on a page when it comes."""
    given = request.given or (None,) * len(request.questions)
    return form.begun(tuple(place_at(value, request) for value in given))


def values_of(marks: form.Marks, request: Fill) -> Values:
    """The value of each mark; None where there is none."""
    n, low, high = n_positions(request), request.low, request.high
    return tuple(None if place is None else value_at(place, n, low, high) for place in marks.places)


@dataclass
class Keeping:
    """Keeps the marks of a page as they change, each frame that it is called in."""

    request: Fill
    keep: Callable[[Marked], None]
    session_s: Callable[[float], float]
    _kept: Values = ()
    _kept_s: float = field(default=-float("inf"))

    def __post_init__(self) -> None:
        self._kept = values_of(marks_of(self.request), self.request)

    def __call__(self, marks: form.Marks) -> None:
        values, now_s = values_of(marks, self.request), time.perf_counter()
        if values != self._kept and now_s - self._kept_s >= KEPT_EVERY_S:
            self.keep(Marked(self.request.form, values, self.session_s(now_s)))
            self._kept, self._kept_s = values, now_s
