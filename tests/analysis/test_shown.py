"""Tests of the notebook view of an analysis and its trials."""

import re
from dataclasses import replace

import analysis_data
import numpy as np
import pytest
from places import RECORDED

from tactometry.analysis.pipeline import analyse
from tactometry.analysis.plan import AnalysisPlan
from tactometry.analysis.reading.trials import read_trials
from tactometry.analysis.result import Analysis


@pytest.fixture(scope="module")
def found(tmp_path_factory) -> Analysis:
    truth = {(participant, (60.0,)): 20.0 for participant in ("P01", "P02")}
    path = tmp_path_factory.mktemp("study") / "trials.csv"
    analysis_data.write_study(path, truth, ("frequency_hz",), rng=np.random.default_rng(1))
    return analyse(path, plan=AnalysisPlan(hierarchical=False))


def test_analysis_repr_is_one_line_with_tables(found: Analysis) -> None:
    text = repr(found)
    assert re.match(rf"Analysis\({len(found.trials.rows)} trials of 2 participants, \d+ warnings?; ", text)
    assert all(name in text for name in found.tables)
    assert "\n" not in text


def test_notebook_view_lists_all_tables_estimates_first(found: Analysis) -> None:
    shown = re.findall(r"<summary>(\w+) \((\d+) rows?\)</summary>", found._repr_html_())
    assert {name: int(n) for name, n in shown} == {name: len(table) for name, table in found.tables.items()}
    assert shown[0][0] == "thresholds"
    assert shown[-1][0] == "quality"


def test_a_notebook_has_the_warnings_as_text(found: Analysis) -> None:
    shown = replace(found, warnings=("one < two", "three"))._repr_html_()
    assert "<li>one &lt; two</li><li>three</li>" in shown


def test_trials_repr_is_one_line() -> None:
    assert repr(read_trials(RECORDED / "yes-no")) == "Trials(41 rows of 2 participants; frequency_hz)"
