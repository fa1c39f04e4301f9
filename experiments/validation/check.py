"""A question that is put to methods whose truth is known, and what is simulated for it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Final
from zlib import crc32

import numpy as np
import pandas as pd

from tactometry.loading import resolve
from tactometry.protocols.batch.streams import stream

from .kinds import Kind

Simulate = Callable[[int, np.random.Generator], pd.DataFrame]
"""Of so many simulated sets a table of outcomes: the columns of the check's keys and of its kind."""


@dataclass(frozen=True)
class Check:
    """One question.

    Parameters
    ----------
    title : str
    words : str
        What is simulated, and what ought to come out.
    kind : Kind
        What an outcome is and how it is judged.
    keys : tuple of str
        Columns whose values name a row of the table.
    settings : mapping of str to callable
        What is simulated, by name.
    n_sets : int
        Sets, groups or studies in a chunk of a setting.
    reasons : mapping of str to str
        Of a method that may depart from what it says, why: told where it does.
    reason_key : str
        The column of `keys` whose values are the methods.
    figure : str
        The name of its figure; empty where it has none.
    """

    title: str
    words: str
    kind: Kind
    keys: tuple[str, ...]
    settings: Mapping[str, Simulate]
    n_sets: int
    reasons: Mapping[str, str]
    reason_key: str
    figure: str = ""
    name: str = ""


_HERE: Final = "tactometry.experiments.validation.checks"
CHECKS: Final[Mapping[str, str]] = {
    "thresholds": f"{_HERE}.thresholds:CHECK",
    "comparisons": f"{_HERE}.comparisons:CHECK",
    "calibration": f"{_HERE}.calibration:CHECK",
    "false-alarms": f"{_HERE}.values:FALSE_ALARMS",
    "effects": f"{_HERE}.values:EFFECTS",
    "false-alarms-of-answers": f"{_HERE}.answers:FALSE_ALARMS",
    "effects-of-answers": f"{_HERE}.answers:EFFECTS",
    "false-alarms-of-ratings": f"{_HERE}.ratings:FALSE_ALARMS",
    "effects-of-ratings": f"{_HERE}.ratings:EFFECTS",
}
"""The name of each check, and where it is."""


def check_of(name: str) -> Check:
    """A check by its name."""
    check: Check = resolve(CHECKS[name])
    return replace(check, name=name)


@dataclass(frozen=True)
class Chunk:
    """Some sets of one setting of a check, by names and a number: whoever has them makes the same outcomes."""

    check: str
    setting: str
    number: int

    def simulated(self, seed: int) -> pd.DataFrame:
        """Its outcomes; its random numbers are its own, and no other check, setting or number changes them."""
        check = check_of(self.check)
        rng = stream(seed, *(crc32(name.encode()) for name in (self.check, self.setting)), self.number)
        return check.settings[self.setting](check.n_sets, rng)
