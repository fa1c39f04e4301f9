"""Questionnaires as protocols: after a stimulus, or on their own."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tactometry.arguments.require import of_kind, whole
from tactometry.questionnaire import Item, Questionnaire
from tactometry.session.answer import Filled, Touched
from tactometry.session.request import Fill, Question
from tactometry.session.run import Course

from .task import Presentation, Reply, Task, TaskKind, TrialCourse, TrialOutcome

N_PER_PAGE, N_STATEMENTS_PER_PAGE = 7, 5
MOST_TOUCHES = 1000
"""Before one rating."""


def pages(form: Questionnaire, items: Sequence[Item]) -> list[Fill]:
    """The items on as many equally long pages as they need."""
    most = N_STATEMENTS_PER_PAGE if any(item.statement for item in items) else N_PER_PAGE
    n_pages = -(-len(items) // most)
    n_each = -(-len(items) // n_pages)
    by_page = [items[start : start + n_each] for start in range(0, len(items), n_each)]
    questions = [tuple(_question(form, item) for item in of_page) for of_page in by_page]
    scale = form.low, form.high, form.steps
    return [
        Fill(form.name, of_page, *scale, stem=form.stem, page=number, n_pages=n_pages)
        for number, of_page in enumerate(questions, 1)
    ]


def _question(form: Questionnaire, item: Item) -> Question:
    words: Mapping[str, tuple[str, str, str]] = {name: form.words(item.id, name) for name in form.languages}
    return Question(item.id, words, item.reversed)


def fill_in(form: Questionnaire, rng: np.random.Generator, *, shuffled: bool) -> Course[tuple[Reply, ...]]:
    """Page after page, and back where it is wished: a reply for each item in the order of its presentation, as its page
    was left last."""
    order = rng.permutation(len(form.items)) if shuffled else range(len(form.items))
    asked = pages(form, [form.items[int(n)] for n in order])
    filled: dict[int, Filled] = {}
    at = 0
    while at < len(asked):
        given = filled[at].values if at in filled else ()
        filled[at] = yield replace(asked[at], given=given)
        at = max(at - 1, 0) if filled[at].back else at + 1
    return tuple(reply for number, page in enumerate(asked) for reply in _replies(page, filled[number]))


def _replies(page: Fill, filled: Filled) -> list[Reply]:
    pairs = zip(page.questions, filled.values, strict=True)
    return [Reply(filled, value, item=question.item) for question, value in pairs]


@dataclass(frozen=True)
class Rating(Task):
    """A stimulus, felt `n_touches` times, then a questionnaire about it. A row for each item.

    Raises `InvalidParameter` if `form` is no questionnaire, or `n_touches` below 1.
    """

    form: Questionnaire
    shuffled: bool = False
    n_touches: int = 1

    name = "rating"

    def __post_init__(self) -> None:
        of_kind("Rating", Questionnaire, form=self.form)
        whole("Rating", lowest=1, n_touches=self.n_touches)

    def trial(self, shown: Presentation, rng: np.random.Generator) -> TrialCourse:
        touches: list[Touched] = []
        while len(touches) < self.n_touches and all(touch.valid for touch in touches):
            touches.append((yield shown.touch.request(shown.stimulus, shown.level, None)))
        if not touches[-1].valid:
            return TrialOutcome(tuple(touches), touches[-1], rule=self.form.name)
        replies = yield from fill_in(self.form, rng, shuffled=self.shuffled)
        return TrialOutcome(tuple(touches), touches[-1], replies, rule=self.form.name)


@dataclass(frozen=True)
class RatingTable:
    """A questionnaire by its name.

    - `form`: The questionnaire: a shipped one, or one of `[forms]`.
    - `shuffled`: Whether its items come in an order drawn for each participant.
    - `n_touches`: How often the stimulus is felt before it is rated.
    """

    form: str
    shuffled: bool = False
    n_touches: int = 1

    def __post_init__(self) -> None:
        whole("RatingTable", lowest=1, highest=MOST_TOUCHES, n_touches=self.n_touches)


TASK = TaskKind(
    RatingTable,
    example={"form": "sus"},
    made=lambda table, form_of: Rating(form_of(table.form), table.shuffled, table.n_touches),
)
