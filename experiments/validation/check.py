"""A question that is put to methods whose truth is known, and what is simulated for it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

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
