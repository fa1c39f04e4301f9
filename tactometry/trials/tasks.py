"""Tasks by name, with the contents of their rows.

`protocols/tasks/NAME.py` defines how a task is presented, `analysis/tasks/NAME.py` how it is analysed.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Literal

from .cells import LARGEST_ANSWER, CellRule, number_from, one_of_texts, whole_number

LevelUse = Literal["curve", "scale", "ratio"]
"""Use of the levels of a task in an analysis. ``curve``: responses follow a psychometric function of the level, which
is required except in catch trials. ``scale``: levels are converted to the scale of the analysis. ``ratio``: levels are
treated as ratios on any scale.

``curve``: responses follow a psychometric function of the level, which is required except in catch trials; ``scale``:
levels are converted to the scale of the analysis; ``ratio``: levels are treated as ratios on any scale."""
Columns = tuple[str, ...]

ANSWER_WITHIN: Final = f"within {LARGEST_ANSWER:g}, or nothing"
YES_OR_NO: Final = CellRule("1, 0 or nothing", one_of_texts("0", "1"))
INTERVAL: Final = CellRule("the number of an interval, from 1 to 999, or nothing", whole_number(999))
ALTERNATIVE: Final = CellRule("the number of an alternative, from 1, or nothing", whole_number())
FIRST_OR_SECOND: Final = CellRule("1 (item was preferred), 2 (item_b) or nothing", one_of_texts("1", "2"))
STRENGTH: Final = CellRule(f"a number from 0 to {LARGEST_ANSWER:g}, or nothing", number_from(0, LARGEST_ANSWER))
SET_LEVEL: Final = CellRule(f"the level that was set, {ANSWER_WITHIN}", number_from(-LARGEST_ANSWER, LARGEST_ANSWER))
RAW_VALUE: Final = CellRule(
    f"the raw value of the answer, {ANSWER_WITHIN}", number_from(-LARGEST_ANSWER, LARGEST_ANSWER)
)
EASY: Final = "easy"
"""Value of the column `procedure` for an easy trial, whose level was not chosen by the rule."""
ANYTHING: Final = CellRule("anything", lambda text: True)


@dataclass(frozen=True)
class TaskRows:
    """Contents of the rows of a task.

    - `response`: Rule of the column `response`, unless it is empty.
    - `columns`, `of_places`: Columns of `columns.OPTIONAL` that it fills always, or if its stimuli have places.
    - `level`: Use of its levels in an analysis, or None.
    - `sets_level`: True if the response is a level that the participant sets while it plays.
    - `is_read`: True if an analysis reads the responses, so that a table with invalid ones is refused.
    - `answers`: Meaning of the responses 0 and 1, if these are the only ones.
    """

    response: CellRule
    columns: Columns = ()
    level: LevelUse | None = None
    sets_level: bool = False
    is_read: bool = True
    of_places: Columns = ()
    answers: tuple[str, str] = ("no", "yes")


TASKS: Final[Mapping[str, TaskRows]] = {
    "yes_no": TaskRows(YES_OR_NO, level="curve"),
    "forced_choice": TaskRows(INTERVAL, ("target",), "curve"),
    "comparison": TaskRows(YES_OR_NO, ("target", "standard_level"), "curve", answers=("less", "more")),
    "same_different": TaskRows(YES_OR_NO, ("target", "standard_level"), "scale", answers=("same", "different")),
    "magnitude": TaskRows(STRENGTH, level="ratio"),
    "adjustment": TaskRows(SET_LEVEL, level="scale", sets_level=True),
    "rating": TaskRows(RAW_VALUE, ("item",), is_read=False),
    "localisation": TaskRows(ALTERNATIVE, ("target",), of_places=("separation_m", "error_m")),
    "preference": TaskRows(FIRST_OR_SECOND, ("item", "item_b")),
    "measurement": TaskRows(ANYTHING, ("level_measured",), is_read=False),
}
PRACTICE_CRITERION: Final = (4, 5)
"""Default criterion of practice: number of correct answers among the last ones."""
PRACTICE_MISSED: Final = "the practice missed its criterion: "
"""Beginning of the text of an event, followed by the experimenter's choice."""
FORM_TASK: Final = "rating"
"""Task of the rows with answers to a questionnaire, with or without a stimulus."""


def tasks_with_level(*uses: LevelUse) -> tuple[str, ...]:
    """Return the tasks whose levels an analysis uses in one of these ways.

    >>> tasks_with_level("ratio")
    ('magnitude',)
    """
    return tuple(name for name, rows in TASKS.items() if rows.level in uses)
