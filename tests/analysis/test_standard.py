"""Tests of comparisons with a standard, of lapse rates, and of the curve figure."""

import json
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from command_line import output
from scipy.stats import norm, t as student, ttest_1samp

from tactometry.analysis.figures.curves import MAX_PANELS, Panel, curve_figure
from tactometry.analysis.tasks.cell import Cell, Estimate
from tactometry.analysis.tasks.cells import estimates
from tactometry.analysis.tasks.comparison import FIT
from tactometry.analysis.tasks.lapses import lapse_table, lapse_warnings
from tactometry.analysis.tasks.standard import floor_warnings, lowest_levels, standard_sentences, standard_tests
from tactometry.analysis.threshold.equality import equalities, fit_comparisons
from tactometry.analysis.threshold.fitting import fitting
from tactometry.experiments.bias_study.comparisons import N_AT_STANDARD, STANDARD, STANDARD_LEVELS, answers_to_standard


@pytest.mark.parametrize("above_db", [0.0, 12.0])
def test_pse_is_standard_when_standard_is_at_threshold(above_db) -> None:
    n_more = answers_to_standard(above_db, 120, np.random.default_rng())
    found = [one.threshold for one in fit_comparisons(STANDARD_LEVELS, n_more, N_AT_STANDARD, **FIT)]
    errors = np.array([value for value in found if value is not None]) - STANDARD
    assert len(errors) >= 0.95 * len(found)
    deviation = float(errors.std(ddof=1))
    # Allowed is a bias of half a standard deviation: the equal asymptotes were off by two.
    assert abs(errors.mean()) < deviation * (0.5 + norm.isf(0.5e-4) / np.sqrt(len(errors)))


def cell(n_more: int, n_trials: int = 20) -> Cell:
    counts = (n_more, 4, 10, 16, 19)
    return Cell("P01", (1.0,), "comparison", (36.0, 38.0, 40.0, 42.0, 44.0), counts, (n_trials,) * 5, 0, 0)


@pytest.mark.parametrize(("n_more", "is_warned"), [(0, False), (3, False), (6, True)])
def test_lowest_level_is_warned_of_when_often_more(n_more, is_warned) -> None:
    table = lowest_levels([cell(n_more)], ["force_n"])
    assert [n_more / 20] == table["rate"].tolist()
    assert bool(list(floor_warnings(table, ["force_n"]))) == is_warned


def tables(pses, unit="dB re 1 V", status="ok"):
    codes = [f"P{n:02d}" for n in range(len(pses))]
    jnds = {"jnd": [None if pse is None else pse - 38 for pse in pses], "jnd_low": 1.0, "jnd_high": 4.0}
    known = {"task": "comparison", "pse": pses, "level_unit": unit, "status": status}
    found = {"participant": codes, **known, **jnds}
    low, high = ([None if pse is None else pse + side for pse in pses] for side in (-1.0, 1.0))
    used = pd.DataFrame({"participant": codes, "task": "comparison", "standard_level": "40"})
    return pd.DataFrame({**found, "interval_low": low, "interval_high": high}), used


def test_pse_is_tested_against_standard_over_participants() -> None:
    pses = [40.5, 41.0, 40.2, 41.5, None]
    (row,) = standard_tests(*tables(pses), []).to_dict("records")
    expected = ttest_1samp(pses[:4], 40.0)
    assert (row["t"], row["p"]) == pytest.approx((expected.statistic, expected.pvalue))
    assert (row["n"], row["n_without"]) == (4, 1)
    half = student.ppf(0.975, 3) * np.std(pses[:4], ddof=1) / 2
    assert row["difference_low"] == pytest.approx(0.8 - half)


@pytest.mark.parametrize(("pse", "differs"), [(40.5, False), (41.5, True), (38.5, True)])
def test_one_participant_is_tested_by_posterior_interval(pse, differs) -> None:
    (row,) = standard_tests(*tables([pse]), []).to_dict("records")
    assert row["differs"] is differs


@pytest.mark.parametrize(("unit", "fraction"), [("dB re 1 V", 10 ** (2.8 / 20) - 1), ("V", 2.8 / 40)])
def test_weber_fraction_is_mean_jnd_over_standard(unit, fraction) -> None:
    (row,) = standard_tests(*tables([40.5, 41.0, 40.2, 41.5, None], unit), []).to_dict("records")
    assert (row["jnd"], row["weber_fraction"]) == pytest.approx((2.8, fraction))
    assert row["jnd_low"] < 2.8 < row["jnd_high"]


@pytest.mark.parametrize(("status", "differs"), [("flat", None), ("threshold_above_range", True)])
def test_flat_interval_does_not_test_standard(status, differs) -> None:
    estimates_of, used = tables([None], status=status)
    table = standard_tests(estimates_of.assign(interval_low=42.0), used, [])
    assert (table["differs"].item(), table["n"].item(), table["n_without"].item()) == (differs, 0, 1)
    assert ("interval" in standard_sentences(table, [], "dB")[0]) is (differs is not None)


def test_flat_comparison_has_interval_of_pse() -> None:
    (found,) = estimates([replace(cell(9), n_yes=(8, 10, 11, 10, 12))], 2)
    (equality,) = equalities(fitting(found.cell.levels, found.cell.n_yes, 20, **FIT))
    assert (found.fit.status, found.fit.threshold) == ("flat", None)
    ends = (found.fit.interval_low, found.fit.interval_high)
    assert ends != (None, None)
    assert all(end in (None, of_pse) for end, of_pse in zip(ends, equality.pse[::2], strict=True))


def test_pse_halves_all_answers_on_fitted_curve() -> None:
    (found,) = estimates([cell(7)], 2)
    assert found.fit.function.probability(found.fit.threshold) == pytest.approx(0.5, abs=0.03)


def comparisons(path, counts, n):
    """Write answers of "more" by participant and force at five levels around a standard of 40 dB."""
    rows = [
        (who, n * k + trial, force, "constant_stimuli", 36 + 2 * k, int(trial < more))
        for (who, force), n_more in counts.items()
        for k, more in enumerate(n_more)
        for trial in range(n)
    ]
    table = pd.DataFrame(rows, columns=["participant", "trial", "force_n", "procedure", "level", "response"])
    table.assign(level_unit="dB", task="comparison", standard_level=40).to_csv(path, index=False)
    return path


def test_analyse_reports_standard_everywhere(tmp_path, capsys) -> None:
    counts = {(f"P{who}", 1): [more - (more == who + 1) for more in (3, 4, 5, 8, 9)] for who in (1, 2, 3)}
    data, page = comparisons(tmp_path / "trials.csv", counts, 10), tmp_path / "report.html"
    found = json.loads(output(capsys, "analyse", data, "--report", page, "--json"))
    assert [row["standard_level"] for row in found["standard"]] == [40]
    assert [row["n_trials"] for row in found["lowest_levels"]] == [30]
    assert any("at the lowest level" in line for line in found["warnings"])
    text = output(capsys, "analyse", data)
    for shown in (page.read_text("utf-8"), text):
        assert "PSE minus the standard of 40 dB" in shown
    assert "Weber fraction" in text


def test_standard_has_mean_jnd_of_group_table(tmp_path, capsys) -> None:
    step, slopes = (0, 0, 0, 8, 8), ((0, 2, 4, 6, 8), (0, 1, 4, 7, 8), (1, 3, 4, 6, 7), (0, 2, 5, 7, 8))
    counts = {(f"P{who}", force): more for who, more in enumerate(slopes, 1) for force in (1, 2)} | {("P1", 2): step}
    data = comparisons(tmp_path / "trials.csv", counts, 8)
    found = json.loads(output(capsys, "analyse", data, "--json"))
    (group,) = (one["group"] for one in found["outcomes"] if one["dependent"] == "jnd")
    of_group = [[row["mean"], row["mean_low"], row["mean_high"], row["n"]] for row in group]
    assert [[row[name] for name in ("jnd", "jnd_low", "jnd_high", "n_jnd")] for row in found["standard"]] == of_group
    assert "dB (n = 3), Weber fraction" in output(capsys, "analyse", data)


def test_dry_run_warns_of_standard_near_threshold(capsys) -> None:
    text = output(capsys, "run", "texture-discrimination", "--participant", "P01", "--dry-run")
    assert "WARNING: the standard (40 dB re 1 V) is 6.9 dB above the predicted threshold" in text
    assert "some participants may not feel it" in text


LEVELS, N_TRIALS = (10.0, 16.0, 22.0, 28.0, 34.0), 40
WITHOUT = (20, 24, 34, 40, 40)
WITH = (20, 24, 32, 35, 36)
FEW_EASY = (21, 22, 24, 28, 33)


def cells(*answers, task="forced_choice", people=4):
    """Four participants, who answer alike, in conditions a, b, ..."""
    return [
        Cell(f"P{n}", ("ab"[place],), task, LEVELS, n_yes, (N_TRIALS,) * 5, n_catch=20, n_false_alarms=1)
        for n in range(people)
        for place, n_yes in enumerate(answers)
    ]


def compared(*answers, **options):
    table = lapse_table(estimates(cells(*answers, **options), "dB"), ["posture"])
    return table, list(lapse_warnings(table, ["posture"]))


def test_different_lapse_rates_have_warning():
    table, (warning,) = compared(WITHOUT, WITH)
    assert table["lapse_rate"].tolist() == pytest.approx([0.0, 0.1], abs=0.04)
    assert "from 0.0 [0.0, " in warning
    assert "for this reason alone" in warning


@pytest.mark.parametrize("answers", [(WITHOUT, WITHOUT), (WITH, WITH), (WITHOUT, FEW_EASY), (WITH,)])
def test_equal_or_unknown_lapses_have_no_warning(answers):
    assert not compared(*answers)[1]


def test_rates_of_yes_are_compared_too():
    yes = [tuple(2 * n - N_TRIALS for n in answers) for answers in (WITHOUT, WITH)]
    assert len(compared(*yes, task="yes_no")[1]) == 1


def test_analyse_warns_of_different_lapses(tmp_path, capsys):
    rows = [
        (cell.participant, cell.condition[0], level, "dB", "forced_choice", 1, 2 - (n < n_yes))
        for cell in cells(WITHOUT, WITH, people=2)
        for level, n_yes in zip(cell.levels, cell.n_yes, strict=True)
        for n in range(N_TRIALS)
    ]
    names = ["participant", "posture", "level", "level_unit", "task", "target", "response"]
    pd.DataFrame(rows, columns=names).to_csv(tmp_path / "t.csv", index=False)
    found = json.loads(output(capsys, "analyse", tmp_path / "t.csv", "--within", "posture", "--json"))
    assert [row["lapse_rate"] for row in found["lapse_rates"]] == pytest.approx([0.0, 0.1], abs=0.04)
    assert any("lapse rates of forced_choice differ" in text for text in found["warnings"])


def estimate(level: float = 20.0, k=(0, 3, 7, 10)) -> Estimate:
    levels = tuple(level + step for step in range(4))
    (made,) = estimates([Cell("P01", (level,), "yes_no", levels, k, (10,) * 4, 0, 0)])
    return made


@pytest.fixture(scope="module")
def panel() -> Panel:
    return Panel(estimate(), left=1.0, bottom=2.0, width=3.0, height=1.0, low=20.0, high=23.0)


def test_panel_clips_levels_to_its_axis(panel: Panel) -> None:
    x = panel.x([20.0, 21.5, 23.0])
    assert x[1] == pytest.approx(2.5)
    assert 1.0 < x[0] < x[2] < 4.0
    np.testing.assert_allclose(panel.x([-100.0, 100.0]), [1.0, 4.0])


def test_panel_contains_rates_and_threshold_bar(panel: Panel) -> None:
    bar, nothing, all_ = panel.y([-0.06, 0.0, 1.0])
    assert 2.0 < bar < nothing < all_ < 3.0


@pytest.mark.parametrize(("low", "high"), [(20.0, 23.0), (-10.0, 46.0), (0.001, 0.0042), (-1e-6, 3e5)])
def test_ticks_are_round_levels_of_the_axis(low: float, high: float) -> None:
    ticks = Panel(estimate(), 0.0, 0.0, 1.0, 1.0, low, high).ticks
    assert 1 <= len(ticks) <= 4
    assert all(low <= tick <= high and len(f"{tick:g}") <= 7 for tick in ticks)


def test_open_interval_extends_to_axis_end() -> None:
    above = Panel(estimate(k=(0, 0, 0, 0)), 0.0, 0.0, 1.0, 1.0, 20.0, 23.0)
    assert above.estimate.fit.threshold is None
    low, high = above.interval
    assert (low, high) == (above.estimate.fit.interval_low, 23.0)


def test_curve_figure_titles_panels_up_to_maximum() -> None:
    many = [estimate(20.0 + n) for n in range(MAX_PANELS + 2)]
    svg = curve_figure(many, ["frequency_hz"], unit="dB").svg
    titles = [f">{20 + n} Hz<" in svg for n in range(MAX_PANELS + 2)]
    assert titles == [True] * MAX_PANELS + [False] * 2
    assert "Level (dB)" in svg


def test_curve_figure_draws_catch_only_and_single_level() -> None:
    (single,) = estimates([Cell("P01", ("b",), "yes_no", (5.0,), (3,), (9,), 0, 0)])
    (catch,) = estimates([Cell("P01", ("a",), "yes_no", (), (), (), 3, 1)])
    assert curve_figure([catch], ["hand"], unit="").svg.startswith("<svg")
    assert curve_figure([catch, single], ["hand"], unit="").svg.startswith("<svg")
