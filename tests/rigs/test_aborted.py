"""Reports of aborted blocks, and questionnaires between blocks."""

import json

import pytest
from command_line import call
from places import RECORDED
from study_texts import changed
from tables import event_rows, trial_rows

from tactometry.experiments.data_sets.validation import validate
from tactometry.experiments.study.study_file import load
from tactometry.records.journal import read
from tactometry.session.request import Record
from tactometry.trials.trial import tally

STUDY = RECORDED / "inquiries" / "study.toml"


def study_in(folder, **changes):
    text = STUDY.read_text(encoding="utf-8")
    path = folder / "study.toml"
    path.write_text(changed(text, {"n_attempts = 2": "n_attempts = 1", **changes}), encoding="utf-8")
    return path


def run(capsys, folder, *more, **changes):
    words = ("run", study_in(folder, **changes), "--participant", "P01", "--rig", "simulated", "--seed", 2)
    return call(capsys, *words, "--out", folder / "d", *more)


def recording_of(root):
    return read(next((root / "journals").glob("*.jsonl")))


STEADY, SHAKY = {"waver_cv = 0.12": "waver_cv = 0.0"}, {"waver_cv = 0.12": "waver_cv = 0.3"}


def test_aborted_block_is_reported_in_summary_and_events(tmp_path, capsys):
    status, _, out = run(capsys, tmp_path)
    assert status == 1
    [abort] = [event for event in event_rows(tmp_path / "d") if event["trial_type"] == "abort"]
    lost = [row for row in trial_rows(tmp_path / "d") if row["valid"] == "0"]
    assert [(row["block"], row["trial"], row["attempt"]) for row in lost] == [
        (abort["block"], abort["trial"], abort["attempt"])
    ]
    why = "1 presentation in a row, or of one trial, was not valid"
    assert abort["text"] == f"block {abort['block']} is aborted: {why}"
    assert "2 procedures: " in out
    assert "1 reached their last trial" in out
    assert "1 aborted" in out
    assert "next: tactometry analyse" in out
    assert validate(tmp_path / "d").defects == ()


def planned(longest_s):
    return {**STEADY, "[procedure]": f"[plan]\nlongest_s = {longest_s}\n\n[procedure]"}


@pytest.mark.parametrize(
    ("changes", "status", "words"),
    [
        (STEADY, 0, ": 10 trials, and 14 answers to questionnaires; 2 procedures: 2 reached their last trial"),
        (SHAKY, 1, "2 procedures: 2 aborted; next: correct the cause of the invalid touches: no block was finished"),
        (planned(10), 1, "not begun"),
        (planned(0.5), 1, "not begun"),
    ],
    ids=["completed", "every block aborts", "too long a plan", "too short a plan"],
)
def test_session_end_is_summarised(tmp_path, capsys, changes, status, words):
    ended, _, out = run(capsys, tmp_path, **changes)
    assert ended == status
    assert words in out


def test_json_summary_counts_aborted_procedures(tmp_path, capsys):
    run(capsys, tmp_path, **SHAKY)
    said = json.loads(run(capsys, tmp_path, "--session", "1", "--resume", "--json", **SHAKY)[2])
    assert (said["ended"], said["not_valid"]) == ({"aborted": 2}, 2)


@pytest.mark.parametrize(("waver", "asked"), [(0.9, {"sus"}), (0.0, {"sus", "pleasantness-vas"})])
def test_block_without_valid_touch_has_no_questionnaire(tmp_path, capsys, waver, asked):
    run(capsys, tmp_path, **{"waver_cv = 0.12": f"waver_cv = {waver}"})
    rows = trial_rows(tmp_path / "d")
    assert {row["valid"] for row in rows if row["task"] == "yes_no"} == {str(int(waver == 0.0))}
    assert {row["procedure"] for row in rows if row["task"] == "rating"} == asked
    assert validate(tmp_path / "d").defects == ()


def test_summary_counts_repeated_trials_once(tmp_path, capsys):
    patient = {"n_attempts = 2": "n_attempts = 9", **SHAKY}
    _, _, out = run(capsys, tmp_path, **patient)
    rows = [row for row in trial_rows(tmp_path / "d") if row["task"] == "yes_no"]
    n_trials = len({(row["block"], row["trial"]) for row in rows})
    assert n_trials < len(rows)
    assert f"{n_trials} trials in {len(rows)} presentations, " in out
    said = json.loads(run(capsys, tmp_path, "--session", "1", "--resume", "--json", **patient)[2])
    assert (said["trials"], said["presentations"]) == (n_trials, len(rows))


def test_resume_restores_lost_events_table(tmp_path, capsys):
    run(capsys, tmp_path)
    events = event_rows(tmp_path / "d")
    next((tmp_path / "d" / "journals").glob("*_events.tsv")).unlink()
    assert next(each.text for each in validate(tmp_path / "d").defects).startswith(
        "found no such file, expected the events"
    )
    run(capsys, tmp_path, "--resume")
    assert event_rows(tmp_path / "d") == events


def test_simulate_reports_aborted_procedures(tmp_path, capsys):
    words = ("simulate", study_in(tmp_path), "--participants", 2, "--seed", 2, "--out", tmp_path / "d")
    status, _, out = call(capsys, *words)
    n_aborted = sum(event["trial_type"] == "abort" for event in event_rows(tmp_path / "d"))
    assert status == 0
    assert n_aborted > 0
    assert "2 simulated participants, " in out
    assert f"{n_aborted} procedure{'s' * (n_aborted > 1)} aborted" in out


def test_block_aborts_when_it_lasts_too_long(tmp_path, capsys):
    status, _, _ = run(capsys, tmp_path, **{**STEADY, "n_attempts = 2": "longest_s = 2.0"})
    assert status == 1
    texts = [event["text"] for event in event_rows(tmp_path / "d")]
    assert texts == [f"block {n} is aborted: it has lasted longer than 2 s" for n in (1, 3)]


# --- questionnaires between blocks


@pytest.fixture(scope="module")
def asked(tmp_path_factory):
    from tactometry.experiments.sessions.recording import Who, record, simulated
    from tactometry.experiments.study.experiment import wire

    folder = tmp_path_factory.mktemp("asked")
    study, toml = load(str(study_in(folder, **STEADY)))
    experiment, who = wire(study, "study"), Who("P01", seed=2)
    record(experiment, toml, folder / "d", who, simulated(experiment, who))
    return folder / "d"


def test_questionnaire_after_block_has_its_condition(asked):
    rows = trial_rows(asked)
    felt = {row["block"]: row["frequency_hz"] for row in rows if row["task"] == "yes_no"}
    after_blocks = [row for row in rows if row["procedure"] == "pleasantness-vas"]
    assert [row["frequency_hz"] for row in after_blocks] == [felt[str(int(row["block"]) - 1)] for row in after_blocks]
    assert {row["frequency_hz"] for row in after_blocks} == {"60", "240"}
    assert {row["frequency_hz"] for row in rows if row["procedure"] == "sus"} == {""}


def test_questionnaire_after_block_is_analysed_by_condition(asked, capsys):
    status, _, out = call(capsys, "analyse", asked, "--json")
    assert status == 0
    forms = json.loads(out)["questionnaires"]
    assert [row["frequency_hz"] for row in forms["pleasantness-vas"]] == [60, 60, 240, 240]
    assert len(forms["sus"]) == 1


def test_questionnaire_answers_do_not_count_as_trials(asked):
    recording = recording_of(asked)
    assert len(recording.trials) == 10 + 2 * 2 + 10
    assert (tally(recording.trials).n_presented, tally(recording.trials).n_answers) == (10, 14)
    records = [request for request, _ in recording.entries if isinstance(request, Record)]
    assert not any(request.aborted for request in records)
