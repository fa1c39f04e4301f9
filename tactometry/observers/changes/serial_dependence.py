"""Serial dependence: an answer pulls the next one to itself."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...arguments.annotations import Finite
from ...arguments.constraints import constrained
from .change import Answer, Shift


@dataclass(frozen=True)
@constrained
class SerialDependence:
    """After a yes the criterion is lower by `pull`, in units of the internal noise, after a no higher (unverified
    default); below 0, answers alternate. It acts on questions with a criterion: yes/no, same or different.

    Parameters
    ----------
    pull : float
        By how much the criterion is lower after a yes, in units of the internal noise.
    """

    pull: Finite = 0.2

    def shift(self, n_trials: int, answers: Sequence[Answer], rng: np.random.Generator) -> Shift:
        del n_trials, rng
        last = answers[-1] if answers else None
        return Shift(criterion=-self.pull if last else self.pull) if last in (0, 1) else Shift()
