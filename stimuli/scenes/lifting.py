"""Where a contact pulls by more than it is pressed with: a finger would lift off there, and the linear one does not."""

import numpy as np

from ..arrays import FloatArray
from .plan import Plan
from .result import Result

FORCE, LOAD = "contact_force_n", "finger_load"


def loads_n(plan: Plan) -> FloatArray:
    """(n_contacts,): the forces that press the fingers, in the order of the rows of ``contact_force_n``."""
    pressed = (stage.settings["force_n"] for stage in plan.stages if stage.name == LOAD)
    return np.asarray(next(pressed, ()), float)


def pulls_n(result: Result) -> FloatArray:
    """(n_contacts,): by how much each finger pulls at most beyond its load; 0 where it never does."""
    if FORCE not in result.values:
        return np.zeros(0)
    lowest = np.atleast_2d(result.values[FORCE]).min(axis=1)
    return np.asarray(np.maximum(-lowest - loads_n(result.plan), 0.0))
