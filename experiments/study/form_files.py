"""Questionnaires of a study that stand in files beside it: put in their place, so that a data set holds all of them."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from tactometry.arguments.require import expect
from tactometry.choice_form import choice_form_of, is_choices
from tactometry.config.strict import check_keys
from tactometry.config.toml import LARGEST_FILE, errors_in, table_of
from tactometry.files.durable import read_file
from tactometry.questionnaire import questionnaire_of

PATH: Final = "path"


def with_forms(content: bytes, path: Path) -> bytes:
    """The bytes of a study file with the tables of the files that its `[forms.NAME]` name by `path`; a study that names
    none is as it was.

    Raises
    ------
    InvalidFile
        If such a file cannot be read, or is no questionnaire; the sentence opens with it.
    """
    forms = table_of(content, str(path), "a study file").get("forms")
    named = {name: form for name, form in forms.items() if _is_named(form)} if isinstance(forms, Mapping) else {}
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


def _is_named(form: object) -> bool:
    return isinstance(form, Mapping) and PATH in form


def _check_path(folder: Path, named: object, where: str) -> None:
    """Refuse what names no file: a folder, or nothing at all, which is the folder of the study."""
    expect(isinstance(named, str), where, repr(named), "a text, the name of a file")
    is_folder = not str(named).strip() or (folder / str(named)).is_dir()
    what = "a folder" if str(named).strip() else "no name"
    expected = "the name of a file with a questionnaire, as seen from the study file"
    expect(not is_folder, where, f"{named!r}, {what}", expected)


def _table_of_file(path: Path, name: str) -> dict[str, Any]:
    """The table of a questionnaire that a study calls `name`."""
    what = "a questionnaire"
    table = table_of(read_file(path, what, LARGEST_FILE), str(path), what)
    with errors_in(path):
        stated = table.pop("name", name)
        expect(stated == name, "name", repr(stated), f"{name!r}, as the study calls it; or leave it out")
        read = choice_form_of if is_choices(table) else questionnaire_of
        read({"name": name, **table}, "")
    return table
