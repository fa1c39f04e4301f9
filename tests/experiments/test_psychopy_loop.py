"""Procedures as PsychoPy loops, with data for its experiment handler."""

import warnings

import pytest

from tactometry.experiments.psychopy_plugin.loop import Loop
from tactometry.protocols import ConstantStimuli, Staircase
from tactometry.protocols.tasks.task import Reply, TrialOutcome
from tactometry.session.answer import Chosen, Touched


def begun():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        data = pytest.importorskip("psychopy.data", reason="no psychopy: extra window")
    loop = Loop("s", Staircase(20.0, (4.0,), 0.0, 40.0, n_reversals=2, n_trials=4).begin())
    handler = data.ExperimentHandler(savePickle=False, saveWideText=False)
    handler.addLoop(loop)
    return loop, handler


def answered(level, option, *, valid=True):
    touch = Touched(0.0, level, "ab", force_mean_n=1.0, valid=valid, invalid_reason=None if valid else "timeout")
    if not valid:
        return TrialOutcome((touch,), touch)
    choice = Chosen(option, 1.0, 0.5)
    return TrialOutcome((touch,), touch, (Reply(choice, option, True),), success=bool(option))


def test_loop_follows_procedure_and_reports_end():
    loop, handler = begun()
    seen = []
    for level in loop:
        seen.append(level)
        loop.addResponse(1)
    assert seen == loop.intensities == [20.0, 16.0, 12.0, 8.0]
    assert (loop.ending, loop.level, loop.data) == ("trials", None, [1, 1, 1, 1])
    assert handler.loopsUnfinished == []


def test_delivered_level_counts():
    loop, _ = begun()
    next(loop)
    loop.hear(answered(19.0, 1))
    assert loop.procedure == begun()[0].procedure.after(1, 19.0)


def test_invalid_touch_is_recorded_and_repeats_level():
    loop, handler = begun()
    level = next(loop)
    loop.hear(answered(level, 0, valid=False))
    entry = {"level_delivered": 20.0, "force_mean_n": 1.0, "valid": 0, "invalid_reason": "timeout"}
    assert handler.thisEntry == {f"s.{name}": value for name, value in entry.items()}
    assert next(loop) == level
    loop.hear(answered(level, 0))
    assert [handler.thisEntry[f"s.{name}"] for name in ("valid", "response", "latency_s")] == [1, 0, 0.5]
    assert next(loop) == 24.0


@pytest.mark.parametrize("n_attempts", [1, 5])
def test_levels_without_answer_end_loop(n_attempts):
    loop = Loop("s", ConstantStimuli([3.0], 9).begin(), n_attempts)
    assert len(list(loop)) == n_attempts
    assert loop.ending == "aborted"
