"""Compiled batch loops are cached on disk and follow their source."""

import importlib
import os
import sys

import numpy as np
import pytest

from tactometry.protocols import Staircase
from tactometry.protocols.batch.loop import loop_of
from tactometry.protocols.batch.tracks import tracks
from tactometry.protocols.procedures.stepping import SteppingRule, Transition

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
