"""Tests of the output for choices, questionnaires and missing answers."""

import json
import shutil
from pathlib import Path

import pandas as pd
from command_line import output
from places import RECORDED

from tactometry.analysis.pipeline import analyse_trials
from tactometry.analysis.reading.trials import read_trials, used_rows
from tactometry.analysis.report.page import figures_of, render
from tactometry.analysis.result import Analysis
from tactometry.analysis.tasks.same_different import same_different_table
from tactometry.cli.analyse import summary_text


def analysis_of(path: Path) -> Analysis:
    return analyse_trials(read_trials(path))


def unanswered(name: str, root: Path, form: str, participants: tuple[str, ...]) -> Path:
    """Copy a recorded data set with an unanswered questionnaire."""
    copy = Path(shutil.copytree(RECORDED / name, root / name))
    for file in (copy / "data").glob("*.csv"):
        rows = pd.read_csv(file, dtype=str, keep_default_na=False)
        silent = (rows["procedure"] == form) & rows["participant"].isin(participants)
        assert silent.any() or rows["participant"][0] not in participants
        rows.loc[silent, "response"] = ""
        rows.to_csv(file, index=False)
    return copy


def test_unanswered_questionnaire_has_warning(tmp_path, capsys) -> None:
    everyone = tuple(set(read_trials(RECORDED / "hybrid-button").rows["participant"]))
    found = json.loads(output(capsys, "analyse", unanswered("hybrid-button", tmp_path, "nasa-tlx", everyone), "--json"))
    of = f"none of {len(everyone)} participants answered, so there is no score"
    assert f"NASA Task Load Index (raw): {of}" in found["warnings"]
    assert set(found["questionnaires"]) == {"realism-likert"}


def test_participant_without_answers_is_counted_as_missing(tmp_path) -> None:
    root = unanswered("inquiries", tmp_path, "pleasantness-vas", ("P02",))
    form = next(form for form in analysis_of(root).forms if form.name == "pleasantness-vas")
    assert set(form.summary["n_missing"]) == {1}
    assert set(form.summary["n"]) == {2}
    assert "(n = 2, 1 missing)" in form.cross().iloc[0, 1]


def test_rated_levels_have_unit_in_procedure_text() -> None:
    found = analysis_of(RECORDED / "time-reversal-patterns")
    assert "dB re 1 um" in found.study.procedure.partition("Levels were chosen")[2]


def test_same_different_page_has_units_and_aligned_text() -> None:
    found = analysis_of(RECORDED / "same-different")
    page = render(found)
    assert found.unit == "dB re 1 V"
    for text in ("levels in dB re 1 V", ">level (dB re 1 V)<", '<td class="text">all answers alike</td>'):
        assert text in page
    assert ".text { text-align: left; }" in page
    assert "d′" in summary_text(found)


def test_identical_answers_have_no_sensitivity(tmp_path) -> None:
    """No hits in 4, no false alarms in 15: the log-linear rule alone gave d' = 1.2."""
    rows = [f"P1,{level},same_different,{felt},{catch}" for level, felt, catch, n in
            (("10", 0, 0, 4), ("20", 1, 0, 4), ("", 0, 1, 15)) for _ in range(n)]  # fmt: skip
    file = tmp_path / "t.csv"
    file.write_text("\n".join(["participant,level,task,response,catch", *rows]) + "\n")
    table = same_different_table(used_rows(read_trials(file, within=[])), ()).set_index("level")
    assert table.loc[10.0, ["d_prime_differencing", "d_prime_independent"]].isna().all()
    assert table["note"].tolist() == ["all answers alike", ""]
    assert table.loc[20.0, "d_prime_independent"] > 1


def test_preference_items_have_unit_of_their_factor() -> None:
    found = analysis_of(RECORDED / "preference")
    page = render(found)
    places = [page.index(f">{item}<") for item in ("60 Hz", "120 Hz", "240 Hz")]
    assert places == sorted(places)
    assert set(found.tables["preference"]["item"]) == {"60", "120", "240", "first of the pair"}


def test_methods_describe_rule_estimate(whole) -> None:
    methods = analysis_of(RECORDED / "electrovibration-threshold").methods
    assert "levels (mean of an even number of reversals, without the first two or three) is reported next to" in methods
    assert "posterior mean)" not in methods
    assert "procedure that chose the levels" not in analysis_of(whole).methods


def test_rate_captions_name_single_participant(whole) -> None:
    captions = {figure.name: figure.caption for figure in figures_of(analysis_of(whole))}
    assert captions["rates_yes_no"] == "Rate of “yes” by level, one participant."
    assert captions["mean_rates_yes_no"] == "Rate of “yes” over all levels, one participant."
