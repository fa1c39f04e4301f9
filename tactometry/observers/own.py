"""An observer of one's own: a class in a file beside the study, whose code runs only where a person allowed it."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, is_dataclass
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType
from typing import Any, Final

import numpy as np

from ..arguments.require import expect
from ..errors import InvalidParameter, reason
from ..provenance import sha256
from .decisions import Observer
from .own_calls import ANSWERS, guarded, place_of

METHODS: Final = ("participant", *ANSWERS)
"""What such a class has."""


@dataclass(frozen=True)
class NotAllowed:
    """An observer whose code is not to run: a study is read, planned, replayed and analysed without it."""

    target: str
    path: str

    def participant(self, rng: np.random.Generator) -> Observer:
        """Nobody.

        Raises
        ------
        InvalidParameter
            Always.
        """
        del rng
        raise InvalidParameter(
            f"{self.path}.kind: found {self.target!r}, an observer whose code would run, expected --allow-code on the "
            "command line, if you trust it"
        )


def own_class(target: str, folder: Path, path: str) -> Any:
    """The class that ``module:Class`` names, from the file of the module in `folder`.

    Raises
    ------
    InvalidParameter
        If there is no such file, its import fails, or it holds no frozen dataclass with the methods of an observer;
        `path` opens the sentence.
    """
    module, _, name = target.partition(":")
    file = folder.joinpath(*module.split(".")).with_suffix(".py")
    where = f"{path}.kind"
    parts = [*module.split("."), name]
    expect(all(map(str.isidentifier, parts)), where, repr(target), "module:Class, such as 'mine:Careful'")
    expect(file.is_file(), where, f"{target!r}, but no file {file.name} in {folder}", "it beside the study file")
    kind = getattr(_module(file, where), name, None)
    is_class = isinstance(kind, type) and is_dataclass(kind)
    expect(is_class, where, f"no dataclass {name!r} in {file.name}", "one whose fields are the keys of the table")
    lacking = [method for method in METHODS if not callable(getattr(kind, method, None))]
    found = f"{target!r}, which lacks {', '.join(lacking)}"
    expect(not lacking, where, found, "the methods of an observer (tactometry/observers/decisions.py)")
    return guarded(kind)


def state_of(folder: Path) -> str:
    """Of the code in a folder: another one if any file of it is."""
    return sha256(b"".join(str(file).encode() + file.read_bytes() for file in sorted(folder.glob("*.py"))))


def _module(file: Path, where: str) -> ModuleType:
    """The module of a file, under a name that no other file or state of its folder has."""
    name = f"tactometry_own_{state_of(file.parent)[:12]}_{file.stem}"
    if name in sys.modules:
        return sys.modules[name]
    spec = spec_from_file_location(name, file)
    assert spec is not None  # a file that ends in .py has a loader
    assert spec.loader is not None
    made = module_from_spec(spec)
    sys.modules[name] = made
    try:
        with _beside(file.parent):
            spec.loader.exec_module(made)
    except Exception as error:  # whatever foreign code may raise
        del sys.modules[name]
        place, words = place_of(error, file.parent) or file.name, f"{type(error).__name__}: {reason(error)}"
        raise InvalidParameter(
            f"{where}: the import of {file.name} failed at {place} ({words}), expected a module that runs"
        ) from None
    return made


@contextmanager
def _beside(folder: Path) -> Iterator[None]:
    """What stands in a folder can be imported, by who does it here alone: another state of it is imported anew."""
    known = set(sys.modules)
    sys.path.append(str(folder))
    try:
        yield
    finally:
        sys.path.remove(str(folder))
        for name in sys.modules.keys() - known:
            if (file := getattr(sys.modules[name], "__file__", None)) and Path(file).parent == folder:
                del sys.modules[name]
