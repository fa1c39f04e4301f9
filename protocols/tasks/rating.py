"""Questionnaires, after a stimulus or alone."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
from annotated_types import Ge, Interval

from tactometry.arguments.constraints import constrained
from tactometry.arguments.require import of_kind
from tactometry.questionnaire import Item, Questionnaire
from tactometry.session.answer import Filled, Touched
from tactometry.session.request import Fill, Question
from tactometry.session.run import Course

from .task import Presentation, Reply, Task, TaskKind, TrialCourse, TrialOutcome

N_PER_PAGE, N_STATEMENTS_PER_PAGE = 7, 5
MOST_TOUCHES = 1000
"""Largest number of touches before a rating."""


def pages(form: Questionnaire, items: Sequence[Item]) -> list[Fill]:
    """Divide the items into pages of nearly equal length."""
    most = N_STATEMENTS_PER_PAGE if any(item.statement for item in items) else N_PER_PAGE
    n_pages = -(-len(items) // most)
    n_each = -(-len(items) // n_pages)
    questions = [
        Question(item.id, {name: form.words(item.id, name) for name in form.languages}, item.reversed) for item in items
    ]
    by_page = [tuple(questions[start : start + n_each]) for start in range(0, len(items), n_each)]
    scale = form.low, form.high, form.steps
    return [
        Fill(form.name, of_page, *scale, stem=form.stem, page=number, n_pages=n_pages)
        for number, of_page in enumerate(by_page, 1)
    ]


def fill_in(form: Questionnaire, rng: np.random.Generator, *, shuffled: bool) -> Course[tuple[Reply, ...]]:
    """Ask the pages, allow going back, and return the replies in order."""
    order = rng.permutation(len(form.items)) if shuffled else range(len(form.items))
    requests = pages(form, [form.items[int(n)] for n in order])
    filled: dict[int, Filled] = {}
    at = 0
    while at < len(requests):
        given = filled[at].values if at in filled else ()
        filled[at] = yield replace(requests[at], given=given)
        at = max(at - 1, 0) if filled[at].back else at + 1
    return tuple(
        Reply(filled[number], value, item=question.item)
        for number, page in enumerate(requests)
        for question, value in zip(page.questions, filled[number].values, strict=True)
    )


@dataclass(frozen=True)
@constrained
class Rating(Task):
    """A stimulus, felt `n_touches` times, then a questionnaire, a row per item."""

    form: Questionnaire
    shuffled: bool = False
    n_touches: Annotated[int, Ge(1)] = 1

    name = "rating"

    def __post_init__(self) -> None:
        of_kind("Rating", Questionnaire, form=self.form)

    def trial(self, shown: Presentation, rng: np.random.Generator) -> TrialCourse:
        touches: list[Touched] = []
        while len(touches) < self.n_touches and all(touch.valid for touch in touches):
            touches.append((yield shown.touch.request(shown.stimulus, shown.level, None)))
        if not touches[-1].valid:
            return TrialOutcome(tuple(touches), touches[-1], rule=self.form.name)
        replies = yield from fill_in(self.form, rng, shuffled=self.shuffled)
        return TrialOutcome(tuple(touches), touches[-1], replies, rule=self.form.name)


@dataclass(frozen=True)
@constrained
class RatingTable:
    """Questionnaire by its name.

    - `form`: Name of a shipped questionnaire, or of one in `[forms]`.
    - `shuffled`: True if the order of its items is drawn for each participant.
    - `n_touches`: Number of touches of the stimulus before it is rated.
    """

    form: str
    shuffled: bool = False
    n_touches: Annotated[int, Interval(ge=1, le=MOST_TOUCHES)] = 1


TASK = TaskKind(
    RatingTable,
    example={"form": "sus"},
    made=lambda table, form_of: Rating(form_of(table.form), table.shuffled, table.n_touches),
)
