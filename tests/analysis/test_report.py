"""Tests of the analysis from trials table to report."""

import json
import re
import shutil
from pathlib import Path

import analysis_data
import numpy as np
import pandas as pd
import pytest
from command_line import output, refused
from hypothesis import given, strategies as st
from places import SHARED
from scipy.special import logit

from tactometry.analysis.anova.group_means import group_table
from tactometry.analysis.figures.style import drawing_of, new_figure
from tactometry.analysis.means import RATE, Range, mean_with_interval
from tactometry.analysis.pipeline import analyse
from tactometry.analysis.plan import AnalysisPlan
from tactometry.analysis.reading.quality import Exclusion
from tactometry.analysis.report.page import BROWSERS, WEASYPRINT, print_pdf, write_report
from tactometry.analysis.report.summary import summary
from tactometry.analysis.report.texts import primary_sentences
from tactometry.analysis.result import Analysis
from tactometry.analysis.wording import cross_table
from tactometry.cli.analyse import summary_text
from tactometry.errors import DeviceFailed, InvalidFile, InvalidParameter

FACTORS = ("force_n", "frequency_hz")
MEANS = {(force, hz): base - 0.8 * force for force in (0.5, 3.0) for hz, base in ((60, 26.0), (240, 16.0), (480, 22.0))}


@pytest.fixture(scope="module")
def study(tmp_path_factory) -> Path:
    rng = np.random.default_rng()
    truth = analysis_data.grid_of_thresholds(5, MEANS, 2.0, rng)
    return analysis_data.write_study(tmp_path_factory.mktemp("study") / "trials.csv", truth, FACTORS, rng=rng)


@pytest.fixture(scope="module")
def found(study, tmp_path_factory) -> Analysis:
    return analyse(study, report=tmp_path_factory.mktemp("reported") / "report.html")


def test_group_table_crosses_frequency_by_force(found) -> None:
    cross = found.outcomes[0].cross
    assert list(cross.columns) == ["frequency_hz", "force_n = 0.5", "force_n = 3"]
    assert cross["frequency_hz"].tolist() == [60, 240, 480]
    assert re.fullmatch(r"-?\d+\.\d \[-?\d+\.\d, -?\d+\.\d\] \(n = 5\)", cross.iloc[0, 1])


def test_anova_finds_frequency_effect(found) -> None:
    anova = found.tables["anova_threshold"].set_index("Source")
    assert anova.loc["frequency_hz", "p_unc"] < 1e-4
    assert primary_sentences(found.outcomes[0])[1].startswith("frequency_hz: F(")


def test_answers_and_catch_trials_are_counted_once(found) -> None:
    rates, table = found.tables["rates"], found.tables["thresholds"]
    assert rates["n_trials"].sum() == table["n_trials"].sum()
    assert ((rates["rate_low"] <= rates["rate"]) & (rates["rate"] <= rates["rate_high"])).all()
    assert table[["n_trials", "n_catch"]].drop_duplicates().to_numpy().tolist() == [[9 * 12, 20]]
    assert found.tables["quality"]["n_catch"].tolist() == [120] * 5


def test_report_is_self_contained(found) -> None:
    page = found.report.read_text()
    outside = re.findall(r'(?:src|href|url)\s*[=(]\s*["\']?((?!#|data:)[^"\')\s>]+)', page)
    assert [link for link in outside if not link.startswith("f")] == []
    assert not re.search(r"<(script|link|img|iframe)\b", page)
    for word in ("Warnings", "Data quality", "Methods", "scipy", "<svg"):
        assert word in page
    assert page.index("Warnings") < page.index("Detection threshold")


def test_report_tables_equal_result_tables(found) -> None:
    for name, table in found.tables.items():
        again = pd.read_csv(found.tables_folder / f"{name}.csv")
        assert len(again) == len(table)
        assert list(again.columns) == [str(column) for column in table.columns]


@pytest.mark.parametrize("task", ["yes_no", "forced_choice", "comparison"])
def test_mean_over_participants_recovers_the_truth(tmp_path, task) -> None:
    rng = np.random.default_rng()
    truth = {(f"P{i}", (0.0,)): 20.0 for i in range(8)}
    found = analyse(analysis_data.write_study(tmp_path / "t.csv", truth, ["block_type"], rng=rng, task=task, n=30))
    mean, low, high = found.outcomes[0].group[["mean", "mean_low", "mean_high"]].iloc[0]
    assert mean == pytest.approx(20.0, abs=4.0 * max(high - low, 0.4))
    if task == "comparison":
        mean, low, high = found.tables["group_jnd"].iloc[0][["mean", "mean_low", "mean_high"]]
        assert mean == pytest.approx(8.0 / 3.2897 * 0.67449, abs=4 * max(high - low, 0.1))


def censored(path, rng, truth):
    """Return the outcome and the warnings of thresholds, some of which lie above the levels."""
    file = analysis_data.write_study(path, truth, ["frequency_hz"], rng=rng, false_alarm_rate=0.0)
    found = analyse(file)
    return found.outcomes[0], found.warnings


def test_fully_censored_condition_is_left_out_of_anova(tmp_path) -> None:
    rng = np.random.default_rng()
    means = {(60.0,): 75.0, (240.0,): 16.0, (480.0,): 22.0}
    outcome, warnings = censored(tmp_path / "t.csv", rng, analysis_data.grid_of_thresholds(4, means, 1.0, rng))
    first = outcome.group.iloc[0]
    assert (first["n"], first["n_above"], first["text"]) == (0, 4, "of 4: 4 above the levels")
    assert first[["mean", "mean_low", "mean_high"]].isna().all()
    assert outcome.notes == (
        "the analysis with censored values leaves out frequency_hz = 60: in some of its conditions, fewer than 2 "
        "participants have a value",
        "the analysis of variance, a check, leaves out frequency_hz = 60, as it needs a value in every condition",
    )
    assert (outcome.primary, outcome.censored.design.n_censored) == ("censored_anova", 0)
    assert outcome.left_out == ("frequency_hz = 60",)
    assert any("4 of 12 cells with a threshold above the levels" in warning for warning in warnings)


def test_participants_with_bounds_stay_in_primary_analysis(tmp_path) -> None:
    rng = np.random.default_rng()
    truth = analysis_data.grid_of_thresholds(6, {(240.0,): 16.0, (480.0,): 30.0}, 1.0, rng)
    truth |= {("P01", (480.0,)): 70.0, ("P02", (480.0,)): 70.0}
    outcome, _ = censored(tmp_path / "t.csv", rng, truth)
    assert (outcome.primary, outcome.censored.design.n_censored) == ("censored_anova", 2)
    assert outcome.censored.table.attrs["n"] == 6
    assert outcome.notes == (
        "the analysis with censored values treats 2 values as bounds",
        "the analysis of variance, a check, leaves out participant P01, participant P02, as it needs a value in every "
        "condition",
    )
    known = outcome.estimates.dropna(subset="threshold").groupby("frequency_hz")["threshold"].mean()
    rows = outcome.group.set_index("frequency_hz")
    assert rows.loc[480, "mean"] > known[480] + 1.0
    assert rows["method"].to_dict() == {240: "t", 480: "censored model"}
    assert outcome.pairs["frequency_hz"]["difference"][0] > known[480] - known[240] + 1.0


ONE, THREE = (1.0, "ok", 0, 2), (3.0, "ok", 2, 4)
ABOVE, BELOW = (None, "threshold_above_range", 5.0, None), (None, "threshold_below_range", None, -3.0)
FLAT = (None, "flat", None, None)


@pytest.mark.parametrize(
    ("rows", "text"),
    [
        ([ONE, THREE], "2.0 [-10.7, 14.7] (n = 2)"),
        ([ONE], "1.00 (n = 1)"),
        ([(1.25e-300, "ok", 0, 2)], "1.25e-300 (n = 1)"),
        ([ONE, THREE, FLAT], "2.0 [-10.7, 14.7] (n = 2, 1 missing)"),
        ([ONE, ABOVE], "of 2: 1 above the levels"),
        ([ONE, BELOW], "of 2: 1 below the levels"),
        ([ABOVE, BELOW], "of 2: 1 below, 1 above the levels"),
        ([FLAT], "none (1 missing)"),
    ],
)
def test_group_mean_excludes_cells_without_threshold(rows, text) -> None:
    table = pd.DataFrame(rows, columns=["threshold", "status", "interval_low", "interval_high"])
    group = group_table(table.assign(condition="x"), ["condition"])
    assert cross_table(group, ["condition"])["mean"].tolist() == [text]


# Real data: Dallmann, Ernst and Moscatelli 2015, tactile speed with masking vibration
@pytest.fixture(scope="module")
def dallmann() -> Analysis:
    path = SHARED / "data" / "dallmann2015_trials.csv"
    if not path.exists():
        pytest.skip("the shared folder with the trials of Dallmann 2015 is absent")
    return analyse(path)


def test_masking_vibration_raises_the_difference_threshold(dallmann) -> None:
    anova = dallmann.tables["anova_jnd"].set_index("Source")
    mean = dallmann.tables["group_jnd"].set_index("vibration_hz")["mean"]
    assert anova.loc["vibration_hz", "p_unc"] < 0.01
    assert mean[32] > mean[0]
    assert dallmann.tables["anova_pse"].set_index("Source").loc["vibration_hz", "p_unc"] > 0.05


def test_terminal_shows_table_and_sentence(found) -> None:
    text = summary_text(found)
    assert "Frequency (Hz)" in text
    assert "frequency_hz" not in text
    assert "force × frequency: F(" in text
    assert "generalised eta squared" in " ".join(text.split())


def test_command_rejects_bad_table_with_one_sentence(tmp_path, capsys) -> None:
    bad = tmp_path / "bad.csv"
    bad.write_text("participant,level\nP01,1\n")
    message = f"tactometry: {bad}: found no column 'task'; assign it in a column map (--columns)"
    assert refused(capsys, "analyse", bad) == message


def test_report_requires_writable_html_path(study, found, tmp_path) -> None:
    with pytest.raises(InvalidParameter, match=r"--report: found 'r.txt', expected a file name that ends in .html"):
        analyse(study, report=tmp_path / "r.txt")
    with pytest.raises(InvalidParameter, match="--pdf: found no --report, expected --report FILE.html"):
        analyse(study, pdf=True)
    (tmp_path / "file").write_text("")
    with pytest.raises(DeviceFailed, match="cannot be written"):
        write_report(found, tmp_path / "file" / "r.html")


def test_refuses_levels_in_two_units(tmp_path) -> None:
    path, header = tmp_path / "t.csv", "participant,trial,procedure,level,level_unit,task,response"
    path.write_text(f"{header}\nP1,1,c,1,V,yes_no,1\nP1,2,c,1,dB,yes_no,0\n")
    with pytest.raises(InvalidFile, match="row 3, column 'level_unit': found 'dB', expected 'V' as in earlier rows"):
        analyse(path)


@pytest.fixture(scope="module")
def pressed(study, tmp_path_factory) -> Path:
    """Write the study with a force 10 % above the target; that of P02 is out of the band."""
    rng = np.random.default_rng()
    table = pd.read_csv(study, dtype=str, keep_default_na=False)
    force = table["force_n"].astype(float) * (1.1 + 0.02 * rng.normal(size=len(table)))
    band = np.where(table["participant"] == "P02", 0.3, 0.95)
    path = tmp_path_factory.mktemp("pressed") / "trials.csv"
    table.assign(force_mean_n=force.round(4), force_in_band=band).to_csv(path, index=False)
    return path


@pytest.fixture(scope="module")
def planned(pressed, tmp_path_factory) -> Analysis:
    plan = AnalysisPlan(Exclusion(force_in_band_share_min=0.5), {"force_n": 50.0})
    return analyse(pressed, plan=plan, report=tmp_path_factory.mktemp("planned") / "report.html")


def test_plan_exclusions_are_first_warning(planned) -> None:
    assert set(planned.tables["thresholds"]["participant"]) == {"P01", "P03", "P04", "P05"}
    rule = "force_in_band_share_min = 0.5"
    assert planned.warnings[0].startswith(f"excluded by the rule {rule} (numbers of trials): P02 ")
    assert set(planned.tables["excluded"]["participant"]) == {"P02"}
    assert f"rules specified in advance ({rule})" in planned.methods
    assert "Bayes factors (Rouder et al. 2009)" in planned.methods
    assert "pingouin" in planned.methods


def test_report_has_force_models_pairs_and_references(planned) -> None:
    page = planned.report.read_text()
    headings = ("Applied force", "Data quality", "Excluded by the analysis plan", "Pairs of frequency")
    references = ("Schuirmann, D. J. (1987)", "Rouder, J. N.")
    for text in (*headings, "Equivalence over force", "Linear mixed model", *references):
        assert text in page
    outcome = planned.outcomes[0]
    assert outcome.model_title == "frequency_hz * log2 of the measured force, random intercept of participants"
    assert outcome.equivalence["force_n"]["equivalent"].all()
    assert len(outcome.pairs["frequency_hz"]) == 3
    assert planned.tables["force"]["mean"].iloc[0] == pytest.approx(0.55, abs=0.01)


@pytest.fixture(scope="module")
def shown(pressed, tmp_path_factory) -> tuple[Analysis, int]:
    """With its page and its figures, and how often one was drawn for them."""
    from matplotlib.figure import Figure

    folder, drawn, draw = tmp_path_factory.mktemp("shown"), [], Figure.draw
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Figure, "draw", lambda figure, renderer: drawn.append(figure) or draw(figure, renderer))
        found = analyse(pressed, report=folder / "r.html", figures=folder / "figures")
    return found, len(drawn)


def test_every_figure_is_a_file_with_its_numbers(shown) -> None:
    from PIL import Image

    found, _ = shown
    names = {path.stem for path in found.figures_folder.iterdir()}
    assert {"threshold", "force", "rates_yes_no", "mean_rates_yes_no", "P01_curves"} <= names
    for name in names:
        assert (found.figures_folder / f"{name}.svg").read_text().startswith("<svg")
        assert len(pd.read_csv(found.figures_folder / f"{name}.csv")) > 0
    with Image.open(found.figures_folder / "threshold.png") as picture:
        assert picture.info["dpi"][0] == pytest.approx(300, abs=1)
    one = set(pd.read_csv(found.figures_folder / "P01_curves.csv")["participant"])
    assert one == {"P01"}


def test_figures_are_drawn_once_per_format(shown) -> None:
    found, n_drawn = shown
    assert n_drawn == 2 * len(list(found.figures_folder.glob("*.png"))) > 0


def test_png_keeps_axes_positions_of_svg():
    with new_figure(3.0, 2.0) as figure:
        for axes in figure.subplots(1, 2):
            axes.set(ylabel="Level (dB)", title="a")
        drawing = drawing_of(figure)
    places = [axes.get_position().bounds for axes in figure.axes]
    drawing.png()
    assert [axes.get_position().bounds for axes in figure.axes] == places


@pytest.mark.skipif(
    not any(map(shutil.which, (*BROWSERS, WEASYPRINT))), reason="neither a browser nor WeasyPrint is installed"
)
def test_page_is_printed_by_available_printer(tmp_path) -> None:
    page = tmp_path / "r.html"
    page.write_text("<details><summary>closed</summary><p>inside</p></details>")
    assert print_pdf(page).read_bytes().startswith(b"%PDF")


def test_written_pdf_is_named(found, tmp_path, monkeypatch) -> None:
    monkeypatch.setattr("tactometry.analysis.report.page.print_pdf", lambda path: path.with_suffix(".pdf"))
    printed = write_report(found, tmp_path / "r.html", pdf=True)
    assert f"PDF: {tmp_path / 'r.pdf'}" in summary_text(printed).splitlines()
    assert summary(printed)["pdf"] == str(tmp_path / "r.pdf")
    assert summary(found)["pdf"] is None


def test_missing_printer_is_reported(tmp_path, monkeypatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(DeviceFailed, match="--pdf: found neither a browser .* nor weasyprint, expected one of them;"):
        print_pdf(tmp_path / "r.html")


RANGES = [Range(0.0, 1.0), Range(-3.0, 3.0), Range(0.0), Range(high=1.0)]


@pytest.mark.parametrize("possible", RANGES)
@given(place=st.floats(0.01, 0.99), half=st.floats(0, 20))
def test_interval_stays_in_range_around_mean(possible, place, half):
    low, high = max(possible.low, -50.0), min(possible.high, 50.0)
    mean = low + place * (high - low)
    found = possible.around(mean, half)
    assert possible.low <= found[0] <= mean + 1e-9
    assert mean - 1e-9 <= found[1] <= possible.high


def test_rate_interval_is_symmetric_on_logit():
    found = mean_with_interval(np.array([0.5, 0.8, 0.9, 0.6]), possible=RATE)
    low, mean, high = (logit(found[name]) for name in ("mean_low", "mean", "mean_high"))
    assert high - mean == pytest.approx(mean - low)


@pytest.mark.parametrize("dependent", ["rate_correct", "jnd"])
@pytest.mark.parametrize(("n", "has_interval"), [(2, False), (3, True)])
def test_bounded_mean_needs_three_participants(dependent, n, has_interval):
    values = {"participant": list("abc")[:n], dependent: [0.2, 0.9, 0.95][:n]}
    assert group_table(pd.DataFrame(values), [], dependent)["mean_low"].notna().tolist() == [has_interval]


@pytest.mark.parametrize(
    ("study", "key", "bounds"),
    [("time-reversal-localisation", "outcomes", (0, 1)), ("hybrid-button", "questionnaires", (0, 100))],
)
def test_analyse_reports_possible_intervals(tmp_path, capsys, study, key, bounds):
    output(capsys, "simulate", study, "--participants", "3", "--seed", "2", "--out", tmp_path / "data")
    found = json.loads(output(capsys, "analyse", tmp_path / "data", "--json"))[key]
    ends = [row[end] for row in rows_of(found) for end in ("mean_low", "mean_high") if row[end] is not None]
    assert ends
    assert all(bounds[0] <= end <= bounds[1] for end in ends)


def rows_of(found):
    """Every row of a table of means, at any depth."""
    if isinstance(found, dict):
        return [found] if "mean_low" in found else [row for value in found.values() for row in rows_of(value)]
    return [row for value in found for row in rows_of(value)] if isinstance(found, list) else []
