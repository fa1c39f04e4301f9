"""Read study files strictly, and report all mistakes at once."""

import os
import re
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any, Final

from tactometry.arguments.require import expect
from tactometry.config.quantity import as_si
from tactometry.config.strict import build, check_keys, fields_of
from tactometry.config.toml import LARGEST_FILE, errors_in, table_of
from tactometry.errors import Gathered, InvalidFile, InvalidParameter, TactometryError, nearest, reworded
from tactometry.files.durable import read_file
from tactometry.questionnaire import form_of

from .study import Study

FOLDER = Path(__file__).parents[1]
PATH: Final = "path"
"""Key with the file of a questionnaire."""


def parse(content: bytes, where: str) -> Study:
    """Parse a study from the bytes of its file.

    Every error begins with `where`.

    Raises `InvalidFile` if the bytes are not TOML in UTF-8, or a key or value is invalid.
    """
    table = table_of(content, where, "a study file")
    with errors_in(where):
        mistakes, of_study = Gathered(), Gathered()
        table = as_si(table, "", mistakes)
        with of_study.part():
            study = build(Study, table, "", _folder=Path(where).parent)
        for error in of_study.errors:
            mistakes.add(error)
        if mistakes.errors:
            with mistakes.part():
                _check_the_rest(table, {_first_key(error) for error in of_study.errors})
        mistakes.end()
        return study


def _check_the_rest(table: Mapping[str, Any], wrong: Collection[str]) -> None:
    """Raise the mistakes in tables of a study other than the `wrong` ones."""
    from .experiment import wire

    stand_ins = {"name": "study", "title": "", "description": "", "limits": {}}
    rest = {key: value for key, value in table.items() if key not in wrong and key in fields_of(Study)}
    mistakes = Gathered()
    try:
        wire(build(Study, stand_ins | rest, ""), "", plays=False)
    except (InvalidParameter, InvalidFile) as error:
        mistakes.add(reworded(error, InvalidParameter, lambda words: words.removeprefix(", ")))
    # Errors about tables or numbers that were removed here are spurious.
    spurious = re.compile(r"\b(limits|nan)\b" if "limits" in wrong else r"\bnan\b")
    mistakes.errors = [
        error for error in mistakes.errors if _first_key(error) in rest and not spurious.search(str(error))
    ]
    mistakes.end()


def _first_key(error: TactometryError) -> str:
    return re.split(r"[.:\[]", str(error).removeprefix(": "), maxsplit=1)[0]


def builtin() -> dict[str, Path]:
    """Return the built-in studies by name."""
    return {path.stem: path for path in sorted(FOLDER.glob("*.toml"))}


def shipped() -> dict[str, Path]:
    """Return the built-in studies, then the short example studies, by name."""
    return builtin() | {path.stem: path for path in sorted((FOLDER / "to_copy").glob("*.toml"))}


def locate(study: str) -> Path:
    """Find the file of a study by name or path.

    Raises `InvalidFile` if neither a built-in study nor a file has this name.
    """
    path = shipped().get(study, Path(study))
    if os.path.lexists(path):
        return path
    raise InvalidFile(
        f"{study}: found no such file or built-in study, expected a path to a study file or one of "
        f"{', '.join(shipped())}{nearest(study, shipped())}"
    )


def folder_of(study: str) -> Path:
    """Return the folder of a study's file."""
    return locate(study).resolve().parent


def load(study: str) -> tuple[Study, bytes]:
    """Return a study, and the bytes of its file with inserted questionnaires."""
    path = locate(study)
    content = with_forms(read_file(path, "a study file", LARGEST_FILE), path)
    return parse(content, str(path) if study not in shipped() else study), content


def with_forms(content: bytes, path: Path) -> bytes:
    """Insert questionnaires from files of `[forms.NAME]` into a study's bytes.

    Raises `InvalidFile` if such a file cannot be read or is not a questionnaire. The message starts with its path.
    """
    forms = table_of(content, str(path), "a study file").get("forms")
    tables = forms if isinstance(forms, Mapping) else {}
    named = {name: form for name, form in tables.items() if isinstance(form, Mapping) and PATH in form}
    if not named:
        return content
    import tomlkit

    document: Any = tomlkit.parse(content.decode("utf-8-sig"))
    for name, form in named.items():
        with errors_in(path):
            check_keys(form, [PATH], f"forms.{name}")
            _check_path(path.parent, form[PATH], f"forms.{name}.{PATH}")
        document["forms"][name] = _table_of_file(path.parent / form[PATH], name)
    return tomlkit.dumps(document).encode()


def _check_path(folder: Path, named: object, where: str) -> None:
    expect(isinstance(named, str), where, repr(named), "a text with the name of a file")
    is_folder = not str(named).strip() or (folder / str(named)).is_dir()
    what = "a folder" if str(named).strip() else "no name"
    expected = "the path of a questionnaire's file, relative to the study file"
    expect(not is_folder, where, f"{named!r}, {what}", expected)


def _table_of_file(path: Path, name: str) -> dict[str, Any]:
    """Return the table of a questionnaire. `name` is its name in the study."""
    what = "a questionnaire"
    table = table_of(read_file(path, what, LARGEST_FILE), str(path), what)
    with errors_in(path):
        stated = table.pop("name", name)
        expect(stated == name, "name", repr(stated), f"{name!r}, its name in the study; or remove the key")
        form_of({"name": name, **table}, "")
    return table
