"""Consent before all questions, and questions before the first touch."""

import io

import pytest
from command_line import call, output
from study_texts import TUTORIAL as CONSTANT_TUTORIAL
from tables import trial_rows

from tactometry.experiments.data_sets.replaying import replay_data_set
from tactometry.experiments.data_sets.validation import validate
from tactometry.records.journal import read
from tactometry.session.request import Choose, Fill, Show

TUTORIAL = CONSTANT_TUTORIAL.replace("repeats = 4", "repeats = 1")
ABOUT = """
[inquiries.about]
form = "habits"
after = "start"

[forms.habits]
title = "Habits"
reference = "own wording"
low = 1.0
high = 5.0
steps = 5
score_low = 1.0
score_high = 5.0
stem = { en = "About you" }
items = [{ id = "screens", dimension = "habit", order = 1, statement = { en = "How often do you use touch screens?" } }]
ends = { en = ["never", "daily"] }

[forms.habits.dimensions.habit]
min_answered = 1
"""


@pytest.fixture
def study(tmp_path):
    (tmp_path / "s.toml").write_text(f"consent = true\n{TUTORIAL}{ABOUT}", "utf-8")
    return tmp_path / "s.toml"


def asked(root):
    """Return the journal's pages and questions before the first touch."""
    [journal] = (root / "journals").glob("*_study-tutorial.jsonl")
    names = {Show: "message", Choose: "question", Fill: "form"}
    return [
        getattr(entry.request, names[type(entry.request)])
        for entry in read(journal).entries
        if type(entry.request) in names
    ]


def on_console(monkeypatch, capsys, study, root, lines):
    monkeypatch.setattr("sys.stdin", io.StringIO(lines))
    return call(capsys, "run", study, "--participant", "P01", "--rig", "console", "--seed", 1, "--out", root)


def test_session_asks_nothing_without_consent(study, tmp_path, capsys, monkeypatch):
    status, _, said = on_console(monkeypatch, capsys, study, tmp_path / "d", "no\n")
    assert status == 1
    assert "next: nothing to analyse: no block was finished" in said
    assert "Your answers are kept under a code" in said
    assert "Nothing else will be asked" in said
    assert asked(tmp_path / "d") == ["welcome", "consent", "agree", "declined"]
    assert trial_rows(tmp_path / "d") == []
    assert validate(tmp_path / "d").defects == ()


def test_consent_precedes_personal_questions_and_trials(study, tmp_path, capsys, monkeypatch):
    status, errors, _ = on_console(monkeypatch, capsys, study, tmp_path / "d", "yes\n4\n" + "1\n" * 40)
    assert status == 0, errors
    first = ["welcome", "consent", "agree", "questions_first", "habits", "instructions_yes_no", "block"]
    assert asked(tmp_path / "d")[: len(first)] == first
    rows = trial_rows(tmp_path / "d")
    assert (rows[0]["item"], rows[0]["response"], rows[0]["frequency_hz"]) == ("screens", "4", "")
    assert [session.complete for session in replay_data_set(tmp_path / "d")] == [True]


def test_refused_consent_leaves_other_data_readable(study, tmp_path, capsys, monkeypatch):
    root = tmp_path / "d"
    on_console(monkeypatch, capsys, study, root, "no\n")
    for command in ("analyse", "export --to psych-ds --out x"):
        word, *more = command.split()
        assert call(capsys, word, root, *more)[0] == 2, "there is nothing else"
    monkeypatch.setattr("sys.stdin", io.StringIO("yes\n4\n" + "1\n" * 40))
    assert call(capsys, "run", study, "--participant", "P02", "--rig", "console", "--out", root)[0] == 0
    said = output(capsys, "analyse", root)
    assert "1 session without trials left out:" in said
    for to in ("psychopy", "bids", "psych-ds"):
        output(capsys, "export", root, "--to", to, "--out", tmp_path / to)


def test_simulated_participants_agree_and_their_data_are_analysed(study, tmp_path, capsys):
    root = tmp_path / "d"
    output(capsys, "simulate", study, "--participants", 2, "--seed", 1, "--out", root)
    for command in ("validate", "replay", "analyse"):
        output(capsys, command, root)
    assert {row["item"] for row in trial_rows(root)} == {"", "screens"}
    for to in ("psychopy", "bids"):
        output(capsys, "export", root, "--to", to, "--out", tmp_path / to)
