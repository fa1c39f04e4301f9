"""Public procedures, tasks and touches with invalid arguments: they work, or one sentence names the argument."""

import math
from dataclasses import fields
from inspect import isabstract

import catalogue
import numpy as np

import tactometry.protocols as room
from tactometry.errors import InvalidParameter
from tactometry.protocols import QuestPlus, QuestPlusSettings, psi
from tactometry.protocols.bayesian.outcome_model import FunctionModel
from tactometry.protocols.bayesian.parameter_grid import ParameterGrid
from tactometry.protocols.bayesian.quest_plus import SharedQuestPlus
from tactometry.protocols.bayesian.settings import PsiSettings
from tactometry.protocols.block_state import BlockOptions
from tactometry.protocols.order import williams_square
from tactometry.protocols.procedures.practice import Practice
from tactometry.protocols.session import Inquiry
from tactometry.protocols.tasks.measurement import Measurement
from tactometry.questionnaire import load as load_form

HOSTILE = {
    "None": None, "text": "wide", "nan": math.nan, "inf": math.inf, "-1": -1, "0": 0, "half": 0.5, "1e-320": 1e-320,
    "1e308": 1e308, "empty": (), "with nan": (1.0, math.nan), "of texts": ("a", "b"), "of None": (None,), "True": True,
    "complex": 1 + 1j, "mapping": {"a": "b"},
}  # fmt: skip
NO_NUMBERS = {"None", "text", "nan", "inf", "with nan", "of None"}
STATE = {"SharedQuestPlus": ("log_likelihoods", "runs"), "SharedTrack": ("pool", "track")}
"""Fields with the answers so far, which only `after` sets."""


PROTOCOLS = ("OutcomeModel",)
"""Abstract class that users implement."""
UNCHECKED = {"Condition", "Track", "session"}
"""Records that a block receives, and the function that passes a course on."""


def coin(level, outcome, *, bias):
    return np.log(np.where(outcome == 1, bias, 1 - bias))


SETTINGS = QuestPlusSettings(0.0, 40.0, 5, 4.0, 16.0, 2, 2.0, threshold_low=0.0, threshold_high=40.0, n_thresholds=5)
SMALL = QuestPlus((0.0, 20.0, 40.0), ParameterGrid((0.0, 20.0, 40.0), (8.0,)), n_trials=3)
VALID = (
    *(getattr(each, "rule", each) for each in catalogue.PROCEDURES.values()),
    *catalogue.TASKS.values(), *catalogue.TOUCHES.values(),
    Measurement(), Practice((10.0, 20.0)), SMALL.grid, SETTINGS, BlockOptions(), Inquiry(load_form("sus")),
    PsiSettings(0.0, 40.0, 5, 1.0, 8.0, 2), SharedQuestPlus(SMALL, ("first", "second")),
    FunctionModel({"bias": (0.25, 0.75)}, 2, coin),
    catalogue.block("yes_no", "constant_stimuli"),
)  # fmt: skip
CALLS = {
    williams_square: {"n": 4},
    psi: {
        "levels": (0.0, 1.0), "thresholds": (0.0, 1.0), "sds": (0.5, 1.0), "guess_rate": 0.5, "lapse_rate": 0.02,
        "n_trials": 3, "sd_stop": 0.1, "aim": "parameters",
    },
    **{each.after: {"response": 1, "delivered": 20.0} for each in catalogue.PROCEDURES.values()},
}  # fmt: skip


def cases():
    for each in VALID:
        state = STATE.get(type(each).__name__, ())
        given = {f.name: getattr(each, f.name) for f in fields(each) if not f.name.startswith("_")}
        yield type(each), {name: value for name, value in given.items() if name not in state}
    yield from CALLS.items()


def test_every_public_name_is_tried():
    public = {name for name in dir(room) if not isabstract(getattr(room, name)) and name not in PROTOCOLS}
    assert public - {function.__name__ for function, _ in cases()} == UNCHECKED


def test_hostile_arguments_raise_one_line_error_or_work():
    faults = [
        f"{function.__qualname__}({name}={word}): {fault}"
        for function, arguments in cases()
        for name in arguments
        for word, value in HOSTILE.items()
        if (fault := harm(function, arguments | {name: value}, name if word in NO_NUMBERS else ""))
    ]
    assert not faults, "\n".join(faults)


def harm(function, arguments, named):
    try:
        gone_on(function(**arguments))
    except InvalidParameter as error:
        said = str(error)
        return None if "\n" not in said and ": found" in said and named in said else said
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return None


def gone_on(made):
    """Return a procedure, or one made from the argument, after two answers."""
    if hasattr(made, "procedure") and callable(made.procedure) and not hasattr(made, "tracks"):
        made = made.procedure()
    for answer in (1, 0):
        if hasattr(made, "after") and hasattr(made, "level") and not made.finished:
            assert math.isfinite(made.level)
            made = made.after(answer)
