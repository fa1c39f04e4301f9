"""Tasks by name, with what their rows contain.

`protocols/tasks/NAME.py` defines how a task is asked, `analysis/tasks/NAME.py` how it is analysed.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Literal

from .cells import LARGEST_ANSWER, CellRule, number_from, one_of_texts, whole_number

LevelUse = Literal["curve", "scale", "ratio"]
"""What an analysis does with the levels of a task.

``curve``: the answers follow a psychometric function of the level, which no row but a catch trial may lack; ``scale``:
levels are put on the scale of the analysis; ``ratio``: they are taken as ratios, whatever the scale.
"""
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
"""In the column `procedure`: an easy trial, whose level the rule did not choose."""
ANYTHING: Final = CellRule("anything", lambda text: True)


@dataclass(frozen=True)
class TaskRows:
    """What the rows of a task hold.

    - `response`: What may stand in the column `response`, where it is not empty.
    - `columns`, `of_places`: Those of `columns.OPTIONAL` that it fills, always and where its stimuli have places.
    - `level`: What an analysis does with its levels; None: nothing.
    - `sets_level`: The response is a level, which the participant sets while it plays.
    - `is_read`: An analysis reads the responses: a table with others than the rule allows is refused.
    - `answers`: What the responses 0 and 1 mean, where these are the only ones.
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
"""Practice ends when so many of the last so many answers were right, unless a study states other numbers."""
PRACTICE_MISSED: Final = "the practice missed its criterion: "
"""Start of the text of an event; what the experimenter chose follows."""
FORM_TASK: Final = "rating"
"""The task of the rows that hold answers to a questionnaire, about a stimulus or on its own."""


def tasks_with_level(*uses: LevelUse) -> tuple[str, ...]:
    """Return the tasks whose levels an analysis uses in one of these ways.

    >>> tasks_with_level("ratio")
    ('magnitude',)
    """
    return tuple(name for name, rows in TASKS.items() if rows.level in uses)
