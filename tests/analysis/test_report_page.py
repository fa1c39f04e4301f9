"""Tests of the text of report page, figures and terminal."""

import re
import shutil
from dataclasses import replace
from importlib import metadata
from pathlib import Path

import analysis_data
import numpy as np
import pandas as pd
import pytest
from command_line import output
from places import RECORDED
from tables import contents

from tactometry.analysis.figures.curves import courses_figure
from tactometry.analysis.figures.psychophysics import threshold_figure
from tactometry.analysis.figures.style import COLOURS, look, shift
from tactometry.analysis.outcomes.findings import Outcome
from tactometry.analysis.pipeline import analyse, analyse_trials
from tactometry.analysis.plan import AnalysisPlan, read_plan
from tactometry.analysis.reading.column_map import read_column_map
from tactometry.analysis.reading.trials import read_trials
from tactometry.analysis.report.page import figures_of, nonbreaking, render
from tactometry.analysis.report.sections.outcomes import as_amplitudes
from tactometry.analysis.report.study_text import STIMULI, procedure_text, study_text
from tactometry.analysis.report.texts import means_text
from tactometry.analysis.result import Analysis
from tactometry.cli.analyse import summary_text
from tactometry.config.toml import read_table
from tactometry.errors import InvalidFile
from tactometry.experiments.study.cells import STIMULI as KINDS_OF_STIMULI
from tactometry.experiments.study.study_file import FOLDER
from tactometry.stimuli.scenes.file import load_scene
from tactometry.stimuli.time_reversal.plate.glass import read_plate

STUDIES = sorted(path.stem for path in FOLDER.glob("*.toml"))


def analysis_of(path: Path) -> Analysis:
    return analyse_trials(read_trials(path))


@pytest.fixture(scope="module")
def one(whole) -> Analysis:
    """One participant of the tutorial."""
    return analysis_of(whole)


@pytest.fixture(scope="module")
def two(whole, tmp_path_factory) -> Analysis:
    """Add a participant with the same answers at levels that are 3 dB higher."""
    root = Path(shutil.copytree(whole, tmp_path_factory.mktemp("two") / "d"))
    file = next((root / "data").glob("*.csv"))
    table = pd.read_csv(file, dtype=str, keep_default_na=False)
    for name in ("level", "level_delivered"):
        table[name] = [f"{float(level) + 3:g}" if level else "" for level in table[name]]
    table.assign(participant="P99").to_csv(root / "data" / file.name.replace("P01", "P99"), index=False)
    return analysis_of(root)


def captions(found: Analysis) -> dict[str, str]:
    return {figure.name: figure.caption for figure in figures_of(found)}


def test_single_participant_has_no_between_participants_interval(one) -> None:
    page, figures = render(one), captions(one)
    assert "between" not in figures["threshold"] + figures["force"]
    assert "interval" not in figures["force"]
    assert "1 participant," in page
    assert "in 1 file;" in page
    for absent in ("t-intervals", "Cousineau", "The primary analysis", "hierarchical"):
        assert absent not in one.methods
    assert "t-intervals between participants" not in page


def test_single_participant_has_intervals_of_fits(one) -> None:
    [outcome] = one.outcomes
    known = outcome.estimates["threshold"].notna()
    assert known.any()
    for end, own in (("mean_low", "interval_low"), ("mean_high", "interval_high")):
        of_fit = outcome.group.loc[known.to_numpy(), end].to_numpy(float)
        np.testing.assert_array_equal(of_fit, outcome.estimates.loc[known, own])
    assert captions(one)["threshold"] == (
        "Detection threshold: values of one participant; bars are 95 % intervals of the fits."
    )
    assert "Values of one participant, each with the 95 % interval of the fit." in render(one)
    assert "(value, 95 % interval of the fit, n)" in summary_text(one)


def test_two_participants_have_between_participants_intervals(two) -> None:
    assert "t-intervals between participants; faint dots are participants" in captions(two)["threshold"]
    assert "Mean over participants with 95 % interval between participants." in render(two)


def test_force_axis_includes_zero_target_and_values(two, one) -> None:
    for found in (one, two):
        (figure,) = (figure for figure in figures_of(found) if figure.name == "force")
        (axes,) = figure.draw().figure.axes
        low, high = axes.get_ylim()
        values = np.concatenate([np.asarray(line.get_ydata(), float) for line in axes.lines])
        assert low == 0.0
        assert high > values.max()
        assert [1.0, 1.0] in [list(line.get_ydata()) for line in axes.lines if line.get_linestyle() == "--"]
        assert figure.caption.endswith("dashed: the target.")


def test_report_has_title_and_procedure_of_study(one) -> None:
    page = render(one)
    assert "<h1>Tutorial: is there a vibration under the finger? (simulated)</h1>" in page
    assert "Study tutorial: 1 participant" in page
    order = ("<h3>Procedure", "no person took part.", "were perceived through", "were frequency (60, 240 Hz).")
    places = [page.index(words) for words in order]
    assert places == sorted(places)
    assert "share of catch trials 20 %" in page


@pytest.mark.parametrize("name", STUDIES)
def test_procedure_text_includes_all_settings_of_study(name) -> None:
    study = read_table(FOLDER / f"{name}.toml", "a study")
    text = procedure_text(study, "dB re 1 V")
    for table in ("stimulus", "touch", "task", "procedure", "practice"):
        for key, value in study.get(table, {}).items():
            if key != "kind" and isinstance(value, str | int | float) and not isinstance(value, bool):
                share = f"{100 * value:.0f} %" if isinstance(value, float) and value < 1 else ""
                setting = value if isinstance(value, str) else f"{value:g}"
                assert setting in text or share in text, (table, key)
    for levels in study["factors"].values():
        assert all((f"{x:g}" if not isinstance(x, str) else x.replace("_", " ")) in text for x in levels)
    assert not re.search(r"\w_\w|  |\(\)|nan|None", text)


@pytest.mark.parametrize(
    ("after", "when"), [("start", "before the first block"), ("block", "after each block"), ("session", "at the end")]
)
def test_procedure_text_says_when_questionnaire_is_given(after, when) -> None:
    text = procedure_text({"inquiries": {"who": {"form": "demographics", "after": after}}}, "")
    assert f"The questionnaire demographics was presented {when}" in text


def test_every_stimulus_kind_has_a_description() -> None:
    assert set(STIMULI) == set(KINDS_OF_STIMULI)


def test_a_table_without_a_study_has_no_procedure(tmp_path) -> None:
    assert study_text(tmp_path / "trials.csv", "") == study_text(tmp_path, "")
    (tmp_path / "study.toml").write_text('title = "T"\nfactors = 3\ntouch = "x"\nvariants = {a = 2}\n')
    assert study_text(tmp_path, "").title == "T"


def test_decibel_thresholds_are_also_in_volt_peak(two) -> None:
    page = render(two)
    assert "The same table in V peak, 10^(level / 20); means are geometric." in page
    known = two.outcomes[0].group.dropna(subset="mean")
    row, text = known.iloc[0], as_amplitudes(known)["text"].iloc[0]
    assert float(text.split(" ")[0]) == pytest.approx(10 ** (row["mean"] / 20), rel=0.01)
    assert f"<td>{text.split(' ')[0]}" in page


def test_a_difference_in_decibels_has_no_reference() -> None:
    empty = pd.DataFrame()
    jnd, pse = (Outcome("comparison", name, empty, empty, empty) for name in ("jnd", "pse"))
    assert (jnd.unit("dB re 1 V"), pse.unit("dB re 1 V"), jnd.unit("cm/s")) == ("dB", "dB re 1 V", "cm/s")


def test_factors_have_readable_names_in_output(two) -> None:
    body = re.sub(r"<svg.*?</svg>", "", render(two).split("<body>")[1], flags=re.S)
    assert "frequency_hz" not in body
    assert "<th>Frequency (Hz)</th>" in body
    assert "n_rows" not in body
    assert "frequency_hz" not in summary_text(two)


def test_tables_are_not_cut(two) -> None:
    page = render(two)
    assert "nowrap" not in page
    assert re.search(r"<td>[\d.]+ \[\S+,\u00a0\S+\] \(n\u00a0=\u00a02\)</td>", page)


def test_headings_stay_with_their_content_in_print(two) -> None:
    page = render(two)
    assert re.search(r"h1, h2, h3, summary, \.lead \{ break-after: avoid; \}", page)
    for head in re.findall(r"<h2>[^<]*</h2>\n<p([^>]*)>", page):
        assert head in (' class="lead"', "")
    heading = two.outcomes[0].heading() if two.outcomes[0].primary else "Primary analysis"
    assert page.count(f"{heading}</") <= 1


def test_tracks_are_named_by_procedure() -> None:
    found = analysis_of(RECORDED / "quest-plus-tracks")
    figures = captions(found)
    of_tracks = [caption for name, caption in figures.items() if name.endswith("_tracks")]
    assert of_tracks
    assert all("tracks (QUEST+); filled markers: " in caption for caption in of_tracks)
    assert "staircase" not in " ".join(figures.values())
    assert not any(name.startswith("mean_rates") for name in figures)
    page = render(found)
    assert "<td>0.5</td>" in page  # factor values as they are stated
    assert "<td>0.500</td>" not in page


def test_dots_do_not_overlap_bars() -> None:
    names = ["P0", "P1", "P2"]
    means = pd.DataFrame({"pattern": names, "mean": [1.0, 2.0, 3.0]}).assign(mean_low=0.5, mean_high=3.5)
    own = pd.DataFrame({"pattern": names * 2, "x": range(6)})
    (axes,) = threshold_figure(means, own, ["pattern"], "x", "x").figure.axes
    dots = next(line for line in axes.lines if line.get_marker() == ".")
    width = axes.get_window_extent().width / np.ptp(axes.get_xlim())
    assert np.min(np.abs(np.subtract.outer(np.asarray(dots.get_xdata(), float), range(3)))) * width > 4.0


@pytest.mark.parametrize("level", [60.0, "P0"])
def test_single_condition_is_centred_with_dots_adjacent(level) -> None:
    means = pd.DataFrame({"x_hz": [level], "mean": [1.0], "mean_low": [0.5], "mean_high": [3.5]})
    (axes,) = threshold_figure(means, pd.DataFrame({"x_hz": level, "x": range(3)}), ["x_hz"], "x", "x").figure.axes
    (place,), (low, high) = axes.get_xticks(), axes.get_xlim()
    assert (place - low) / (high - low) == pytest.approx(0.5)
    dots = next(line for line in axes.lines if line.get_marker() == ".")
    assert 0.0 < (np.asarray(dots.get_xdata(), float)[0] - place) / (high - low) < 0.2


@pytest.mark.parametrize("n", [1, 3, 10])
@pytest.mark.parametrize("log", [False, True])
def test_series_of_neighbours_do_not_meet(n, log) -> None:
    where = {1: 30.0, 2: 60.0, 3: 80.0}
    last, first = (shift(place, n, where, log=log) for place in (n - 0.6, 0))
    assert last[1] < first[2] < last[2] < first[3]


def test_fourteen_series_look_different() -> None:
    assert len({str(look(n)) for n in range(2 * len(COLOURS))}) == 14


def test_scores_of_a_load_are_not_called_good() -> None:
    found = analysis_of(RECORDED / "hybrid-button")
    figures = [figure for figure in figures_of(found) if figure.name.endswith("_scores")]
    assert {figure.draw().figure.axes[0].get_ylabel() for figure in figures} == {"Score"}
    assert captions(found)["realism_likert_word_pairs"].startswith("Items: ")
    assert "symmetric on the logit of their range" in found.methods
    for absent in ("Cousineau", "The primary analysis"):  # two participants have none
        assert absent not in found.methods


def test_captions_describe_means_and_intervals() -> None:
    means = pd.DataFrame({"mean": [1.0], "mean_low": [0.5], "within_low": [0.7], "n": [3]})
    text = means_text("figure", means, "dots")
    assert text.startswith("means over participants; bars are 95 % intervals within participants")
    alike = pd.DataFrame({"mean": [1.0], "mean_low": [np.nan], "n": [3]})
    assert means_text("sentence", alike) == "Mean over participants; there is no interval between participants."
    modelled = means.assign(method=["censored model"])
    assert means_text("sentence", modelled).endswith(" (from the censored model if values are censored).")


@pytest.mark.parametrize(
    ("cell", "parts"),
    [
        ("0.29 [-0.78, 1.35] (n = 3)", 3),
        ("0.0988 ± 0.0074 N, 100 % in band", 3),
        ("the residuals bend with the level (n = 3)", 7),
        ("9.6 % [8.5, 10.7]", 3),
    ],
)
def test_cell_breaks_between_its_parts(cell, parts) -> None:
    assert len(nonbreaking(cell).split(" ")) == parts


def test_bounds_alone_have_no_means() -> None:
    trials = read_trials(RECORDED / "forced-choice")
    always = trials.rows["correct"].mask(trials.rows["frequency_hz"] == 240, 1)
    found = analyse_trials(replace(trials, rows=trials.rows.assign(correct=always)))
    assert found.outcomes[0].group["mean"].isna().all()
    assert found.outcomes[0].group["text"].tolist() == ["at least 10.0 (flat)", "of 1: 1 below the levels"]
    page = render(found)
    assert "No mean is known; the cells contain the numbers of participants with bounds." in page
    assert "means are geometric" not in page
    assert captions(found)["threshold"].startswith("Detection threshold: no mean is known; ")


def test_procedure_text_of_adjustment_omits_level_choice() -> None:
    study = read_table(RECORDED / "adjustment" / "study.toml", "a study")
    assert "Levels were chosen" not in procedure_text(study, "")
    assert "starting levels of adjustments were" in procedure_text(study, "")
    assert "(over frequency)" in procedure_text(read_table(RECORDED / "preference" / "study.toml", "a study"), "")


def test_analyse_runs_when_tactometry_is_not_installed(monkeypatch, capsys) -> None:
    installed = metadata.distribution

    def distribution(name):
        if name == "tactometry":
            raise metadata.PackageNotFoundError(name)
        return installed(name)

    monkeypatch.setattr(metadata, "distribution", distribution)
    assert "threshold" in output(capsys, "analyse", RECORDED / "yes-no")


def test_report_removes_the_tables_of_an_earlier_one(tmp_path):
    report, folder = tmp_path / "r.html", tmp_path / "r_tables"
    analyse(RECORDED / "comparison", report=report)
    (folder / "own.csv").write_text("a\n1\n", encoding="utf-8")
    earlier = {path.name for path in folder.glob("*.csv")}
    analyse(RECORDED / "magnitude", report=report)
    left = {path.name for path in folder.glob("*.csv")}
    assert "standard.csv" in earlier - left
    assert left == {"own.csv", *(folder / "tables.txt").read_text(encoding="utf-8").split()}


def test_report_is_written_when_the_earlier_list_is_no_text(tmp_path):
    report, listed = tmp_path / "r.html", tmp_path / "r_tables" / "tables.txt"
    listed.parent.mkdir()
    listed.write_bytes(b"\xff\xfe\n")
    assert analyse(RECORDED / "magnitude", report=report).report == report
    assert "magnitude.csv" in listed.read_text(encoding="utf-8").split()


@pytest.mark.parametrize("name", ["localisation", "yes-no"])
def test_report_and_figures_ignore_number_of_jobs(tmp_path, capsys, name) -> None:
    for n_jobs in ("1", "2"):
        (tmp_path / n_jobs).mkdir()
        places = ["--report", tmp_path / n_jobs / "r.html", "--figures", tmp_path / n_jobs / "figures"]
        output(capsys, "analyse", RECORDED / name, "--jobs", n_jobs, *places)
    assert contents(tmp_path / "1") == contents(tmp_path / "2")
    assert any(file.suffix == ".png" for file in contents(tmp_path / "1"))


def test_courses_of_motionless_finger_are_drawn() -> None:
    """All speeds are 0; an axis from 0 to 0 caused a warning."""
    course = {"time_s": np.linspace(-0.1, 0.5, 5), "low": 0.0, "median": 0.0, "high": 0.0}
    of = {"participant": "P01", "quantity": "speed_m_per_s", "target": 0.0, "band_low": np.nan, "band_high": np.nan}
    assert courses_figure(pd.DataFrame({**of, **course}), "speed_m_per_s").png()


def test_paths_may_be_text(tmp_path) -> None:
    report, figures = tmp_path / "report.html", tmp_path / "figures"
    found = analyse(str(RECORDED / "yes-no"), report=str(report), figures=str(figures))
    assert (found.report, found.figures_folder) == (report, figures)
    assert report.is_file()


@pytest.mark.parametrize("read", [read_trials, read_plan, read_column_map, load_scene, read_plate])
def test_missing_path_is_named(read) -> None:
    with pytest.raises(InvalidFile, match=r"^nowhere\.toml: "):
        read("nowhere.toml")


@pytest.fixture(scope="module")
def shown_study(tmp_path_factory) -> Analysis:
    truth = {(participant, (60.0,)): 20.0 for participant in ("P01", "P02")}
    path = tmp_path_factory.mktemp("study") / "trials.csv"
    analysis_data.write_study(path, truth, ("frequency_hz",), rng=np.random.default_rng(1))
    return analyse(path, plan=AnalysisPlan(hierarchical=False))


def test_analysis_repr_is_one_line_with_tables(shown_study: Analysis) -> None:
    text = repr(shown_study)
    assert re.match(rf"Analysis\({len(shown_study.trials.rows)} trials of 2 participants, \d+ warnings?; ", text)
    assert all(name in text for name in shown_study.tables)
    assert "\n" not in text


def test_notebook_view_lists_all_tables_estimates_first(shown_study: Analysis) -> None:
    shown = re.findall(r"<summary>(\w+) \((\d+) rows?\)</summary>", shown_study._repr_html_())
    assert {name: int(n) for name, n in shown} == {name: len(table) for name, table in shown_study.tables.items()}
    assert shown[0][0] == "thresholds"
    assert shown[-1][0] == "quality"


def test_a_notebook_has_the_warnings_as_text(shown_study: Analysis) -> None:
    shown = replace(shown_study, warnings=("one < two", "three"))._repr_html_()
    assert "<li>one &lt; two</li><li>three</li>" in shown


def test_trials_repr_is_one_line() -> None:
    assert repr(read_trials(RECORDED / "yes-no")) == "Trials(41 rows of 2 participants; frequency_hz)"
