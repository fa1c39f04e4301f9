"""Tests of the hierarchical fit as part of an analysis."""

import re
from dataclasses import replace
from pathlib import Path

import analysis_data
import numpy as np
import pandas as pd
import pytest

from tactometry.analysis.hierarchical import tables
from tactometry.analysis.outcomes import hierarchical_outcome as module
from tactometry.analysis.outcomes.hierarchical_outcome import _text, group_fit
from tactometry.analysis.pipeline import analyse
from tactometry.analysis.plan import AnalysisPlan
from tactometry.analysis.report.summary import summary
from tactometry.analysis.report.texts import hierarchical_sentences
from tactometry.analysis.tasks.cell import Cell
from tactometry.analysis.tasks.cells import estimates

CONDITIONS = {(0.5,): 20.0, (3.0,): 16.0}


@pytest.fixture(scope="module")
def study(tmp_path_factory) -> tuple[Path, dict]:
    rng = np.random.default_rng()
    truth = analysis_data.grid_of_thresholds(5, CONDITIONS, 2.0, rng)
    path = tmp_path_factory.mktemp("together") / "trials.csv"
    return analysis_data.write_study(path, truth, ["force_n"], rng=rng), truth


@pytest.fixture(scope="module")
def found(study, tmp_path_factory):
    return analyse(study[0], report=tmp_path_factory.mktemp("report") / "r.html")


def test_hierarchical_thresholds_are_shrunken_and_near_truth(study, found) -> None:
    (fit,) = found.hierarchical
    errors = [
        row.threshold - study[1][row.participant, (row.force_n,)] for row in fit.participants.itertuples(index=False)
    ]
    reach = fit.participants["standard_error"].max()
    assert len(errors) == 10
    assert np.abs(errors).max() < 5 * reach
    assert fit.participants["threshold"].std() < 1.1 * found.tables["thresholds"]["threshold"].std()


def test_summary_reports_group_effects_variances_and_rates(found) -> None:
    (fit,) = summary(found)["hierarchical"]
    assert re.match(r"force_n: Wald's F\(1, 4\) = ", fit["sentences"][0])
    assert fit["sentences"][1].startswith("standard deviations between 5 participants: thresholds ")
    assert "mean lapse rate 0.0" in fit["sentences"][2]
    assert [row["force_n"] for row in fit["conditions"]] == [0.5, 3.0]
    assert len(fit["participants"]) == 10


def test_report_has_hierarchical_section_tables_and_methods(found) -> None:
    page = found.report.read_text()
    heading = "<h2>Hierarchical model of all participants</h2>"
    for text in (heading, "force: Wald&#39;s ", "Moscatelli, A., Mezzetti", "Participants (10"):
        assert text in page
    assert "hierarchical psychometric model" in found.methods
    for name in ("hierarchical_yes_no", "hierarchical_yes_no_participants"):
        assert (found.tables_folder / f"{name}.csv").exists()


def test_plan_can_disable_hierarchical_fit(study) -> None:
    without = analyse(study[0], plan=AnalysisPlan(hierarchical=False))
    assert without.hierarchical == ()
    assert "hierarchical psychometric model" not in without.methods


def cell(who: str, condition: tuple = (), k=(0, 3, 7, 10), **options) -> Cell:
    made = Cell(who, condition, "yes_no", (1.0, 2.0, 3.0, 4.0), k, (10,) * 4, 10, 1)
    return replace(made, **options)


def test_single_participant_has_no_hierarchical_fit() -> None:
    assert group_fit([cell("A")], [], "") is None


def test_a_study_without_factors_has_one_condition() -> None:
    fit = group_fit([cell("A"), cell("B", k=(1, 4, 8, 10)), cell("C", k=(0, 2, 7, 9))], [], "dB")
    assert fit.conditions["condition"].tolist() == ["all"]
    assert fit.effects == {}


@pytest.mark.parametrize("unit", ["dB", "V"])
def test_cells_that_were_fitted_are_not_fitted_again(monkeypatch, unit) -> None:
    answers, factors = {"A": (0, 3, 7, 10), "B": (1, 4, 8, 10), "C": (0, 2, 7, 9)}, ("force_n", "hand")
    every = [
        cell(who, (force_n, "left"), k=k, levels=tuple(force_n * x for x in range(1, 5)))
        for force_n in (1.0, 2.0)
        for who, k in answers.items()
    ]
    anew = group_fit(every, factors, unit)
    known = {estimate.cell: estimate.fit for estimate in estimates(every, unit)}
    sizes, fit_many = [], tables.fit_many
    noted = lambda *counts, **options: sizes.append(len(counts[0])) or fit_many(*counts, **options)  # noqa: E731
    monkeypatch.setattr(tables, "fit_many", noted)
    again = group_fit(every, factors, unit, known)
    assert sizes == [2]  # the answers of each condition together
    pd.testing.assert_frame_equal(again.conditions, anew.conditions, rtol=1e-6)
    pd.testing.assert_frame_equal(again.participants, anew.participants, rtol=1e-6)


def test_false_alarms_raise_guess_rate() -> None:
    rates = [
        group_fit([cell(who, n_catch=40, n_false_alarms=n) for who in ("P1", "P2", "P3")], (), "").fit.guess_rate
        for n in (0, 16)
    ]
    assert rates[1] > rates[0] + 0.1


def test_thresholds_out_of_range_are_printed_as_bounds() -> None:
    ends = [{"interval_low": 2.0, "interval_high": None}, {"interval_low": None, "interval_high": 2.0}]
    assert [_text(pd.Series({"threshold": None} | end)) for end in ends] == ["> 2.00", "< 2.00"]


def test_a_factor_between_participants_is_not_tested() -> None:
    answers = {"A": (0, 3, 7, 10), "B": (1, 4, 8, 10), "C": (0, 3, 7, 10), "D": (1, 4, 9, 10)}
    found = group_fit([cell(who, ("xxyy"["ABCD".index(who)],), k=k) for who, k in answers.items()], ["hand"], "")
    assert found.effects == {}
    assert "no test of effects: hand does not vary within participants" in hierarchical_sentences(found, "")[-1]


def test_forced_choices_guess_at_their_chance() -> None:
    choices = [replace(cell(who, task="forced_choice", k=(3, 5, 8, 10)), n_choices=4) for who in "ABC"]
    assert group_fit(choices, [], "").fit.guess_rate == 0.25


@pytest.mark.parametrize(
    ("answers", "note"),
    [
        ([cell(who, k=(0, 0, 0, 0)) for who in "ABC"], "no hierarchical fit: no participant has a threshold"),
        ([cell(who, levels=(), k=(), n_trials=()) for who in "AB"], "no hierarchical fit: no trial has a level"),
    ],
)
def test_missing_hierarchical_fit_has_reason(answers, note) -> None:
    found = group_fit(answers, [], "")
    assert found.fit is None
    assert hierarchical_sentences(found, "")[0].startswith(note)
    assert found.tables("yes_no") == {}


def test_very_many_cells_are_left_to_the_function(monkeypatch) -> None:
    monkeypatch.setattr(module, "MOST_CELLS", 2)
    note = group_fit([cell(who) for who in "ABC"], [], "").note
    assert note.startswith("no hierarchical fit: 3 cells, a report fits at most 2")
    assert group_fit([cell(who) for who in "AB"], [], "").fit is not None


def test_comparison_model_is_described_without_effect_test() -> None:
    answers = {"A": (1, 3, 7, 9), "B": (1, 4, 8, 10), "C": (0, 2, 7, 9)}
    each = [cell(who, task="comparison", k=k, condition=(x,)) for who, k in answers.items() for x in (1.0, 2.0)]
    found = group_fit(each, ["force_n"], "")
    assert found.effects == {}
    *sentences, last = hierarchical_sentences(found, "")
    assert any("standard deviations between" in sentence for sentence in sentences)
    assert not any("lapse rate" in sentence or "guess rate" in sentence for sentence in sentences)
    assert last.startswith("no test of effects: this model of comparisons has asymptotes of 0 and 1")


def test_failed_hierarchical_search_has_reason() -> None:
    """Regression test: a singular matrix of the search was a traceback."""
    options = {"levels": (18.0, 26.0), "n_trials": (40, 40), "n_catch": 0, "n_false_alarms": 0}
    answers = enumerate(((2, 38), (17, 37), (5, 18), (11, 22)))
    found = group_fit([cell(f"P{n}", k=k, **options) for n, k in answers], (), "dB")
    assert found.fit is not None or found.note.startswith("no hierarchical fit: the integral")
