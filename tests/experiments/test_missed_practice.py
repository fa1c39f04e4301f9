"""Missed practice criteria in reports, exclusion and prompts."""

import io
import json

import pytest
from command_line import call, output, refused
from study_texts import TUTORIAL as CONSTANT_TUTORIAL
from tables import event_rows, is_sound, trial_rows

TUTORIAL = CONSTANT_TUTORIAL.replace("[60, 240]", "[240]").replace("catch_rate = 0.2\n", "")
ASK = 'on_miss = "ask"\n'
NOT_FELT, FELT = "0\n" * 6, "1\n" * 3
SAID = "the practice missed its criterion: "
DECISION = "decision of the experimenter after missed practice criterion: P01"


@pytest.fixture
def study(tmp_path):
    """Write the tutorial with a practice at one level, and more tables."""

    def written(level, more=""):
        path = tmp_path / "mine.toml"
        practice = f"\n[practice]\nlevels = [{level}]\nn_correct = 3\nn_of = 3\nn_trials = 6\n"
        path.write_text(f"{TUTORIAL}{practice}{more}")
        return path

    return written


@pytest.mark.parametrize(("level", "is_missed"), [(-10.0, True), (39.9, False)])
def test_run_and_analyse_report_missed_practice(study, tmp_path, capsys, level, is_missed):
    session = ("run", study(level), "--participant", "P01", "--rig", "simulated", "--seed", "3", "--out")
    said = output(capsys, *session, tmp_path / "session")
    assert ("the practice ended without meeting its criterion" in said) == is_missed
    arguments = ("simulate", study(level), "--participants", "2", "--seed", "3", "--out", tmp_path / "data")
    assert json.loads(output(capsys, *arguments, "--json"))["practice_missed"] == 2 * is_missed
    warnings = json.loads(output(capsys, "analyse", tmp_path / "data", "--json"))["warnings"]
    assert ("practice criterion not met: P01, P02" in warnings) == is_missed


def test_exclusion_rule_leaves_out_who_missed_practice(study, tmp_path, capsys):
    path = study(24.0, "\n[analysis.exclusion]\npractice = true\n")
    output(capsys, "simulate", path, "--participants", "8", "--seed", "3", "--out", tmp_path / "data")
    found = json.loads(output(capsys, "analyse", tmp_path / "data", "--json"))
    (warned,) = [text for text in found["warnings"] if text.startswith("practice criterion not met")]
    missed = warned.partition(": ")[2].split(", ")
    assert 0 < len(missed) < 8
    assert {row["participant"] for row in found["excluded"]} == set(missed)
    assert {row["rule"] for row in found["excluded"]} == {"practice"}
    assert not {row["participant"] for row in found["thresholds"]} & set(missed)


def on_console(monkeypatch, capsys, path, root, lines, *more):
    monkeypatch.setattr("sys.stdin", io.StringIO(lines))
    return call(capsys, "run", path, "--participant", "P01", "--rig", "console", "--seed", 1, "--out", root, *more)


def choices(root):
    texts = [row["text"] for row in event_rows(root) if row["trial_type"] == "intervention"]
    assert all(text.startswith(SAID) for text in texts)
    return [text.removeprefix(SAID) for text in texts]


def n_trials_of(root):
    flags = [row["practice"] for row in trial_rows(root)]
    return flags.count("1"), flags.count("0")


@pytest.mark.parametrize(
    ("lines", "status", "chosen", "n_practice", "is_missed"),
    [
        (f"{NOT_FELT}again\n{FELT}", 0, ["again"], 9, False),
        (f"{NOT_FELT}1\n{NOT_FELT}2\n", 0, ["again", "go on"], 12, True),
        (f"{NOT_FELT}go on\n", 0, ["go on"], 6, True),
        (f"{NOT_FELT}end\n", 1, ["end session"], 6, True),
        (FELT, 0, [], 3, False),
    ],
)
def test_experimenter_chooses_after_missed_practice(
    study, tmp_path, capsys, monkeypatch, lines, status, chosen, n_practice, is_missed
):
    root = tmp_path / "data"
    ended, errors, said = on_console(monkeypatch, capsys, study(39.9, ASK), root, lines + "1\n" * 40)
    assert ended == status, errors
    assert choices(root) == chosen
    n_practised, n_tested = n_trials_of(root)
    assert (n_practised, n_tested > 0) == (n_practice, status == 0)
    assert ("the practice ended without meeting its criterion" in said) == is_missed
    assert is_sound(root)


@pytest.mark.parametrize(
    ("lines", "warned"),
    [
        (f"{NOT_FELT}1\n{FELT}", [f"{DECISION} again"]),
        (f"{NOT_FELT}1\n{NOT_FELT}2\n", ["practice criterion not met: P01", f"{DECISION} again, go on"]),
    ],
)
def test_analyse_reports_choices_after_missed_practice(study, tmp_path, capsys, monkeypatch, lines, warned):
    on_console(monkeypatch, capsys, study(39.9, ASK), tmp_path / "data", f"{lines}{'01' * 40}".replace("01", "0\n1\n"))
    report = tmp_path / "report.html"
    found = json.loads(output(capsys, "analyse", tmp_path / "data", "--report", report, "--json"))
    assert [text for text in found["warnings"] if "practice" in text] == warned
    assert f"{SAID}again" in report.read_text("utf-8")


@pytest.mark.parametrize(("choice", "n_practice"), [("1\n", 9), ("2\n", 6)])
def test_resumed_session_keeps_choice_after_missed_practice(study, tmp_path, capsys, monkeypatch, choice, n_practice):
    path, root = study(39.9, ASK), tmp_path / "data"
    on_console(monkeypatch, capsys, path, root, NOT_FELT + choice)  # the input ends behind the choice
    rest = FELT if n_practice == 9 else ""
    status, errors, _ = on_console(monkeypatch, capsys, path, root, f"{rest}{FELT * 10}", "--resume")
    assert status == 0, errors
    assert len(choices(root)) == 1
    assert n_trials_of(root)[0] == n_practice
    assert is_sound(root)


def test_simulated_participant_goes_on_after_missed_practice(study, tmp_path, capsys):
    root = tmp_path / "data"
    found = output(capsys, "simulate", study(-10.0, ASK), "--participants", "2", "--seed", "3", "--out", root, "--json")
    assert json.loads(found)["practice_missed"] == 2
    assert choices(root) == ["go on", "go on"]
    output(capsys, "replay", root)


def test_unknown_choice_on_missed_practice_is_refused(study, capsys):
    said = refused(capsys, "run", study(39.9, 'on_miss = "stop"\n'), "--participant", "P01", "--dry-run")
    assert "practice.on_miss: found stop, expected one of go_on, ask" in said.replace("'", "")
