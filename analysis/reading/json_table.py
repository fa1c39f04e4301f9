"""A table of trials in JSON, as jsPsych saves it: a list with an object for each trial."""

import json
from pathlib import Path

import pandas as pd

from tactometry.errors import InvalidFile


def json_cells(text: str, file: Path) -> pd.DataFrame:
    """All values as text, a column for each key, and in the column `row` the place in the list, from 1.

    Numbers stay as they were written, true and false are words, null and what an object has not are empty; a list or
    an object within stays JSON.

    Raises
    ------
    InvalidFile
        If it is no JSON, or another than a list of objects.

    >>> json_cells('[{"level": 0.10, "correct": true}, {"rt": null}]', Path("j.json")).values.tolist()
    [['0.10', 'true', '', 1], ['', '', '', 2]]
    """
    try:
        trials = json.loads(text, parse_float=str, parse_int=str, parse_constant=str)
    except (ValueError, RecursionError) as damage:
        raise InvalidFile(f"{file}: found no valid JSON ({damage}), expected a list of trials") from None
    if not isinstance(trials, list) or not all(isinstance(trial, dict) for trial in trials) or not trials:
        raise InvalidFile(f"{file}: found no list of objects, expected one for each trial, as jsPsych saves them")
    names = list(dict.fromkeys(name.strip() for trial in trials for name in trial))
    cells = [{name.strip(): _text(value) for name, value in trial.items()} for trial in trials]
    table = pd.DataFrame([[row.get(name, "") for name in names] for row in cells], columns=names, dtype=str)
    return table.assign(row=range(1, len(trials) + 1))


def _text(value: object) -> str:
    if value is None:
        return ""
    return value if isinstance(value, str) else json.dumps(value)
