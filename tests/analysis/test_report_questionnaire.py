"""Tests of the report of a study with only a questionnaire."""

import re
from pathlib import Path

import attrakdiff_answers
import numpy as np
import pytest
from command_line import output

from tactometry.analysis.pipeline import analyse
from tactometry.analysis.report.page import figures_of
from tactometry.analysis.report.summary import summary
from tactometry.analysis.result import Analysis
from tactometry.cli.analyse import summary_text


@pytest.fixture(scope="module")
def patterns(tmp_path_factory) -> Path:
    """Write AttrakDiff answers of six participants, who rate the high frequency better."""
    table = attrakdiff_answers.study(np.random.default_rng(), n=6, effect={"P4": 1.5, "P5": 1.5, "P6": 1.5})
    return attrakdiff_answers.write(tmp_path_factory.mktemp("patterns") / "answers.csv", table)


@pytest.fixture(scope="module")
def rated(patterns, tmp_path_factory) -> Analysis:
    return analyse(patterns, report=tmp_path_factory.mktemp("rated") / "r.html")


def test_a_study_of_a_questionnaire_alone_is_reported(rated) -> None:
    found, page = rated, rated.report.read_text()
    for text in ("AttrakDiff", "Portfolio", "Word pairs", "Patterns against P0", "Cronbach&#39;s alpha"):
        assert text in page
    assert (found.outcomes, found.warnings) == ((), ())
    (form,) = found.forms
    assert form.crossed.set_index(["dimension", "Source"]).loc[("HQ", "frequency"), "p_unc"] < 0.05
    assert list(form.cross().columns) == ["condition", "PQ", "HQI", "HQS", "ATT", "HQ"]
    assert {"attrakdiff_scores", "attrakdiff_portfolio", "attrakdiff_against_P0"} <= set(found.tables)
    assert summary(found)["questionnaires"]["attrakdiff"][0]["condition"] == "P0"


def test_word_pairs_are_grouped_by_frequency_and_envelope(rated) -> None:
    """Figures 5.9 to 5.13 of the thesis."""
    (form,) = rated.forms
    names = {figure.name.removeprefix("attrakdiff_") for figure in figures_of(rated)}
    by = {"word_pairs_by_frequency", "word_pairs_by_envelope", "word_pairs_low_frequency", "word_pairs_high_frequency"}
    assert names == by | {"scores", "portfolio", "frequency_by_envelope"}
    means = form.grouped.set_index(["of", "condition", "item"])["mean"]
    own = form.profile.set_index(["condition", "item"])["mean"]
    item = form.profile["item"].iloc[0]
    assert means["frequency", "high", item] == pytest.approx(np.mean([own[code, item] for code in ("P4", "P5", "P6")]))
    assert means["envelope", "sinc", item] == pytest.approx(np.mean([own[code, item] for code in ("P3", "P6")]))
    assert means["envelope", "P0", item] == own["P0", item]


@pytest.mark.parametrize("width", [80, 60])
def test_terminal_table_keeps_each_value_on_one_line(patterns, capsys, monkeypatch, width) -> None:
    monkeypatch.setenv("COLUMNS", str(width))
    lines = output(capsys, "analyse", patterns).splitlines()
    assert max(map(len, lines)) <= width
    rows = [line.split() for line in lines if line.startswith("│")]
    assert rows[0][1:4] == ["P0", "│", "PQ"]
    assert all(re.search(r"\[\S+, \S+\] \(n = 6\) │$", " ".join(row)) for row in rows)


def test_terminal_names_csv_when_table_is_too_wide(patterns, capsys, monkeypatch) -> None:
    monkeypatch.setenv("COLUMNS", "40")
    text = " ".join(output(capsys, "analyse", patterns).split())
    assert "n): too wide for 40 columns; see the tables of --report FILE.html (CSV)" in text


def test_the_terminal_shows_scores_and_comparisons(rated) -> None:
    text = summary_text(rated)
    assert "AttrakDiff (mean, 95 % interval between participants, n)" in text
    assert "frequency: F(1, 5)" in " ".join(text.split())
