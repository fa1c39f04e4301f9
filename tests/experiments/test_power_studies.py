"""Simulated studies of a power analysis, and their required number."""

from dataclasses import astuple, replace

import numpy as np
import pandas as pd
import pytest
from command_line import refused
from scipy import stats
from soak import SOAK
from study_texts import TUTORIAL

from tactometry.analysis.outcomes.outcome import outcome
from tactometry.experiments.harness import share_interval
from tactometry.experiments.power.design import Case, PowerDesign, participants_of
from tactometry.experiments.power.effect import parse_effect
from tactometry.experiments.power.files import Batch, sample
from tactometry.experiments.power.replicate import (
    Row,
    codes,
    half_way_of_choice,
    half_way_of_yes,
    mean_minutes,
    p_of,
    replicate,
    seed_of,
    true_thresholds,
)
from tactometry.experiments.power.scenario import REFUSED, SUPPORTED, check_design, experiment_of, growth
from tactometry.experiments.power.summary import Summary, cautions, recommendation
from tactometry.experiments.study.study_file import load
from tactometry.trials.tasks import TASKS


def design(study="tutorial", effect="frequency_hz: 8 dB", **changes):
    _, content = load(study)
    made = PowerDesign(content, study, parse_effect(effect), **{"participants": (3, 4), "seed": 5, **changes})
    return replace(made, dependent=check_design(made))


def test_each_task_is_supported_or_refused_with_reason():
    assert {*SUPPORTED, *REFUSED} == set(TASKS)
    assert not set(SUPPORTED) & set(REFUSED)


@pytest.mark.parametrize("study", ["tutorial", "time-reversal-threshold"])
@pytest.mark.parametrize("unit", ["dB", "dB SL"])
def test_levels_differ_by_the_effect_and_by_nothing_else(study, unit):
    factor = {"tutorial": "frequency_hz", "time-reversal-threshold": "force_n"}[study]
    planned = design(study, f"{factor}: 3 {unit}")
    levels = experiment_of(planned, planned.cases[0]).study.factors[factor]
    for case, span in zip(planned.cases, (3.0, 0.0), strict=True):
        experiment = experiment_of(planned, case)
        more_db = experiment.study.observer["people"]["effects_db"][factor].values()
        grown = [growth(experiment, cell) for cell in experiment.cells.values()]
        felt_db = [own + more for (own, _), more in zip(grown, more_db, strict=True)]
        per = [1.0 if unit == "dB SL" else -slope for _, slope in grown]
        steps = [(db - felt_db[0]) / slope for db, slope in zip(felt_db, per, strict=True)]
        assert np.allclose(steps, np.linspace(0, span, len(levels)), atol=1e-6)


def test_smaller_study_is_start_of_larger_one(tmp_path):
    (path := tmp_path / "constant.toml").write_text(TUTORIAL, "utf-8")
    both, small = design(str(path)), design(str(path), participants=(3,))
    assert replicate(both, both.cases[0], 2)[0] == replicate(small, small.cases[0], 2)[0]


STATED = b"""
[observer]
kind = "psychometric"
threshold = 31.0
between_sd_db = 2.5
conditions = [{ frequency_hz = 60, threshold = 25.0 }]
"""


@pytest.fixture
def stated(tmp_path):
    _, content = load("tutorial")
    path = tmp_path / "stated.toml"
    path.write_bytes(content.partition(b"\n[observer")[0] + STATED)
    return str(path)


@pytest.mark.parametrize("study", ["stated", "tutorial"])
def test_true_thresholds_differ_by_the_effect(request, study):
    name = request.getfixturevalue(study) if study == "stated" else study
    planned = design(name, "frequency_hz: 4 dB")
    for case, expected in zip(planned.cases, (4.0, 0.0), strict=True):
        experiment = experiment_of(planned, case)
        table = true_thresholds(experiment, codes(200), 3).pivot(
            index="participant", columns="frequency_hz", values="truth"
        )
        steps = table[240] - table[60]
        error = steps.std() / 200**0.5
        assert abs(steps.mean() - expected) <= max(3.9 * error, 1e-9)
        assert study != "stated" or np.allclose(steps, expected)


def test_stated_thresholds_take_no_effect_of_sensation(capsys, stated):
    said = refused(capsys, "power", stated, "--effect", "frequency_hz: 4 dB SL", "--participants", "3", "--seed", "5")
    assert "found the unit 'dB SL', expected one of dB" in said


def test_yes_is_half_way_at_the_true_threshold():
    """Compare with an exact binomial test of the observer's answers."""
    experiment = experiment_of(planned := design(), planned.cases[1])
    observer = replace(experiment.simulated_participant("P001", 5), lapse_rate=0.0)
    criterion, rng, n = observer.criterion + observer.bias, np.random.default_rng(7), 20_000
    level_db = 20 / observer.exponent * np.log10(half_way_of_yes(criterion) / observer.criterion)
    n_yes = sum(observer.detect(level_db - observer.sensitivity_db, rng) for _ in range(n))
    assert stats.binomtest(n_yes, n, (1 + stats.norm.sf(criterion)) / 2).pvalue > 1e-4


def test_forced_choice_is_75_percent_at_true_threshold():
    assert stats.norm.cdf(half_way_of_choice(2) / 2**0.5) == pytest.approx(0.75)


def test_studies_have_seeds_of_their_own():
    assert len({seed_of(seed, number) for seed in range(20) for number in range(500)}) == 10_000


def test_minutes_are_summed_in_the_order_of_participants():
    minutes = pd.Series(np.random.default_rng().random(24), codes(24))
    found = [mean_minutes(minutes.drop("P002"), n) for n in range(3, 25)]
    assert found == [float(minutes.iloc[[0, *range(2, n)]].mean()) for n in range(3, 25)]


def test_dropout_removes_later_trials_only():
    whole, left = design(participants=(4,)), design(participants=(4,), dropout_share=0.9)
    (stayed,), (lost,) = (replicate(each, each.cases[0], 0) for each in (whole, left))
    assert lost.minutes < stayed.minutes
    assert lost.n_cells == stayed.n_cells
    assert lost.n_unknown > stayed.n_unknown


def drawn_rows(planned, chance):
    """Return a batch's rows with tests that are significant by chance."""

    def rows_of(batch):
        rng = np.random.default_rng((batch.first, batch.case.has_effect))
        return tuple(
            Row(0, batch.case.has_effect, number, n, 0.5, bool(rng.random() < chance[batch.case.has_effect][n]),
                None, None, None, 2, 0, 0, 1.0)
            for number in range(batch.first, batch.end)
            for n in planned.participants
        )  # fmt: skip

    return rows_of


def test_sampling_stops_when_it_knows_enough_and_not_before():
    planned = design(participants=(3, 4))
    chances = {True: {3: 0.2, 4: 0.8}, False: {3: 0.05, 4: 0.05}}
    batches = list(sample(planned, spread=lambda *_: iter(()), kept=drawn_rows(planned, chances)))
    found = Summary(planned)
    for _, rows in batches:
        found.add(rows)
    low, high = found.points()
    assert (high.power_high - high.power_low) / 2 <= planned.precision
    assert low.power_high < planned.target
    assert (high.false_positives_high - high.false_positives_low) / 2 <= planned.precision
    before = high.n_studies - planned.batch
    ends = share_interval(round(high.power * before), before)
    assert (ends[1] - ends[0]) / 2 > planned.precision
    assert recommendation(planned, (high,)) != recommendation(planned, (low,))


def test_studies_without_a_test_are_told():
    planned = design(participants=(3,), most=20)
    rows = drawn_rows(planned, {True: {3: 0.0}, False: {3: 0.0}})
    found = Summary(planned)
    for batch, of_batch in sample(planned, spread=lambda *_: iter(()), kept=rows):
        found.add(replace(row, p=None if row.replicate < 5 and batch.case.has_effect else 0.5) for row in of_batch)
    (warning,) = cautions(planned, found.points())
    assert warning.startswith("no test had a result in 25% of the studies with 3 participants")


def test_sampling_ends_at_the_most_that_was_asked_for():
    planned = design(participants=(3,), most=50)
    rows_of = drawn_rows(planned, {True: {3: 0.8}, False: {3: 0.5}})
    ends = [batch.end for batch, _ in sample(planned, spread=lambda *_: iter(()), kept=rows_of)]
    assert ends == [20, 40, 50, 20, 40, 50]


def test_names_of_batches_sort_by_their_numbers():
    names = [Batch(Case(40, True), first, first + 20).name for first in (0, 20, 1000)]
    assert names == sorted(names)


def test_participants_are_few_numbers_of_a_wide_range():
    assert participants_of("6..24")[::6] == (6, 24)
    assert len(participants_of("6..100")) == 7


@pytest.mark.slow
@pytest.mark.parametrize("difference", [0.0, 1.0])
def test_power_of_normal_values_matches_closed_form(difference):
    """Differences have unit variance: noncentral t with n - 1 degrees."""
    rng, n, n_studies = np.random.default_rng(17), 10, 20_000 if SOAK else 300
    table = pd.DataFrame({"participant": [f"P{k:03d}" for k in range(n)] * 2, "force_n": np.repeat([1.0, 2.0], n)})
    significant = 0
    for _ in range(n_studies):
        own = rng.normal(0, 3, n)
        values = np.stack([own + rng.normal(0, 0.5**0.5, n), own + difference + rng.normal(0, 0.5**0.5, n)])
        with_values = table.assign(threshold=values.ravel())
        p = p_of(outcome(with_values, ["force_n"], "yes_no", "threshold"), "force_n")
        significant += p is not None and p < 0.05
    critical = stats.t.ppf(0.975, n - 1)
    noncentral = stats.nct(n - 1, difference * n**0.5)
    power = noncentral.sf(critical) + noncentral.cdf(-critical)
    assert stats.binomtest(significant, n_studies, power).pvalue > 1e-4


def test_rows_contain_plain_numbers():
    planned = design()
    (row, _) = replicate(planned, planned.cases[0], 0)
    assert all(value is None or type(value) in (int, float, bool) for value in astuple(row))
