"""Reasons of invalid trials: one in each invalid row, none in valid rows."""

from dataclasses import replace

import catalogue
import numpy as np
import pytest
from memory import Memory

from tactometry.gates import Compliance, SpeedCompliance
from tactometry.observers.finger import SimulatedFinger
from tactometry.protocols import Sliding
from tactometry.protocols.block import run_block
from tactometry.protocols.tasks.task import Reply, TrialOutcome
from tactometry.rigs.experimenter.terminal import ExperimenterTerminal
from tactometry.rigs.touch_validity import broken_condition
from tactometry.session.answer import Adjusted, Chosen, Touched
from tactometry.session.run import run
from tactometry.trials.row_rules import defects
from tactometry.trials.trial import REASONS, Trial

GATED = Sliding(0.2, 1.0, hold_s=0.1, timeout_s=5.0, speed_m_per_s=0.05, tolerance=0.2, speed_tolerance=0.1)
FINGER = SimulatedFinger(waver_cv=0.1, speed_cv=0.1)


def rows(task, touch, finger):
    block = catalogue.block(task, "constant_stimuli")
    track = replace(block.tracks[0], condition=replace(block.tracks[0].condition, touch=touch))
    block = replace(block, tracks=(track,), options=replace(block.options, n_attempts=1000))
    memory = Memory()
    run(run_block(block, 1, 1, np.random.default_rng(1)), catalogue.simulated(7, finger=finger), memory)
    return memory.trials


@pytest.mark.parametrize("task", sorted(set(catalogue.TASKS) - {"adjustment"}))
def test_only_invalid_rows_have_a_reason(task):
    trials = rows(task, GATED, FINGER)
    assert {trial.valid for trial in trials} == {False, True}
    assert all((trial.invalid_reason is None) == trial.valid for trial in trials)
    assert {trial.n_gaps for trial in trials} == {None}
    assert all(0 <= trial.speed_in_band <= 1 for trial in trials)


def test_reason_matches_direction_of_force_or_speed_error():
    trials = rows("yes_no", GATED, FINGER)
    for trial in trials:
        if trial.invalid_reason in ("too_light", "too_heavy"):
            assert trial.force_in_band < 0.8
            assert (trial.force_mean_n < 1.0) == (trial.invalid_reason == "too_light")
        elif not trial.valid:
            assert trial.speed_in_band < 0.8 <= trial.force_in_band
            assert trial.invalid_reason == ("too_slow" if trial.speed_mean_m_per_s < 0.05 else "too_fast")
    assert {trial.invalid_reason for trial in trials} >= {None, "too_slow", "too_fast"}


def test_force_reason_precedes_speed_reason():
    slide = GATED.request("tone", 5.0, None)
    assert broken_condition(slide, Compliance(2.0, 0.0, 0.0), SpeedCompliance(0.1, 0.0)) == "too_heavy"
    assert broken_condition(slide, Compliance(1.0, 0.0, 0.8), SpeedCompliance(0.1, 0.8)) is None


TOUCHED = Touched(1.0, 5.0, "0")
TORN = replace(TOUCHED, valid=False, invalid_reason="output_gap", n_gaps=2)


def test_trial_sums_gaps_of_all_intervals():
    fine = replace(TOUCHED, n_gaps=0)
    answer = Reply(Chosen(1, 2.0, 0.5), 1.0)
    assert TrialOutcome((fine, fine), fine, (answer,)).n_gaps == 0
    torn = TrialOutcome((fine, TORN), fine, (answer,))
    assert (torn.n_gaps, torn.valid, torn.invalid_reason) == (2, False, "output_gap")
    assert TrialOutcome((TOUCHED,), TOUCHED, (answer,)).n_gaps is None


@pytest.mark.parametrize(("n_gaps", "reason"), [(None, "experimenter"), (0, "experimenter"), (1, "output_gap")])
def test_invalid_adjustment_names_gap_or_experimenter(n_gaps, reason):
    answer = Reply(Adjusted(5.0, 1.0, 2.0, valid=False, n_gaps=n_gaps), 5.0, correct=True)
    outcome = TrialOutcome((), None, (answer,))
    assert (outcome.valid, outcome.invalid_reason, outcome.n_gaps) == (False, reason, n_gaps)
    assert outcome.correct is None


@pytest.mark.parametrize("reason", REASONS)
def test_every_reason_has_words(reason):
    trial = Trial(1, 1, {}, "staircase", 5.0, "V", "yes_no", None, valid=False, invalid_reason=reason)
    terminal = ExperimenterTerminal()
    assert terminal.outcome(trial, 1) == f"not valid: {terminal.phrase(reason)}"
    again = terminal.outcome(replace(trial, attempt=2), 9)
    assert again == f"not valid: {terminal.phrase(reason)} (trial 1, attempt 2)"
    assert terminal.outcome(replace(trial, valid=True, invalid_reason=None), 1) == "valid"


@pytest.mark.parametrize(
    ("column", "value", "expected", "valid"),
    [
        ("rig", "", "one of bench, console, simulated", 0),
        ("rig", "replay", "one of bench, console, simulated", 0),
        ("invalid_reason", "tired", f"one of {', '.join(REASONS)}, or nothing", 0),
        ("invalid_reason", "lifted", "nothing", 1),
        ("n_gaps", "-1", "a whole number from 0", 0),
        ("speed_in_band", "1.1", "a number from 0 to 1", 0),
    ],
)
def test_invalid_column_values_are_defects(whole, column, value, expected, valid):
    file = next((whole / "data").glob("*.csv"))
    header, first, *_ = file.read_text().splitlines()
    cells = dict(zip(header.split(","), first.split(","), strict=True)) | {"valid": str(valid), column: value}
    (defect,) = defects("\n".join([",".join(cells), ",".join(cells.values())]).encode(), file.name)
    where = " in a valid trial" if valid else ""
    assert defect.text == f"column {column!r}: found {value!r}{where}, expected {expected}"
