"""What the study of a data set states: a table of its `study.toml`, and the questionnaires that it may ask."""

import tomllib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from tactometry.errors import InvalidFile, InvalidParameter
from tactometry.questionnaire import Questionnaire, built, load, shipped

T = TypeVar("T")


def stated(path: Path, name: str, read: Callable[[Mapping[str, Any]], T]) -> T:
    """What `read` makes of a table of the study in the folder `path`; of an empty one where there is none.

    Raises
    ------
    InvalidFile
        If the study cannot be read, or `read` refuses its table.
    """
    file = path / "study.toml"
    try:
        text = file.read_text(encoding="utf-8") if file.is_file() else ""
        table = tomllib.loads(text).get(name, {})
        if not isinstance(table, Mapping):
            raise InvalidParameter(f"{name}: found {table!r:.60}, expected a table")
        return read(table)
    except OSError as failure:
        raise InvalidFile(f"{file}: cannot be read ({failure.strerror}), expected the study that ran") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as damage:
        raise InvalidFile(f"{file}: found no valid TOML ({damage}), expected the study that ran") from None
    except InvalidParameter as wrong:
        raise InvalidFile(f"{file}, {wrong}") from None


def forms_of(path: Path) -> Mapping[str, Questionnaire]:
    """The questionnaires that a data set may hold: the shipped ones, and those of its study's `[forms.NAME]`.

    Raises
    ------
    InvalidFile
        As `stated`.

    >>> "attrakdiff" in forms_of(Path("no data set"))
    True
    """
    return {name: load(name) for name in shipped()} | stated(path, "forms", _own)


def _own(tables: Mapping[str, Any]) -> dict[str, Questionnaire]:
    return {name: built({"name": name, **table}, f"forms.{name}.") for name, table in tables.items()}
