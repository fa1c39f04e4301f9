"""Batches equal single runs, and answers have the right frequency."""

import importlib
import math
import os
import sys
from itertools import product
from typing import get_args

import catalogue
import numpy as np
import pytest
from examples import examples
from followed_rule import LEVELS, OUTPUT, own_run
from hypothesis import given, strategies as st

from tactometry.errors import InvalidParameter
from tactometry.protocols import ConstantStimuli, MethodOfLimits, Quest, QuestPlus, Staircase, WeightedStaircase
from tactometry.protocols.batch.answers import AS_ASKED, LevelTable, criteria
from tactometry.protocols.batch.loop import loop_of
from tactometry.protocols.batch.tracks import NOT_ASKED, tracks
from tactometry.protocols.bayesian.outcome_model import FunctionModel
from tactometry.protocols.bayesian.parameter_grid import ParameterGrid
from tactometry.protocols.bayesian.quest import Placing
from tactometry.protocols.bayesian.quest_plus import Aim, Criterion
from tactometry.protocols.bayesian.weighing import WeighingRule
from tactometry.protocols.order import stream
from tactometry.protocols.procedures.practice import Practice
from tactometry.protocols.procedures.stepping import SteppingRule, Transition
from tactometry.psychometric import SHAPES, PsychometricFunction


def log(chance):
    with np.errstate(divide="ignore"):
        return np.log(chance)


STEPPING = {
    **{kind: rule for kind, rule in catalogue.PROCEDURES.items() if hasattr(rule, "transition")},
    "practice": Practice((40.0, 25.0, 12.0), n_correct=4, n_of=5, n_trials=15),
    "2 down, 6 dB": Staircase(30.0, (6.0, 3.0), 0.0, 40.0, n_down=3, n_reversals=6, n_trials=30, n_at_bound=2),
    "eager no more": Staircase(3.0, (6.0,), 0.0, 40.0, n_up=2, n_down=1, initial_rule=False),
    "3:1": WeightedStaircase(20.0, (6.0, 3.0), (2.0, 1.0), 0.0, 40.0, n_down=2),
    "three levels": ConstantStimuli((30.0, 10.0, 20.0), 4),
    "rising": MethodOfLimits(0.0, 40.0, 4.0, 5, "ascending", 3),
    "falling": MethodOfLimits(0.0, 40.0, 7.0, 4, "descending"),
}


@pytest.mark.parametrize("rule", STEPPING.values(), ids=STEPPING)
@given(seed=st.integers(0, 2**32 - 1), through_a_table=st.booleans(), output=st.sampled_from([AS_ASKED, OUTPUT]))
@examples(10, deadline=None)
def test_batch_equals_single_runs(rule, seed, through_a_table, output):
    rng = np.random.default_rng(seed)
    place, spread = rng.uniform(-10, 50), rng.choice([0.0, 1.0, 10.0])
    drawn, orders = place + spread * rng.standard_normal((6, 50)), rule.orders(6, rng)
    table = LevelTable(LEVELS, np.sort(rng.uniform(0, 40, (6, len(LEVELS))))) if through_a_table else None
    batch = tracks(rule, drawn, table, orders=orders, delivery=output)
    for i, n in enumerate(batch.n_trials):
        levels, run = own_run(rule, orders[i], batch.answers[i, :n], output)
        assert batch.asked[i, :n].tolist() == levels
        delivered = output(np.array(levels))
        assert np.array_equal(batch.levels[i, :n], delivered)
        felt = np.interp(delivered, LEVELS, table.felt[i]) if through_a_table else delivered
        assert np.array_equal(batch.answers[i, :n], felt > drawn[i, :n])
        assert (batch.ending(i), bool(n < 50)) == (run.ending, bool(n < 50 and run.finished))
        assert np.isnan(batch.levels[i, n:]).all()
        assert (batch.answers[i, n:] == NOT_ASKED).all()
        assert batch.thresholds[i] == pytest.approx(math.nan if run.threshold is None else run.threshold, nan_ok=True)


GRID = ParameterGrid(tuple(np.linspace(0.0, 40.0, 21)), (4.0, 9.0, 20.0), (0.0, 0.5), (0.0, 0.02))
FEW = tuple(np.linspace(0.0, 40.0, 11))
COIN = FunctionModel({"bias": (0.2, 0.5, 1.0)}, 2, lambda level, outcome, *, bias: log(bias if outcome else 1 - bias))


def unsure(level, outcome, *, threshold, width):
    """Return log probabilities of wrong, "I do not know" and right."""
    right, known = (1 / (1 + np.exp((threshold + at - level) / width)) for at in (1.0, -1.0))
    return log((1 - known, known - right, right)[outcome])


THREE = FunctionModel({"threshold": GRID.thresholds, "width": (2.0, 5.0)}, 3, unsure)
QUEST = {"start": 20.0, "start_sd": 9.0, "low": 0.0, "high": 40.0, "step": 0.5, "n_trials": 25, "sd_stop": 3.0}
WEIGHING = {
    "wrong, unsure, right": QuestPlus(FEW, THREE, 25, 2.5, "threshold"),
    **{kind: rule for kind, rule in catalogue.PROCEDURES.items() if isinstance(rule, WeighingRule)},
    **{
        f"QUEST+, {aim}, {criterion}": QuestPlus(FEW, GRID, 25, 2.5, aim, criterion, {"width": (1.0, 2.0, 1.0)})
        for aim in get_args(Aim)
        for criterion in get_args(Criterion)
    },
    "answers that nothing allows": QuestPlus((0.0, 1.0), COIN, n_trials=9, prior={"bias": (0.0, 0.0, 1.0)}),
    **{f"QUEST, {to}": Quest(**QUEST, placing=to) for to in get_args(Placing)},
}


@pytest.mark.parametrize("rule", WEIGHING.values(), ids=WEIGHING)
@given(seed=st.integers(0, 2**32 - 1), through_a_table=st.booleans(), output=st.sampled_from([AS_ASKED, OUTPUT]))
@examples(8, deadline=None)
def test_batch_of_weighing_rule_equals_single_runs(rule, seed, through_a_table, output):
    rng = np.random.default_rng(seed)
    shape = (5, 30, rule.n_outcomes - 1)
    drawn = np.sort(rng.uniform(-10, 50) + rng.choice([0.0, 1.0, 10.0]) * rng.standard_normal(shape), axis=2)
    table = LevelTable(LEVELS, np.sort(rng.uniform(0, 40, (5, len(LEVELS))))) if through_a_table else None
    batch = tracks(rule, drawn, table, delivery=output)
    for i, n in enumerate(batch.n_trials):
        run = rule.begin()
        each = batch.asked[i, :n], batch.levels[i, :n], batch.answers[i, :n]
        for asked, level, answer in zip(*(values.tolist() for values in each), strict=True):
            assert asked == pytest.approx(run.level, abs=1e-9 if isinstance(rule, Quest) else 0)
            assert level == output(asked)
            run = run.after(answer, level)
        felt = np.array([np.interp(level, LEVELS, table.felt[i]) if through_a_table else level for level in each[1]])
        assert np.array_equal(each[2], (felt[:, None] > drawn[i, :n]).sum(axis=1))
        assert (batch.ending(i), run.finished) == (run.ending, n < 30 or run.finished)
        wanted = math.nan if run.threshold is None else run.threshold
        assert batch.thresholds[i] == pytest.approx(wanted, rel=1e-9, abs=1e-9, nan_ok=True)


@pytest.mark.parametrize("shape", SHAPES)
def test_criteria_invert_the_psychometric_function(shape):
    """Guesses and lapses have the end criteria; others equal those of comparing the number with P(1)."""
    width, lowest = (1.2, 0.0) if shape == "weibull" else (9.0, -math.inf)
    parameters = (shape, 20.0, width, 0.5, 0.02)
    uniform, levels = np.random.default_rng().random((1, 10_000)), np.linspace(0.1, 40, 10_000)
    found = levels > criteria(uniform, *parameters)
    assert np.array_equal(found[0], uniform[0] < PsychometricFunction(*parameters).probability(levels))
    assert criteria(np.array([0.0, 0.499, 0.981]), *parameters).tolist() == [lowest, lowest, math.inf]


def test_batch_orders_contain_each_level_once_per_repeat():
    orders = ConstantStimuli((1.0, 2.0, 3.0), 4).orders(200, np.random.default_rng()).reshape(-1, 3)
    assert (np.sort(orders, axis=1) == [1, 2, 3]).all()
    counts = np.unique(orders, axis=0, return_counts=True)[1]
    assert len(counts) == 6
    assert (np.abs(counts - len(orders) / 6) < 4 * math.sqrt(len(orders) / 6)).all()


def test_nested_seeds_never_repeat():
    numbers = (0, 1, 2, 2**31, 2**32 - 1)
    places = [place for depth in range(4) for place in product(numbers, repeat=depth)]
    drawn = {
        (seed, place): stream(seed, *place).integers(2**63, size=2).tobytes()
        for seed in (0, 1, 2**64)
        for place in places
    }
    assert len(set(drawn.values())) == 3 * len(places)


def tracks_of(**given_):
    return tracks(STEPPING["three levels"], **{"criteria": np.zeros((3, 4))} | given_)


def table_of(levels, felt):
    return LevelTable(np.array(levels), np.array(felt))


ONE_OF_TWO = r"tracks.criteria: found .* expected \(n_sets, n_trials, 2\)"


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: tracks(WEIGHING["wrong, unsure, right"], np.zeros((1, 2))), ONE_OF_TWO),
        (lambda: tracks_of(criteria=np.zeros(3)), r"tracks.criteria: found the shape \(3,\), expected \(n_sets, n"),
        (lambda: tracks_of(orders=np.zeros((2, 4))), "tracks.orders: found 2 rows, expected 1 or 3"),
        (lambda: tracks_of(table=table_of(LEVELS, np.zeros((2, 8)))), "tracks.table: found 2 rows, expected 1 or 3"),
        (lambda: table_of([0.0, 0.0], [1.0, 2.0]), "LevelTable.levels: found .* not in ascending order"),
        (lambda: table_of([0.0, 1.0], [1.0, math.nan]), "LevelTable.felt"),
        (lambda: table_of([0.0, 1.0], [1.0, 2.0, 3.0]), r"LevelTable.felt: found the shape \(3,\)"),
        *((lambda place=place: stream(1, 0, place), r"stream.*expected a whole number") for place in (-1, 2**32, 0.5)),
    ],
)
def test_invalid_arguments_are_rejected(call, message):
    with pytest.raises(InvalidParameter, match=message):
        call()


SOURCE = """
def start(numbers, order):
    return (0,)


def level(numbers, order, state):
    return {level}


def after(numbers, order, state, answers, levels):
    return (state[0] + 1,), levels[-1]


def ending(numbers, order, state, answers):
    return 0


def threshold(marks):
    return marks[-1]
"""


@pytest.fixture
def levels_of_source(tmp_path, monkeypatch):
    """Return a function that runs a rule with a constant level."""
    monkeypatch.syspath_prepend(str(tmp_path))

    def levels(level):
        file = tmp_path / "rule_of_a_test.py"
        file.write_text(SOURCE.format(level=level))
        os.utime(file, (level, level))  # files written within one second look unchanged
        sys.modules.pop("rule_of_a_test", None)
        importlib.invalidate_caches()
        own = importlib.import_module("rule_of_a_test")

        class Constant(SteppingRule):
            transition = Transition(own.level, own.ending, own.start, own.after, own.threshold)
            name = "of a test"
            numbers = ()
            begin = None

        return tracks(Constant(), np.zeros((1, 2))).levels.tolist()

    yield levels
    sys.modules.pop("rule_of_a_test", None)


def test_machine_code_is_shared_between_processes(monkeypatch):
    rule, made = Staircase(20.0, (4.0,), 0.0, 40.0), []

    def as_a_new_process_makes_it(transition):
        made.append(loop_of.__wrapped__(transition))
        return made[-1]

    tracks(rule, np.zeros((1, 2)))
    monkeypatch.setattr("tactometry.protocols.batch.loop.loop_of", as_a_new_process_makes_it)
    tracks(rule, np.zeros((1, 2)))
    assert sum(made[0].stats.cache_hits.values()) == 1


def test_rule_is_recompiled_when_its_source_changes(levels_of_source):
    assert levels_of_source(3.0) == [[3.0, 3.0]]
    assert levels_of_source(5.0) == [[5.0, 5.0]]
