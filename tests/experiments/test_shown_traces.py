"""Traces of a data set in figures, exports and reports."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from bids import VALIDATOR, issues_of
from command_line import call, output, refused
from places import RECORDED
from tables import rows_of, trial_rows

from tactometry.experiments.data_sets.export import export
from tactometry.experiments.data_sets.figures import heading, speed_of
from tactometry.experiments.data_sets.touch_courses import touch_courses
from tactometry.experiments.data_sets.traces import TouchTrace, read_traces, touches
from tactometry.records.journal import Entry, read
from tactometry.session.answer import Done, Intervention
from tactometry.session.request import Intervene

RECORDED_TRACES = RECORDED / "format-2-traces-console"
METRES_PER_COUNT = 5e-5
"""Of the emulated finger of that session, which moves on by one count in each of 1000 samples a second."""


@pytest.fixture
def copied(tmp_path):
    return Path(shutil.copytree(RECORDED_TRACES, tmp_path / "d"))


def test_show_prints_and_draws_a_trial(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (row, *_) = trial_rows(RECORDED_TRACES)
    said = output(capsys, "show", RECORDED_TRACES, "--trial", 1)
    assert said.startswith(f"participant {row['participant']}, session {row['session']}\n")
    assert f"onset_s             {row['onset_s']}" in said
    assert "amplitude_modulated, frequency_hz=60: 34 dB re 1 V" in said
    assert (tmp_path / "trial-1.png").read_bytes().startswith(b"\x89PNG")
    shown = json.loads(output(capsys, "show", RECORDED_TRACES, "--trial", 1, "--figure", "t.svg", "--json"))
    drawn = (tmp_path / "t.svg").read_text("utf-8")
    for words in ("Force (N)", "Place (mm)", "Speed (mm/s)", "Emitted (V)", "Time from the onset (s)"):
        assert words in drawn
    for words in ("force to hold", "gate opens", "onset", "stimulus", "emitted (envelope)"):
        assert words in drawn
    touch, *_ = shown["touches"]
    assert touch["n_samples_force"] == len(read_traces(RECORDED_TRACES, 1)[0].force.times_s)
    assert touch["gate_s"] <= touch["onset_s"]
    assert shown["figure"] == "t.svg"


def test_show_says_which_trial_and_whose_it_wants(capsys, tmp_path):
    show = ("show", RECORDED_TRACES, "--trial")
    said = refused(capsys, *show, 99)
    assert "trial: found 99, expected a trial of participant-P01_session-1_study-tutorial, from 1 to 2" in said
    assert "found 0 sessions of P02, expected one; state its participant" in refused(
        capsys, *show, 1, "--participant", "P02"
    )
    assert call(capsys, *show, 1, "--figure", tmp_path / "t.doc")[0] == 2


def test_show_draws_simulated_trials_and_blanks(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    output(capsys, "simulate", "tutorial", "--participants", 1, "--seed", 1, "--out", "d")
    blank = next(row for row in trial_rows(tmp_path / "d") if row["catch"] == "1")
    assert "blank" in output(capsys, "show", "d", "--trial", blank["trial"])
    assert (tmp_path / f"trial-{blank['trial']}.png").stat().st_size > 1000


def test_figure_speed_equals_gate_speed():
    touch, *_ = read_traces(RECORDED_TRACES, 1)
    times_s, speeds = speed_of(touch.position)
    assert np.all(np.diff(times_s) > 0)
    np.testing.assert_allclose(speeds, 1000 * METRES_PER_COUNT, rtol=0.2)  # a busy sender is late at times


@pytest.mark.skipif(VALIDATOR is None, reason="no bids-validator-deno: pip install bids-validator-deno")
def test_bids_export_has_force_and_motion(tmp_path):
    export(RECORDED_TRACES, "bids", tmp_path / "bids", ["Ada Lovelace", "Alan Turing"])
    found = [issue for issue in issues_of(tmp_path / "bids")["issues"] if "events.tsv" not in issue["location"]]
    assert {issue["severity"] for issue in found} <= {"warning"}
    # of a motion it recommends a text that no journal holds
    assert {issue.get("subCode", issue["code"]) for issue in found} <= {"TaskDescription"}


def test_export_contains_every_sample_with_time_stamp(tmp_path):
    export(RECORDED_TRACES, "bids", tmp_path / "bids")
    export(RECORDED_TRACES, "psych-ds", tmp_path / "psych")
    trials = dict.fromkeys(int(row["trial"]) for row in trial_rows(RECORDED_TRACES))
    all_touches = [touch for trial in trials for touch in read_traces(RECORDED_TRACES, trial)]
    stamps_s = np.concatenate([touch.force.times_s for touch in all_touches])
    folder = tmp_path / "bids" / "sub-P01" / "ses-1"
    [physio] = folder.glob("beh/*_recording-force_physio.tsv.gz")
    explained = json.loads(physio.with_name(physio.name.replace(".tsv.gz", ".json")).read_text("utf-8"))
    even = pd.read_csv(physio, sep="\t", header=None, names=explained["Columns"])
    places_s = explained["StartTime"] + np.arange(len(even)) / explained["SamplingFrequency"]
    known = even["time_s"].notna()
    # each sample is within half a period of its place; two that came for one place are one there
    assert np.abs(even["time_s"] - places_s)[known].max() <= 0.5 / explained["SamplingFrequency"] + 1e-6
    assert set(even["time_s"][known]) <= set(stamps_s.round(6))
    assert known.sum() >= 0.9 * len(stamps_s)
    [motion] = folder.glob("motion/*_motion.tsv")
    places = pd.read_csv(motion, sep="\t", header=None).to_numpy()
    np.testing.assert_array_equal(places[:, 0], np.concatenate([touch.position.times_s for touch in all_touches]))
    [table] = (tmp_path / "psych").glob("data/*description-force_data.csv")
    rows = pd.read_csv(table)
    np.testing.assert_array_equal(rows["time_s"], stamps_s)
    assert rows["trial"].tolist() == [touch.trial.trial for touch in all_touches for _ in touch.force.times_s]
    described = json.loads((tmp_path / "psych" / "dataset_description.json").read_text())["variableMeasured"]
    assert set(rows.columns) <= {variable["name"] for variable in described}


def test_report_shows_force_and_speed_around_onset(copied, tmp_path, capsys):
    output(capsys, "analyse", copied, "--report", tmp_path / "r.html")
    table = rows_of(tmp_path / "r_tables" / "touches.csv")
    n_valid = sum(row["valid"] == "1" for row in trial_rows(copied))
    force = [row for row in table if row["quantity"] == "force_n"]
    assert {(row["target"], row["band_low"], row["band_high"]) for row in force} == {("1.0", "0.8", "1.2")}
    after = [row for row in force if 0.0 <= float(row["time_s"]) <= 0.08]
    # its two touches were of 1.04 N and 1 N: the 5th, the 50th and the 95th percentile
    assert {(row["low"], row["median"], row["high"]) for row in after} == {("1.002", "1.02", "1.038")}
    assert {row["n_touches"] for row in after} == {str(n_valid)}
    speed = [row for row in table if row["quantity"] == "speed_m_per_s"]
    assert {(row["target"], row["band_low"], row["band_high"]) for row in speed} == {("0.05", "0.035", "0.065")}
    page = (tmp_path / "r.html").read_text("utf-8")
    assert "Applied force around stimulus onset in valid touches" in page
    assert "cannot be read" not in page


FORCE = {"Description": "Applied force", "Units": "N"}


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"SamplingFrequency": None}, "SamplingFrequency: found None, expected a number of Hz above 0"),
        ({"SamplingFrequency": float("inf")}, "SamplingFrequency: found inf, expected"),
        ({"SamplingFrequency": 10**400}, "SamplingFrequency: found 1000"),
        ({"SamplingFrequency": True}, "SamplingFrequency: found True, expected"),
        ({"SamplingFrequency": 1e9}, "SamplingFrequency: found 1e+09 Hz, expected the rate of the samples"),
        ({"Columns": None}, "Columns: found None, expected a list of distinct names"),
        ({"Columns": ["time_s", 1]}, "Columns: found ['time_s', 1], expected a list of distinct names"),
        ({"Columns": ["time_s", "time_s"]}, "Columns: found ['time_s', 'time_s'], expected"),
        ({"Columns": ["time_s"]}, "Columns: found ['time_s'], expected a name for each of the 2 columns of the"),
        ({"force_n": None}, "'force_n': found None, expected an object with the texts Description and Units"),
        ({"force_n": {"Units": "N"}}, "'force_n': found {'Units': 'N'}, expected an object"),
        ({"force_n": FORCE | {"Units": 1}}, "'force_n': found {'Description': 'Applied force', 'Units': 1}, expected"),
    ],
)
@pytest.mark.parametrize("form", ["bids", "psych-ds"])
def test_trace_description_is_refused_when_damaged(copied, tmp_path, capsys, form, changed, message):
    (path,) = (copied / "traces").glob("*_physio.json")
    path.write_text(json.dumps(json.loads(path.read_text()) | changed))
    errors = refused(capsys, "export", copied, "--to", form, "--out", tmp_path / "out")
    assert f"{path}: {message}" in errors
    status, _, out = call(capsys, "validate", copied)
    assert status == 1
    assert f"traces/{path.name}: {message}" in out


def test_touches_whose_samples_are_gone_are_counted(copied):
    (path,) = (copied / "traces").glob("*_physio.tsv.gz")
    path.write_bytes(path.read_bytes()[:-1])
    n_valid = sum(row["valid"] == "1" for row in trial_rows(copied))
    courses = touch_courses(copied)
    assert set(courses["n_unread"]) == {1}
    assert courses["n_touches"].max() == n_valid - 1


def test_touch_of_a_repeated_trial_is_marked():
    (journal,) = (RECORDED_TRACES / "journals").glob("*.jsonl")
    recording = read(journal)
    first, second = touches(recording)
    taken_back = Entry(Intervene(Intervention("invalidate", first.trial.key), "", (first.trial.key,)), Done(9.0))
    again = list(touches(replace(recording, lines=(*recording.lines, taken_back))))
    assert [touch.trial.valid for touch in (first, second, *again)] == [True, True, False, True]
    drawn = TouchTrace(again[0].head, again[0].trial, again[0].request, again[0].answer, None, None, None)
    assert heading(drawn).endswith("not valid: invalidated by the experimenter")
