"""What a folder of results was asked: another question is refused, the same one goes on."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..errors import InvalidFile
from ..provenance import versions
from .durable import make_folder, write_atomically
from .json_file import json_object

ASKED = "asked.json"


def prepare(root: Path, wanted: Mapping[str, Any], work: str, *, resume: bool) -> None:
    """Make a folder that holds what is asked, or (`resume`) go on with one that an earlier run of the same left.

    The versions stand beside what is asked: they may be others when it goes on.

    Raises `InvalidFile` if it holds this question already and `resume` is not given, or another one.

    Parameters
    ----------
    wanted : mapping
        All that the results follow from, as JSON reads it again: numbers, texts, lists.
    work : str
        What is asked, in words: ``power analysis``.
    """
    path = root / ASKED
    if path.exists():
        held = json_object(path, f"what a {work} was asked; give another --out")
        other = next((name for name, value in wanted.items() if held.get(name) != value), None)
        if other is not None:
            found, asked = held.get(other), wanted[other]
            raise InvalidFile(f"{path}: found {other} {found!r}, expected {asked!r} as asked; give another --out")
        if not resume:
            raise InvalidFile(f"{root}: found this {work}, expected none; go on with --resume")
    make_folder(root)
    write_atomically(path, json.dumps({**wanted, "versions": versions()}, indent=2).encode() + b"\n")
