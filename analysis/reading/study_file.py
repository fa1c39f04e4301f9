"""Access to tables and questionnaires in the `study.toml` of a data set."""

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
    """Title and procedure of a study, and its force (N) if fixed."""

    title: str = ""
    procedure: str = ""
    force_n: float | None = None


def study_table(path: Path, name: str, read: Callable[[Mapping[str, Any]], T]) -> T:
    """Apply `read` to a table of a folder's study, or to an empty table.

    Raises `InvalidFile` if the study cannot be read, or `read` raises for its table.
    """
    file = path / "study.toml"
    table = read_table(file, "the study that ran").get(name, {}) if file.is_file() else {}
    with errors_in(file):
        expect(isinstance(table, Mapping), name, f"{table!r:.60}", "a table")
        return read(table)


def forms_of(path: Path) -> Mapping[str, Questionnaire]:
    """Return the built-in questionnaires and those in the study's `[forms]`.

    Raises `InvalidFile` as `study_table`.

    >>> "attrakdiff" in forms_of(Path("no data set"))
    True
    """
    return {name: load(name) for name in shipped_names()} | study_table(path, "forms", questionnaires_of)


def choices_of(path: Path) -> Mapping[str, ChoiceForm]:
    """Return the built-in choice forms and those in the study's `[forms]`.

    Raises `InvalidFile` as `study_table`.

    >>> "demographics" in choices_of(Path("no data set"))
    True
    """
    return {name: load_choices(name) for name in shipped_choices()} | study_table(path, "forms", choice_forms_of)
