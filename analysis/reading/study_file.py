"""What the study of a data set states: a table of its `study.toml`, and the questionnaires that it may ask."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from tactometry.arguments.require import expect
from tactometry.config.toml import errors_in, read_table
from tactometry.questionnaire import (
    ChoiceForm,
    Questionnaire,
    choice_forms_of,
    load,
    load_choices,
    questionnaires_of,
    shipped_choices,
    shipped_names,
)

T = TypeVar("T")


@dataclass(frozen=True)
class StudyText:
    """The study's title and procedure in words, and the force (N) that was asked for where it is no factor."""

    title: str = ""
    procedure: str = ""
    force_n: float | None = None


def study_table(path: Path, name: str, read: Callable[[Mapping[str, Any]], T]) -> T:
    """What `read` makes of a table of the study in the folder `path`; of an empty one where there is none.

    Raises
    ------
    InvalidFile
        If the study cannot be read, or `read` refuses its table.
    """
    file = path / "study.toml"
    table = read_table(file, "the study that ran").get(name, {}) if file.is_file() else {}
    with errors_in(file):
        expect(isinstance(table, Mapping), name, f"{table!r:.60}", "a table")
        return read(table)


def forms_of(path: Path) -> Mapping[str, Questionnaire]:
    """The questionnaires that a data set may hold: the shipped ones, and those of its study's `[forms.NAME]`.

    Raises
    ------
    InvalidFile
        As `study_table`.

    >>> "attrakdiff" in forms_of(Path("no data set"))
    True
    """
    return {name: load(name) for name in shipped_names()} | study_table(path, "forms", questionnaires_of)


def choices_of(path: Path) -> Mapping[str, ChoiceForm]:
    """The forms of choices that a data set may hold, as `forms_of` those on a scale.

    Raises
    ------
    InvalidFile
        As `study_table`.

    >>> "demographics" in choices_of(Path("no data set"))
    True
    """
    return {name: load_choices(name) for name in shipped_choices()} | study_table(path, "forms", choice_forms_of)
