"""An observer of one's own: a class in a file beside the study, whose code runs only where a person allowed it."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from ..arguments.require import expect
from ..own_code import class_beside, not_allowed
from .decisions import Observer
from .own_calls import ANSWERS, guarded_observer

METHODS: Final = ("participant", *ANSWERS)
"""What such a class has."""


@dataclass(frozen=True)
class NotAllowed:
    """An observer whose code is not to run: a study is read, planned, replayed and analysed without it."""

    target: str
    path: str

    def participant(self, rng: np.random.Generator) -> Observer:
        """Nobody.

        Raises `InvalidParameter` Always.
        """
        del rng
        raise not_allowed(f"{self.path}.kind", self.target, "an observer")


def own_class(target: str, folder: Path, path: str) -> Any:
    """The class that ``module:Class`` names, from the file of the module in `folder`.

    Raises `InvalidParameter` if there is no such file, its import fails, or it holds no frozen dataclass with the
    methods of an observer; `path` opens the sentence.
    """
    where = f"{path}.kind"
    kind = class_beside(target, folder, where)
    lacking = [method for method in METHODS if not callable(getattr(kind, method, None))]
    found = f"{target!r}, which lacks {', '.join(lacking)}"
    expect(not lacking, where, found, "the methods of an observer (tactometry/observers/decisions.py)")
    return guarded_observer(kind)
