"""Session rules: randomness, orders of conditions, limits and journals."""

import io
import itertools
import json
import math
import os
from collections import Counter
from dataclasses import replace
from pathlib import Path

import catalogue
import pytest
from hypothesis import given, strategies as st
from memory import Memory
from tutorial_session import EXPERIMENT, STUDY, TOML, live

from tactometry.config.quantity import si
from tactometry.errors import InvalidFile, InvalidParameter, LimitExceeded
from tactometry.experiments.bench.bench_file import BenchFile
from tactometry.experiments.data_sets.validation import validate
from tactometry.experiments.sessions.simulation import Simulation
from tactometry.experiments.study.dry_run import duration_s, plan
from tactometry.experiments.study.experiment import wire
from tactometry.gates import ForceGate
from tactometry.observers.signal_detection import SignalDetectionObserver
from tactometry.protocols import Staircase
from tactometry.protocols.order import Crossing, n_orders, williams_square
from tactometry.records.data_set import Session
from tactometry.records.open_journal import Journal
from tactometry.records.open_session import OpenSession
from tactometry.rigs.console import Console
from tactometry.rigs.texts import texts_in
from tactometry.safety.limits import Limits
from tactometry.session.request import Play, Slide, Wait
from tactometry.session.run import run


def presented(participant, n_session, seed):
    """Return levels and catch trials in order, without repetitions."""
    memory = Memory()
    rig = EXPERIMENT.simulated_rig(participant, n_session, seed)
    run(EXPERIMENT.course(participant, n_session, 1, seed), rig, memory)
    return [(trial.level, trial.catch) for trial in memory.trials if trial.attempt == 1]


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


@pytest.mark.parametrize(
    ("start", "answers", "options", "ending"),
    [
        (0.0, (1, 1, 0), {"n_reversals": 99, "n_at_bound": 3}, None),
        (38.0, (1, 0), {"n_reversals": 1, "n_at_bound": 1}, "censored_above"),
    ],
    ids=["moves at both bounds", "reversal at a bound"],
)
def test_staircase_delivered_at_bound_has_ending(start, answers, options, ending):
    rule = Staircase(start, steps=(2.0,), low=0.0, high=40.0, n_down=1, **options)
    for answer in answers[:-1]:
        rule = rule.after(answer)
    assert rule.after(answers[-1], delivered=40.0).ending == ending


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


@pytest.mark.parametrize(
    ("text", "suffix", "value"),
    [
        *(("5 cm/s", "m_per_s", 0.05), ("2.5 g/cm3", "kg_per_m3", 2500.0), ("3 kohm m", "ohm_m", 3e3)),
        *(("70 GPa", "pa", 70e9), ("2 h", "s", 7200.0), ("20 nm", "m", 20e-9), ("4 mm2", "m2", 4e-6)),
    ],
)
def test_compound_units(text, suffix, value):
    assert si(text, suffix, "x") == pytest.approx(value, rel=1e-15)


def test_sessions_of_one_participant_have_different_orders():
    assert presented("P01", 1, 1) == presented("P01", 1, 1)
    assert presented("P01", 1, 1) != presented("P01", 2, 1)


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


@pytest.mark.parametrize(("of_bench", "of_study", "holds"), [(1.0, 2.0, 1.0), (2.0, 1.0, 1.0)])
def test_the_tighter_duration_of_bench_and_study_holds(of_bench, of_study, holds):
    bench = BenchFile(limits=Limits(100.0, of_bench))
    assert bench.limits_with(Limits(50.0, of_study)).duration_s == holds


@pytest.mark.parametrize(("catch_rate", "n_trials"), [(0.2, 20), (0.0, 16)])
def test_plan_counts_catch_trials(catch_rate, n_trials):
    experiment = wire(replace(STUDY, task={**STUDY.task, "catch_rate": catch_rate}), "x")
    assert [block.n_trials_at_most for block in plan(experiment, 1)] == [n_trials] * 2


@pytest.mark.parametrize("exponent", [0.5, 1.0, 3.0])
def test_the_transducer_acts_on_the_sensation_level(exponent):
    """d' is the criterion at the threshold, and 10^exponent of it at 20 dB above."""
    observer = SignalDetectionObserver(exponent=exponent, sensitivity_db=7.0)
    assert observer.d_prime(-7.0) == pytest.approx(observer.criterion, rel=1e-12)
    assert observer.d_prime(13.0) == pytest.approx(observer.criterion * 10**exponent, rel=1e-12)


def test_console_checks_signals_against_limits():
    output = catalogue.silent(catalogue.AnyStimulus(), Limits(voltage_peak_v=0.1))
    console = Console(output, texts_in("en", {}), source=io.StringIO(), output=io.StringIO())
    with pytest.raises(LimitExceeded, match="nothing was played"):
        console.answer(Play("tone", 20.0, 0.2))


def test_console_clock_continues_after_interruption():
    console = catalogue.console()
    console.resume([], 100.0)
    assert 100.0 <= console.answer(Wait(0.0)).at_s < 200.0


def test_sessions_of_one_participant_have_different_random_answers():
    request = Slide("frequency_hz=60", 20.0, 0.2, 1.0, 0.2, 0.5, 5.0, 0.05)
    held = []
    for n_session in (1, 2):
        rig = EXPERIMENT.simulated_rig("P01", n_session, 1)
        held.append(rig.answer(replace(request, stimulus=next(iter(EXPERIMENT.bank)))).force_mean_n)
    assert held[0] != held[1]


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


def counterbalanced(factors, number):
    """Return a participant's cells with Williams squares for every factor."""
    return Crossing(factors, dict.fromkeys(factors, "williams")).cells(number - 1, None)


def chunks(values, size):
    return [values[n : n + size] for n in range(0, len(values), size)]


@given(n=st.integers(2, 14))
def test_each_condition_follows_each_other_equally_often(n):
    pairs = Counter(pair for row in williams_square(n) for pair in itertools.pairwise(row))
    assert len(pairs) == n * (n - 1)
    assert len(set(pairs.values())) == 1


@given(n=st.integers(1, 14))
def test_each_condition_stands_equally_often_in_each_position(n):
    rows = williams_square(n)
    places = Counter((position, item) for row in rows for position, item in enumerate(row))
    assert set(places.values()) == {len(rows) // n}
    assert len(rows) == n_orders("williams", n)


@given(sizes=st.lists(st.integers(1, 5), min_size=1, max_size=3), number=st.integers(1, 100))
def test_every_cell_comes_once(sizes, number):
    factors = {f"factor_{n}": list(range(size)) for n, size in enumerate(sizes)}
    cells = counterbalanced(factors, number)
    assert len({tuple(cell.items()) for cell in cells}) == len(cells) == math.prod(sizes)


def test_the_outer_factor_changes_slowest():
    cells = counterbalanced({"force_n": [0.5, 1.5], "frequency_hz": [30, 60, 120]}, 1)
    assert [cell["force_n"] for cell in cells] == [0.5] * 3 + [1.5] * 3


def test_outer_orders_are_balanced_over_full_square():
    orders = Counter(
        tuple(dict.fromkeys(cell["force_n"] for cell in counterbalanced({"force_n": [1, 2, 3]}, number)))
        for number in range(1, 13)
    )
    assert set(orders.values()) == {2}


@given(
    rules=st.tuples(*[st.sampled_from(["williams", "complete", "fixed"])] * 2),
    sizes=st.tuples(st.integers(1, 4), st.integers(2, 3)),
)
def test_orders_of_two_factors_are_fully_crossed(rules, sizes):
    slow, fast = (n_orders(rule, size) for rule, size in zip(rules, sizes, strict=True))
    factors = {"slow": list(range(sizes[0])), "fast": list(range(sizes[1]))}
    crossing, orders = Crossing(factors, dict(zip(factors, rules, strict=True))), Counter()
    for row in range(slow * fast):
        for place, cells in enumerate(chunks(crossing.cells(row, None), sizes[1])):
            orders[place, cells[0]["slow"], tuple(cell["fast"] for cell in cells)] += 1
    assert len({order for *_, order in orders}) == fast
    assert len(orders) == len({key[:2] for key in orders}) * fast
    assert len(set(orders.values())) == 1


def test_order_follows_file_without_counterbalancing():
    cells = Crossing({"a": [1, 2], "b": [3, 4]}).cells(6, None)
    assert cells == [{"a": 1, "b": 3}, {"a": 1, "b": 4}, {"a": 2, "b": 3}, {"a": 2, "b": 4}]
