"""Description of a data set as in Psych-DS, of its study and columns."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import msgspec

from ..arguments.require import expect
from ..errors import InvalidFile
from ..files.durable import read_file, write_atomically
from ..files.json_file import json_object, json_value
from ..trials.columns import Column

NAME: Final = "dataset_description.json"
SIMULATED: Final = "simulated"
"""Name of the rig with simulated participants."""
KEYWORD: Final = "simulated data"
SENTENCE: Final = "Simulated participants: no person took part."


@dataclass(frozen=True)
class StudyDescription:
    """Study metadata in a data set. `study_toml` contains the bytes of the study file."""

    study: str
    title: str
    description: str
    columns: tuple[Column, ...]
    study_toml: bytes


def description(design: StudyDescription) -> dict[str, object]:
    """Return the description that Psych-DS requires."""
    return {
        "@context": "https://schema.org/",
        "@type": "Dataset",
        "name": design.title,
        "description": design.description,
        "schemaVersion": "Psych-DS 1.5.0",
        "variableMeasured": [],
    }


def describe(root: Path, design: StudyDescription, *, is_simulated: bool) -> None:
    """Write or complete the description of a data set, keeping manual additions.

    Raises `InvalidFile` if the file has another content.
    """
    path = root / NAME
    there = read_description(path) if path.exists() else None
    described: Mapping[str, Any] = description(design) if there is None else there
    # keep manual additions, then append missing columns
    variables = described["variableMeasured"]
    known = [variable.get("name") for variable in variables if isinstance(variable, Mapping)]
    new = [
        {"@type": "PropertyValue", "name": c.name, "description": c.description, "unitText": c.unit}
        for c in design.columns
        if c.name not in known
    ]
    complete = {**described, "variableMeasured": [*variables, *new]}
    expected = as_simulated(complete) if is_simulated else complete
    if expected != there:  # leave a complete file unchanged
        write_atomically(path, pretty(expected))


def read_description(path: Path) -> dict[str, object]:
    """Read the description of a data set."""
    anew = "the description of Psych-DS; remove it to create a new one"
    described = json_object(path, anew)
    has_columns = isinstance(described.get("variableMeasured"), list)
    expect(has_columns, path, "no list 'variableMeasured'", anew, InvalidFile)
    return described


def variable_names(described: Mapping[str, Any]) -> list[str]:
    """Return the names of the columns that a description explains.

    Raises `InvalidParameter` if an entry is not an object with a name.
    """
    names: list[str] = []
    for n, variable in enumerate(described["variableMeasured"]):
        name = variable.get("name") if isinstance(variable, Mapping) else None
        is_named = isinstance(name, str) and bool(name)
        expect(is_named, f"variableMeasured[{n}]", f"{variable!r:.60}", "an object with a text 'name'")
        names.append(str(name))
    return names


def as_simulated(described: Mapping[str, object]) -> dict[str, object]:
    """Return a description that states that its data are simulated.

    >>> as_simulated({"description": "A study."})["description"]
    'A study. Simulated participants: no person took part.'
    """
    if says_simulated(described):
        return dict(described)
    keywords = described.get("keywords")
    text = f"{described.get('description', '')} {SENTENCE}".strip()
    others = keywords if isinstance(keywords, list) else []
    return {**described, "description": text, "keywords": [*others, KEYWORD]}


def says_simulated(described: Mapping[str, object]) -> bool:
    """Return True if a description states that its data are simulated."""
    keywords = described.get("keywords")
    return isinstance(keywords, list) and KEYWORD in keywords


def describe_columns(path: Path, columns: Sequence[Column]) -> None:
    """Describe every column of a table, unless its description is up to date."""
    if not path.exists() or _column_names(read_file(path, "the description of a table")) != [c.name for c in columns]:
        table = {column.name: {"Description": column.description, "Units": column.unit} for column in columns}
        write_atomically(path, pretty(table))


def _column_names(content: bytes) -> list[str]:
    try:
        columns = json_value(content)
    except ValueError:
        return []
    return list(columns) if isinstance(columns, dict) else []


def pretty(value: object) -> bytes:
    return msgspec.json.format(msgspec.json.encode(value), indent=2) + b"\n"
