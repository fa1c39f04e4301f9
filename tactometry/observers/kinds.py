"""Every kind of simulated participant, by the name that a study file uses, imported when it is named."""

from collections.abc import Mapping
from typing import Any, Final, Protocol

import numpy as np

from ..config.strict import build_kind
from .decisions import Observer

USUAL: Final = "signal_detection"
"""What a table that names no kind means."""
OBSERVERS: Final = {
    USUAL: "tactometry.observers.signal_detection:SignalDetectionObserver",
}


class Population(Protocol):
    """The table of an observer: the people that a participant is drawn from."""

    def participant(self, rng: np.random.Generator) -> Observer: ...


def population_of(table: Mapping[str, Any], path: str) -> Population:
    """The people that a table describes.

    Raises
    ------
    InvalidParameter
        If the kind is unknown, or does not know what the table holds; `path` opens the sentence.

    Examples
    --------
    >>> population_of({"criterion": 2.0}, "observer").criterion
    2.0
    """
    people: Population = build_kind({"kind": USUAL, **table}, path, OBSERVERS)
    return people
