"""Tests of a custom kind of result in page, terminal and JSON."""

import pandas as pd
import pytest

from tactometry.analysis.figures.style import Drawing, drawing_of, new_figure
from tactometry.analysis.pipeline import analyse_trials
from tactometry.analysis.reading.trials import read_trials
from tactometry.analysis.report import page, summary as json, terminal
from tactometry.analysis.report.kinds import KINDS
from tactometry.analysis.report.section import Details, Figure, Lead, ResultKind, Section, TextTable, grid, rows_of
from tactometry.analysis.result import Analysis
from tactometry.cli.analyse import summary_text

ROWS = pd.DataFrame({"participant": ["P01"], "reaction_s": [0.25]})


@pytest.fixture(scope="module")
def found(whole) -> Analysis:
    return analyse_trials(read_trials(whole))


def figure() -> Figure:
    def drawn() -> Drawing:
        with new_figure(2, 1) as bare:
            return drawing_of(bare)

    return Figure("reactions", drawn, "Reactions.", "reactions")


@pytest.fixture
def added(monkeypatch) -> None:
    """Add a custom section as a file in `sections` and an entry in `kinds`."""
    kind = ResultKind(
        lambda _: [Section("Reactions < all", (Lead("Means."), Details("More", (grid(ROWS, ()), figure()))))],
        lambda _: [TextTable(ROWS, "reactions", ["no test of reactions"])],
        lambda _: [("reactions", [{"participant": "P01"}])],
    )
    for module in (page, terminal, json):
        monkeypatch.setattr(module, "KINDS", (*KINDS, kind))


def test_custom_section_appears_in_all_output(found, added) -> None:
    text = page.render(found)
    assert text.index("<h2>Reactions &lt; all</h2>") > text.index("<h2>Participants</h2>")
    assert "<summary>More</summary>" in text.split("Reactions &lt; all")[1]
    assert "<td>0.250</td>" in text
    assert "Reactions. Numbers: reactions.csv." in text
    assert [each.name for each in page.figures_of(found)][-1] == "reactions"
    assert "no test of reactions" in summary_text(found)
    assert list(json.summary(found))[-5:] == ["reactions", "report", "tables", "figures", "pdf"]


def test_json_lists_absent_tables_as_empty(found) -> None:
    summary = json.summary(found)
    assert summary["loss"] == summary["preference"] == []
    assert json.plain(dict(rows_of("thresholds")(found))["thresholds"]) == summary["thresholds"]


def test_element_ids_are_unique_in_page(found) -> None:
    names = [part.split('"')[0] for part in page.render(found).split(' id="')[1:]]
    assert len(names) == len(set(names)) > 10
