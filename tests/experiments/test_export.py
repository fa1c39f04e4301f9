"""Exports to BIDS, PsychoPy, jsPsych and R."""

import json
import re
import shutil
import stat
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from bids import VALIDATOR, issues_of
from command_line import output
from hard_cases import exact_case
from own_form import OWN_FORM
from tables import contents, rows_of

from tactometry.analysis.attrakdiff.scoring import scores
from tactometry.analysis.reading.column_map import read_column_map
from tactometry.analysis.reading.trials import read_trials, used_rows
from tactometry.errors import InvalidFile, InvalidParameter
from tactometry.experiments.data_sets.export import export
from tactometry.experiments.sessions.simulation import Simulation, simulate
from tactometry.experiments.study.study_file import load
from tactometry.questionnaire import load as load_questionnaire

FORMS = ("bids", "jspsych", "psych-ds", "psychopy", "r")


@pytest.fixture(scope="module")
def data_set(tmp_path_factory) -> Path:
    root = tmp_path_factory.mktemp("export") / "tutorial"
    list(simulate(Simulation(load("tutorial")[1], "tutorial", root, 2, seed=4)))
    return root


@pytest.fixture(scope="module")
def answers(tmp_path_factory) -> Path:
    """Write a trials file of a questionnaire: two patterns, two sessions."""
    rng = np.random.default_rng()
    items = [item.id for item in load_questionnaire("attrakdiff").items]
    lines = ["participant,session,study,block,trial,pattern,procedure,level,task,item,response,valid"]
    for person in ("P1", "P2"):
        for session in (1, 2):
            for n, (pattern, item) in enumerate(((p, i) for p in ("P0", "P3") for i in items), 1):
                cells = (person, session, "patterns", 1, n, pattern, "attrakdiff", "", "rating", item)
                lines.append(",".join(map(str, (*cells, rng.integers(1, 8), 1))))
    path = tmp_path_factory.mktemp("answers") / "answers.csv"
    path.write_text("\n".join(lines) + "\n")
    return path


# --- every form


@pytest.fixture(scope="module", params=FORMS)
def written(request, data_set, tmp_path_factory) -> tuple[str, Path, list[Path]]:
    folder = tmp_path_factory.mktemp(request.param) / "new" / "out"
    return request.param, folder, export(data_set, request.param, folder)


def test_same_data_export_to_same_bytes(data_set, written, tmp_path) -> None:
    form, folder, _ = written
    export(data_set, form, tmp_path / "again")
    assert contents(tmp_path / "again") == contents(folder)


def test_export_contains_each_trial_once_and_keeps_source(data_set, tmp_path, written) -> None:
    form, _, files = written
    before = contents(data_set)
    export(data_set, form, tmp_path / "out")
    assert contents(data_set) == before
    rows = [row for path in files if path.suffix == ".csv" for row in rows_of(path)]
    if form == "jspsych":
        rows = [trial for path in files if path.suffix == ".json" for trial in json.loads(path.read_text())]
    if form == "bids":
        rows = [row for path in files if path.name.endswith("_events.tsv") for row in rows_of(path)]
    assert len(rows) == len(read_trials(data_set).rows)
    exact_case("export of a data set in any form", against="each trial once, the same bytes before")


def test_exported_files_are_private_and_contain_no_local_path(data_set, written) -> None:
    _, _, files = written
    assert {stat.S_IMODE(path.stat().st_mode) for path in files} == {0o600}
    assert {stat.S_IMODE(path.parent.stat().st_mode) for path in files} == {0o700}
    assert not [path for path in files if str(data_set.parents[1]).encode() in path.read_bytes()]


def test_export_marks_simulated_participants(data_set, answers, tmp_path) -> None:
    for form in ("bids", "psych-ds"):
        described = []
        for name, source in (("simulated", data_set), ("people", answers)):
            export(source, form, tmp_path / form / name)
            content = json.loads((tmp_path / form / name / "dataset_description.json").read_text())
            words = (tmp_path / form / name / "README.md").read_text().lower()
            described.append((content.get("Keywords", content.get("keywords")), "simulated" in words))
        assert described == [(["simulated data"], True), (None, False)]


@pytest.mark.parametrize("form", FORMS)
def test_export_refuses_mixed_people_and_simulated_participants(data_set, tmp_path, form) -> None:
    mixed = shutil.copytree(data_set, tmp_path / "mixed")
    shutil.rmtree(mixed / "journals")
    table, _ = sorted((mixed / "data").glob("*.csv"))
    table.write_text(table.read_text().replace(",simulated,", ",console,"))
    with pytest.raises(InvalidFile, match=r"mixed: found \d+ rows of simulated participants next to those of people"):
        export(mixed, form, tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("form", FORMS)
def test_sessions_of_older_and_newer_versions_export_together(data_set, tmp_path, form) -> None:
    root = Path(shutil.copytree(data_set, tmp_path / "d"))
    file = min((root / "data").glob("*.csv"))
    pd.read_csv(file, dtype=str, keep_default_na=False).drop(columns="rig").to_csv(file, index=False)
    written = export(root, form, tmp_path / "out")
    assert any(b"simulated" in path.read_bytes() for path in written if path.suffix in (".csv", ".tsv", ".json"))


def test_export_refuses_full_folder_missing_source_and_unknown_form(tmp_path, data_set) -> None:
    (tmp_path / "mine").write_text("")
    with pytest.raises(InvalidParameter, match="--out: found files in .*, expected a new or an empty"):
        export(data_set, "r", tmp_path)
    with pytest.raises(InvalidFile, match="no such file or folder"):
        export(tmp_path / "nowhere", "bids", tmp_path / "out")
    with pytest.raises(
        InvalidParameter, match="--to: found 'bid', expected one of bids, jspsych, psych-ds, psychopy, r; did you mean"
    ):
        export(data_set, "bid", tmp_path / "out")


def test_export_command_lists_written_files(data_set, tmp_path, capsys) -> None:
    said = output(capsys, "export", data_set, "--to", "r", "--out", tmp_path / "r", "--json")
    assert json.loads(said)["files"] == ["trials.R", "trials.csv"]


# --- BIDS


@pytest.mark.skipif(VALIDATOR is None, reason="no bids-validator-deno: pip install bids-validator-deno")
def test_bids_validator_accepts_questionnaire_answers(answers, tmp_path) -> None:
    export(answers, "bids", tmp_path / "bids", ["Ada Lovelace", "Alan Turing"])
    assert issues_of(tmp_path / "bids")["issues"] == []


def test_bids_events_have_onset_duration_and_described_columns(data_set, tmp_path) -> None:
    written = export(data_set, "bids", tmp_path / "bids")
    events = [path for path in written if path.name.endswith("_events.tsv")]
    assert [path.name for path in events] == [f"sub-P0{n}_ses-1_task-tutorial_run-01_events.tsv" for n in (1, 2)]
    for path in events:
        rows, described = rows_of(path), json.loads(path.with_suffix(".json").read_text())
        assert list(rows[0])[:2] == ["onset", "duration"]
        assert set(rows[0]) <= set(described)
        assert {type(value) for value in described.values()} == {dict}  # as bids-validator 1 needs
        assert all(re.fullmatch(r"-?[\d.]+(e-?\d+)?", row["onset"]) for row in rows)
        assert "" not in {cell for row in rows for cell in row.values()}


def test_answers_become_items_and_scores(answers, tmp_path) -> None:
    export(answers, "bids", tmp_path / "bids")
    items = rows_of(tmp_path / "bids/sub-P1/ses-2/beh/sub-P1_ses-2_task-attrakdiff_beh.tsv")
    assert len(items) == 2 * 28
    people = rows_of(tmp_path / "bids/phenotype/attrakdiff.tsv")
    own = scores(pd.read_csv(answers), within=["session", "pattern"])
    truth = own[(own["participant"] == "P2") & (own["session"] == 1) & (own["pattern"] == "P3")]["ATT"].iloc[0]
    assert [row["participant_id"] for row in people] == ["sub-P1", "sub-P2"]
    assert float(people[1]["ses1_P3_ATT"]) == pytest.approx(truth)
    assert set(people[0]) <= set(json.loads((tmp_path / "bids/phenotype/attrakdiff.json").read_text()))


def test_unplayed_trial_exports_as_behaviour(data_set, tmp_path) -> None:
    file = tmp_path / "one.csv"
    rows = pd.read_csv(min((data_set / "data").glob("*.csv")), dtype=str, keep_default_na=False)
    rows.loc[3, "onset_s"] = ""
    rows.to_csv(file, index=False)
    export(file, "bids", tmp_path / "bids")
    folder = tmp_path / "bids/sub-P01/ses-1/beh"
    (left,) = rows_of(folder / "sub-P01_ses-1_task-tutorial_beh.tsv")
    assert left["trial"] == rows.loc[3, "trial"]
    assert len(rows_of(folder / "sub-P01_ses-1_task-tutorial_run-01_events.tsv")) == len(rows) - 1
    rows.drop(columns="onset_s").to_csv(file, index=False)
    without = export(file, "bids", tmp_path / "without")
    assert [path.name for path in without if path.suffix == ".tsv" and "beh" in path.name] == [
        "sub-P01_ses-1_task-tutorial_beh.tsv"
    ]


def test_unanswered_touch_is_exported_without_score(answers, tmp_path) -> None:
    header, *rows = answers.read_text().splitlines()
    failed = "P1,1,patterns,1,1,P0,attrakdiff,,rating,,,0"
    (tmp_path / "a.csv").write_text("\n".join([header, failed, *rows]) + "\n")
    export(tmp_path / "a.csv", "bids", tmp_path / "bids")
    found = rows_of(tmp_path / "bids/sub-P1/ses-1/beh/sub-P1_ses-1_task-attrakdiff_beh.tsv")
    assert (found[0]["item"], found[0]["valid"], len(found)) == ("n/a", "0", 2 * 28 + 1)
    export(answers, "bids", tmp_path / "without")
    scores_of = [(tmp_path / name / "phenotype/attrakdiff.tsv").read_bytes() for name in ("bids", "without")]
    assert scores_of[0] == scores_of[1]


def test_custom_questionnaire_of_a_study_is_scored(tmp_path) -> None:
    (tmp_path / "study.toml").write_text(OWN_FORM, "utf-8")
    lines = ["participant,session,study,block,trial,procedure,level,task,item,response,valid"]
    lines += [f"P1,1,mine,1,1,mine,,rating,{item},1,1" for item in "AB"]
    (tmp_path / "data").mkdir()
    (tmp_path / "data/a_data.csv").write_text("\n".join(lines) + "\n")
    export(tmp_path, "bids", tmp_path / "bids")
    assert (tmp_path / "bids/phenotype/mine.tsv").is_file()


def test_bids_authors_are_the_given_ones(data_set, tmp_path) -> None:
    export(data_set, "bids", tmp_path / "bids", ["Ada Lovelace"])
    assert json.loads((tmp_path / "bids/dataset_description.json").read_text())["Authors"] == ["Ada Lovelace"]


# --- PsychoPy and jsPsych


@pytest.mark.parametrize(
    ("form", "more", "latency_error"), [("psychopy", (), 0.0), ("jspsych", ("trial", "correct", "frequency_hz"), 3e-16)]
)
def test_export_reads_back_with_its_column_map(data_set, tmp_path, form, more, latency_error) -> None:
    """jsPsych's milliseconds may change the last bit."""
    export(data_set, form, tmp_path)
    own = read_trials(data_set)
    again = read_trials(tmp_path, within=own.factors, column_map=read_column_map(tmp_path / "columns.toml"))
    assert f"--within {','.join(own.factors)}\n" in (tmp_path / "columns.toml").read_text()
    for name in ("participant", "level", "response", "onset_s", *more):
        np.testing.assert_array_equal(used_rows(again)[name], used_rows(own)[name])
    np.testing.assert_allclose(used_rows(again)["latency_s"], used_rows(own)["latency_s"], rtol=latency_error)
    if form == "psychopy":
        assert rows_of(min((tmp_path / "data").glob("P01*.csv")))[0]["trials.thisN"] == "0"
    exact_case("PsychoPy's form and back", against="the rows")


@pytest.mark.parametrize("form", ["psychopy", "jspsych"])
def test_reading_an_export_suggests_its_column_map(data_set, tmp_path, form) -> None:
    out = tmp_path / form
    export(data_set, form, out)
    with pytest.raises(
        InvalidFile, match=f"expected --columns {re.escape(str(out / 'columns.toml'))}; the comment in its first line"
    ):
        read_trials(out)


def test_jspsych_export_has_jspsych_names_and_types(data_set, tmp_path) -> None:
    (_, file, *_) = export(data_set, "jspsych", tmp_path / "js")
    trials = json.loads(file.read_text())
    rows = rows_of(data_set / "data" / "participant-P01_session-1_study-tutorial_data.csv")
    first, row = trials[0], rows[0]
    assert [trial["trial_index"] for trial in trials] == list(range(len(rows)))
    assert (first["subject"], first["trial_type"]) == ("P01", "yes_no")
    assert first["rt"] == round(float(row["latency_s"]) * 1000, 3)
    assert first["time_elapsed"] == pytest.approx(1000 * (float(row["onset_s"]) + float(row["latency_s"])))
    answered = [trial for trial in trials if trial["valid"]]
    assert {type(trial["correct"]) for trial in answered} == {bool}
    assert {type(trial["response"]) for trial in answered} == {int}
    assert {trial["level"] for trial in trials if trial["catch"]} == {None}


def test_export_refuses_a_jspsych_column_name(tmp_path) -> None:
    table = tmp_path / "t.csv"
    table.write_text("participant,trial,rt,procedure,level,task,response\nP1,1,a,staircase,1,yes_no,1\n")
    with pytest.raises(
        InvalidParameter, match="--to: found jspsych, which uses the name 'rt' itself, expected another form"
    ):
        export(table, "jspsych", tmp_path / "js")


# --- R


def test_r_table_has_no_empty_cell(data_set, tmp_path) -> None:
    export(data_set, "r", tmp_path / "r")
    rows = rows_of(tmp_path / "r/trials.csv")
    assert "" not in {cell for row in rows for cell in row.values()}
    script = (tmp_path / "r/trials.R").read_text()
    assert all(f'"{name}" = ' in script for name in rows[0])
    assert '"level" = "numeric"' in script
    assert '"response" = "character"' in script
