"""What every model of a participant is: a decision rule on sensation levels."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from ..session.request import Facts


class Observer(Protocol):
    """Decides from sensation levels (dB re the detection threshold, -inf for nothing), never from a nominal level."""

    def detect(self, sensation_db: float, rng: np.random.Generator) -> bool:
        """Whether a stimulus is reported as felt."""

    def compare(self, sensations_db: Sequence[float], rng: np.random.Generator) -> int:
        """The index of the one that is felt most."""

    def differ(self, sensations_db: Sequence[float], rng: np.random.Generator) -> bool:
        """Whether two stimuli are reported as different."""

    def magnitude(self, sensation_db: float, rng: np.random.Generator) -> float:
        """How strong it felt, a number from 0."""

    def liking(self, sensation_db: float, rng: np.random.Generator) -> float:
        """How good it felt, from -1 to 1."""

    def answer_time_s(self, rng: np.random.Generator) -> float: ...

    def facts(self) -> Facts: ...
