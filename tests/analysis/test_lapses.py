"""Tests of the comparison of lapse rates between conditions."""

import json

import pandas as pd
import pytest
from command_line import output

from tactometry.analysis.tasks.cell import Cell
from tactometry.analysis.tasks.cells import estimates
from tactometry.analysis.tasks.lapses import lapse_table, lapse_warnings

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
