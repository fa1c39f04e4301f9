"""Session rules: randomness, seeds, limits and journals."""

import io
import json
import math
import os
from dataclasses import replace
from pathlib import Path

import catalogue
import numpy as np
import pytest
from memory import Memory
from tutorial_session import EXPERIMENT, STUDY, TOML, live

from tactometry.config.quantity import si
from tactometry.errors import Diverged, InvalidFile, InvalidParameter, LimitExceeded
from tactometry.experiments.bench.bench_file import BenchFile
from tactometry.experiments.data_sets.replaying import replay_data_set
from tactometry.experiments.data_sets.validation import validate
from tactometry.experiments.sessions.simulation import Simulation
from tactometry.experiments.study.dry_run import duration_s, plan
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.study_file import load
from tactometry.gates import ForceGate
from tactometry.observers.signal_detection import SignalDetectionObserver
from tactometry.protocols import Staircase
from tactometry.protocols.order import Crossing
from tactometry.records.data_set import Session
from tactometry.records.open_journal import Journal
from tactometry.records.open_session import OpenSession
from tactometry.rigs.console import Console
from tactometry.rigs.texts import texts_in
from tactometry.safety.limits import Limits
from tactometry.session.request import Play, Slide, Wait
from tactometry.session.run import run
from tactometry.signal import Signal

N_DRAWS = 20_000
STANDARD_ERRORS = 3.9
"""Of a two-sided test at 1e-4."""


def asked(participant, n_session, seed):
    """Return levels and catch trials in order, without repetitions."""
    memory = Memory()
    rig = EXPERIMENT.simulated_rig(participant, n_session, seed)
    run(EXPERIMENT.course(participant, n_session, 1, seed), rig, memory)
    return [(trial.level, trial.catch) for trial in memory.trials if trial.attempt == 1]


def near(count, n, probability):
    return abs(count - n * probability) <= STANDARD_ERRORS * math.sqrt(n * probability * (1 - probability))


def test_new_journal_is_synced_with_its_folder(tmp_path, synced):
    live(tmp_path)
    head = synced.index(Session("P01", 1, STUDY.name).journal(tmp_path))
    assert synced[head + 1] == tmp_path / "journals"


def test_truncated_line_is_moved_before_session_resumes(tmp_path, synced):
    path = tmp_path / "j.jsonl"
    path.write_bytes(b'{"study":"tut')
    journal = Journal(path, resume=True)
    draft = tmp_path / f".j.jsonl.{os.getpid()}"
    assert synced == [journal.interruptions, draft, tmp_path]
    journal.close()
    assert path.read_bytes() == b""
    assert not draft.exists()


def test_session_is_unlocked_when_its_files_are_unwritable(lived):
    """The trials file is a folder, so it cannot be rebuilt."""
    session = Session("P01", 1, STUDY.name)
    trials = next((lived / "data").glob("*.csv"))
    content = trials.read_bytes()
    trials.unlink()
    trials.mkdir()
    with pytest.raises(InvalidFile, match="found a folder, expected a file of a data set"):
        OpenSession(lived, EXPERIMENT.design(TOML), session, "simulated", resume=True)
    trials.rmdir()
    OpenSession(lived, EXPERIMENT.design(TOML), session, "simulated", resume=True).close()
    assert trials.read_bytes() == content


def test_moves_at_bounds_are_counted_separately():
    rule = Staircase(start=0.0, steps=(2.0,), low=0.0, high=40.0, n_down=1, n_reversals=99, n_at_bound=3)
    assert rule.after(1).after(1).after(0, delivered=40.0).ending is None


def test_run_ending_at_bound_stays_censored_despite_reversal():
    rule = Staircase(start=38.0, steps=(2.0,), low=0.0, high=40.0, n_down=1, n_reversals=1, n_at_bound=1)
    assert rule.after(1).after(0, delivered=40.0).ending == "censored_above"


def test_inner_factor_uses_next_order_each_round():
    factors = {"force_n": [1, 2], "frequency_hz": [30, 60, 120]}
    cells = Crossing(factors, dict.fromkeys(factors, "williams")).cells(0, None)
    frequencies = [cell["frequency_hz"] for cell in cells]
    assert frequencies[:3] != frequencies[3:]


def test_hold_survives_two_samples_with_equal_time():
    gate = ForceGate(target_n=1.0, tolerance=0.2, hold_s=0.01, max_gap_s=0.02)
    for time_s in (0.0, 0.005, 0.005, 0.01):
        gate = gate.after(time_s, 1.0)
    assert gate.open
    assert not gate.after(0.009, 1.0).open


def test_signal_longer_than_limit_is_refused():
    limits = Limits(voltage_peak_v=1.0, duration_s=0.1)
    limits.check(Signal(np.zeros((1, 100)), 1e3, "V"))
    with pytest.raises(LimitExceeded, match=r"found a signal of 0\.101 s, the limit is 0\.1 s; shorten it"):
        limits.check(Signal(np.zeros((1, 101)), 1e3, "V"))


@pytest.mark.parametrize(
    ("text", "suffix", "value"),
    [
        ("5 cm/s", "m_per_s", 0.05),
        ("2.5 g/cm3", "kg_per_m3", 2500.0),
        ("3 kohm m", "ohm_m", 3e3),
        ("70 GPa", "pa", 70e9),
        ("2 h", "s", 7200.0),
        ("20 nm", "m", 20e-9),
        ("4 mm2", "m2", 4e-6),
    ],
)
def test_compound_units(text, suffix, value):
    assert si(text, suffix, "x") == pytest.approx(value, rel=1e-15)


def test_sessions_of_one_participant_have_different_orders():
    assert asked("P01", 1, 1) == asked("P01", 1, 1)
    assert asked("P01", 1, 1) != asked("P01", 2, 1)


def test_simulated_traits_depend_on_participant_and_seed():
    people = [("P01", 1), ("P02", 1), ("P01", 2)]
    traits = [EXPERIMENT.simulated_participant(*who).sensitivity_db for who in people]
    assert len(set(traits)) == 3
    assert EXPERIMENT.simulated_participant("P01", 1).sensitivity_db == traits[0]


@pytest.mark.parametrize(
    ("n_participants", "first", "last"), [(3, "P01", "P03"), (99, "P01", "P99"), (100, "P001", "P100")]
)
def test_codes_of_simulated_participants_sort_as_their_numbers(n_participants, first, last):
    codes = [who.participant for who in Simulation(TOML, "tutorial", Path(), n_participants, 1).sessions()]
    assert (codes[0], codes[-1]) == (first, last)
    assert codes == sorted(codes)


def test_described_but_absent_column_is_a_defect(lived):
    path = lived / "dataset_description.json"
    description = json.loads(path.read_bytes())
    description["variableMeasured"].append({"name": "mood"})
    path.write_text(json.dumps(description))
    (defect,) = validate(lived).defects
    assert "has no such column 'mood'" in str(defect)


def test_replay_rejects_study_edited_after_session(lived):
    """The requests are unchanged: only the digest differs."""
    path = lived / "study.toml"
    path.write_bytes(path.read_bytes() + b"\n# another line\n")
    with pytest.raises(Diverged, match="line 1: found the digest of another study.toml"):
        replay_data_set(lived)


@pytest.mark.parametrize(("of_bench", "of_study", "holds"), [(1.0, 2.0, 1.0), (2.0, 1.0, 1.0)])
def test_the_tighter_duration_of_bench_and_study_holds(of_bench, of_study, holds):
    bench = BenchFile(limits=Limits(100.0, of_bench))
    assert bench.limits_with(Limits(50.0, of_study)).duration_s == holds


def test_a_plan_counts_catch_trials():
    """16 stimuli and, at a rate of 0.2, one catch trial for every four of them."""
    assert [block.n_trials_at_most for block in plan(EXPERIMENT, 1)] == [20, 20]


def test_lapses_of_detection_are_guesses():
    lapsing = SignalDetectionObserver(lapse_rate=0.5)
    rng = np.random.default_rng(20261121)
    assert near(sum(lapsing.detect(1000.0, rng) for _ in range(N_DRAWS)), N_DRAWS, 0.75)


def test_lapses_of_a_comparison_are_guesses():
    lapsing = SignalDetectionObserver(lapse_rate=0.5)
    rng = np.random.default_rng(20261121)
    hits = sum(lapsing.compare([-math.inf, 1000.0, -math.inf], rng) == 1 for _ in range(N_DRAWS))
    assert near(hits, N_DRAWS, 0.5 + 0.5 / 3)


@pytest.mark.parametrize("exponent", [0.5, 1.0, 3.0])
def test_the_transducer_acts_on_the_sensation_level(exponent):
    """d' is the criterion at the threshold, and 10^exponent of it at 20 dB above."""
    observer = SignalDetectionObserver(exponent=exponent, sensitivity_db=7.0)
    assert observer.d_prime(-7.0) == pytest.approx(observer.criterion, rel=1e-12)
    assert observer.d_prime(13.0) == pytest.approx(observer.criterion * 10**exponent, rel=1e-12)


def test_console_checks_signals_against_limits():
    tight = Limits(voltage_peak_v=0.1)
    console = Console(
        catalogue.silent(catalogue.AnyStimulus(), tight), texts_in("en", {}), source=io.StringIO(), output=io.StringIO()
    )
    with pytest.raises(LimitExceeded, match="nothing was played"):
        console.answer(Play("tone", 20.0, 0.2))


def test_console_clock_continues_after_interruption():
    console = catalogue.console()
    console.resume([], 100.0)
    assert 100.0 <= console.answer(Wait(0.0)).at_s < 200.0


def test_plan_depends_on_catch_rate():
    none = replace(STUDY, task={**STUDY.task, "catch_rate": 0.0})
    assert [block.n_trials_at_most for block in plan(wire(none, "x"), 1)] == [16, 16]


def test_sessions_of_one_participant_have_different_random_answers():
    """The first touch of two sessions has different forces."""
    request = Slide("frequency_hz=60", 20.0, 0.2, 1.0, 0.2, 0.5, 5.0, 0.05)
    held = []
    for n_session in (1, 2):
        rig = EXPERIMENT.simulated_rig("P01", n_session, 1)
        held.append(rig.answer(replace(request, stimulus=next(iter(EXPERIMENT.bank)))).force_mean_n)
    assert held[0] != held[1]


def test_highest_level_is_checked_against_limits():
    study, _ = load("electrovibration-threshold")
    high = replace(study, procedure={**study.procedure, "start": 10.0, "high": 47.0})
    with pytest.raises(InvalidParameter, match="found the highest level 47, expected one within the limits"):
        wire(high, "x")


def test_study_rejects_stimulus_longer_than_limit():
    long = replace(STUDY, stimulus={**STUDY.stimulus, "duration_s": 100.0})
    with pytest.raises(InvalidParameter, match=r"stimulus\.duration_s: found 100 s, expected at most"):
        wire(long, "x")


def test_plan_uses_time_per_trial_of_study():
    slow = wire(replace(STUDY, trial_s=7.0), "x")
    assert duration_s(slow, plan(slow, 1)) == pytest.approx(7.0 * 40)


@pytest.mark.parametrize("hold_s", [20.0, 30.0])
def test_hold_longer_than_timeout_is_refused(hold_s):
    study = replace(STUDY, touch={**STUDY.touch, "hold_s": hold_s})
    with pytest.raises(InvalidParameter, match=r"touch\.hold_s: found .* s, expected less than timeout_s \(20 s\)"):
        wire(study, "x")
