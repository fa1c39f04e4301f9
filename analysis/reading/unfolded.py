"""Conversion of counts and jsPsych surveys to one row per answer."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd

from tactometry.errors import InvalidFile, count_of
from tactometry.files.json_file import json_value
from tactometry.trials.row_rules import rows_text
from tactometry.trials.tasks import FORM_TASK

from .rows import expect_column, numbers_of

POSITIVE, TOTAL = "n_positive", "n_trials"
"""Columns of a table of counts: number of "yes" or correct answers, and number of all answers."""
COUNTED = "counts"
"""Value of `procedure` in rows made from counts, whose order has no meaning."""
CHOICE = "forced_choice"
ALTERNATIVES = "n_alternatives"
MOST_COUNTED = 10_000_000
"""Largest number of trials in a table of counts (unverified default)."""


def counted_trials(table: pd.DataFrame, file: Path) -> pd.DataFrame:
    """Return a row for each trial of a table of counts.

    Positive answers are spread evenly over the trials of their row, as their order is not known.

    Raises `InvalidFile` if the column of totals is missing, or if a row lacks counts or has more positive answers than
    trials.
    """
    if POSITIVE not in table.columns:
        return table
    expect_column(table, TOTAL, file, f", the number of trials that {POSITIVE} refers to")
    positive, total = (numbers_of(table[name].str.strip()).to_numpy() for name in (POSITIVE, TOTAL))
    is_count = (positive >= 0) & (positive <= total) & (positive % 1 == 0) & (total % 1 == 0)
    if not is_count.all():
        wrong = table[~is_count]
        found = " of ".join(wrong[name].iloc[0] or "nothing" for name in (POSITIVE, TOTAL))
        first, *others = wrong["row"]
        raise InvalidFile(
            f"{file}{rows_text(first, others, len(wrong))}: found {found} ({POSITIVE} of {TOTAL}), expected whole "
            f"numbers, with {POSITIVE} not above {TOTAL}"
        )
    if total.sum() > MOST_COUNTED:
        raise InvalidFile(f"{file}: found {total.sum():g} trials in counts, expected at most {MOST_COUNTED}")
    times = total.astype(np.int64)
    place = np.arange(times.sum()) - np.repeat(np.cumsum(times) - times, times)
    k, n = np.repeat(positive, times), np.repeat(total, times)
    is_yes = np.floor((place + 1) * k / n) > np.floor(place * k / n)
    rows = table.loc[table.index.repeat(times)].drop(columns=[POSITIVE, TOTAL, "trial"], errors="ignore")
    answers = np.where(is_yes, "1", "0")
    name = "correct" if "task" in rows.columns and (rows["task"] == CHOICE).any() else "response"
    return rows.assign(**{name: answers}).assign(procedure=COUNTED).reset_index(drop=True)


def with_responses(table: pd.DataFrame, file: Path) -> pd.DataFrame:
    """Add responses to forced choices that are only scored as correct.

    The chosen interval is then unknown: 1 stands for a correct answer, 2 for an incorrect one.

    Raises `InvalidFile` if the number of alternatives is unknown.
    """
    is_choice = {"task", "correct"} <= set(table.columns) and (table["task"] == CHOICE).all()
    if "response" in table.columns or not is_choice:
        return table
    why = f"; if only 'correct' is known, set {ALTERNATIVES} = 2 in [constants] of the column map"
    expect_column(table, ALTERNATIVES, file, why)
    return table.assign(response=table["correct"].map({"1": "1", "0": "2"}).fillna(""))


def survey_answers(table: pd.DataFrame, file: Path, warn: Callable[[str], None]) -> pd.DataFrame:
    """Return one row for each item of a jsPsych survey."""
    if not {"task", "response"} <= set(table.columns):
        return table
    nested = table["response"].str.startswith("{")
    answers = {place: _object(text) for place, text in table.loc[nested, "response"].items()}
    answers = {place: items for place, items in answers.items() if items}
    if not answers:
        return table
    times = [len(answers.get(place, "1")) for place in table.index]
    rows = table.loc[table.index.repeat(times)]
    is_item = rows.index.isin(list(answers))
    items = [item for place in table.index if place in answers for item in answers[place].items()]
    said = {"item": [key for key, _ in items], "response": [text for _, text in items], "task": FORM_TASK}
    for name, texts in said.items():
        column = np.full(len(rows), "", dtype=object)
        if name in rows.columns:
            column[:] = rows[name]
        column[is_item] = texts
        rows = rows.assign(**{name: column})
    where = f"{file.name}, row {table['row'][table.index.isin(list(answers))].iloc[0]}"
    warn(f"{count_of(len(answers), 'row')} of survey answers read as the task {FORM_TASK} (the first: {where})")
    return rows.reset_index(drop=True)


def _object(text: str) -> dict[str, str]:
    """Read a JSON object of answers; other text returns an empty dict.

    >>> _object('{"Q0": 3, "Q1": "often"}'), _object("{left}")
    ({'Q0': '3', 'Q1': 'often'}, {})
    """
    try:
        value = json_value(text)
    except ValueError:
        return {}
    return {str(name): "" if held is None else str(held) for name, held in value.items()}
