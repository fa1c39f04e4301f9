"""Properties of every procedure under deviating delivered levels."""

import itertools
import math
from dataclasses import fields
from typing import get_args

import catalogue
import pytest
from examples import examples
from hard_cases import exact_case
from hypothesis import given, strategies as st

from tactometry.errors import InvalidParameter
from tactometry.experiments.study.kinds import PROCEDURES
from tactometry.protocols.procedures.procedure import Ending

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
