"""Properties of every procedure, and of public procedures, tasks and touches with invalid arguments."""

import itertools
import math
from dataclasses import fields
from inspect import isabstract
from typing import get_args

import catalogue
import numpy as np
import pytest
from examples import examples
from hard_cases import exact_case
from hypothesis import given, strategies as st

import tactometry.protocols as room
from tactometry.errors import InvalidParameter
from tactometry.experiments.study.kinds import PROCEDURES
from tactometry.protocols import QuestPlus, QuestPlusSettings, psi
from tactometry.protocols.bayesian.outcome_model import FunctionModel
from tactometry.protocols.bayesian.parameter_grid import ParameterGrid
from tactometry.protocols.bayesian.quest_plus import SharedQuestPlus
from tactometry.protocols.bayesian.settings import PsiSettings
from tactometry.protocols.block_state import BlockOptions
from tactometry.protocols.order import williams_square
from tactometry.protocols.procedures.practice import Practice
from tactometry.protocols.procedures.procedure import Ending
from tactometry.protocols.session import Inquiry
from tactometry.protocols.tasks.measurement import Measurement
from tactometry.questionnaire import load as load_form

per_procedure = pytest.mark.parametrize("procedure", catalogue.PROCEDURES.values(), ids=catalogue.PROCEDURES)


@per_procedure
@given(answers=st.lists(st.tuples(st.booleans(), st.floats(-100, 140)), max_size=40))
@examples(20, deadline=None)
def test_level_stays_within_bounds_after_contradictory_answers(procedure, answers):
    for answer, level in answers:
        if procedure.finished:
            break
        procedure = procedure.after(answer, delivered=level)
        assert math.isfinite(procedure.level)
        assert 0.0 <= procedure.level <= 40.0


@per_procedure
@given(answers=st.lists(st.booleans(), max_size=60))
@examples(20, deadline=None)
def test_procedure_respects_bounds_and_maximum_trials(procedure, answers):
    n_answers, (low, high) = 0, procedure.bounds
    for answer in itertools.chain(answers, itertools.cycle((0, 1, 1))):
        assert low <= procedure.level <= high
        assert procedure.threshold is None or low <= procedure.threshold <= high
        if procedure.finished:
            break
        procedure, n_answers = procedure.after(answer), n_answers + 1
    assert n_answers <= procedure.n_trials_at_most
    assert procedure.ending in get_args(Ending)
    assert procedure.threshold is None or procedure.ending not in {"censored_above", "censored_below", "aborted"}


@per_procedure
def test_before_the_first_answer_there_is_no_threshold(procedure):
    assert (procedure.threshold, procedure.estimate.note) == (None, "no answer")


@pytest.mark.parametrize("kind", PROCEDURES)
def test_rule_contains_only_its_settings(kind):
    rule = catalogue.PROCEDURES[kind]
    run = rule.after(1).after(0)
    assert run.rule is rule
    assert [field.name for field in fields(run)][:3] == ["rule", "responses", "delivered"]
    assert not {field.name for field in fields(rule)} & {field.name for field in fields(run)}
    assert (run.responses, len(run.delivered), rule.level == rule.begin().level) == ((1, 0), 2, True)


@per_procedure
def test_procedure_ends_when_level_is_clipped(procedure):
    """An amplifier delivers half of the level, at most 15."""
    n_trials = 0
    while not procedure.finished:
        procedure = procedure.after(0, delivered=min(procedure.level / 2, 15.0))
        n_trials += 1
        assert n_trials <= 400
    assert procedure.ending in ("censored_above", "trials")


@per_procedure
@pytest.mark.parametrize("answer", [0, 1])
def test_equal_answers_never_end_as_converged(procedure, answer):
    while not procedure.finished:
        procedure = procedure.after(answer)
    assert procedure.ending == ("censored_below" if answer else "censored_above")
    exact_case("equal answers to every procedure", against="censored")


@per_procedure
@pytest.mark.parametrize("level", [math.nan, math.inf])
def test_procedure_rejects_non_finite_delivered_level(procedure, level):
    with pytest.raises(InvalidParameter, match="expected a finite number"):
        procedure.after(1, delivered=level)


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
