"""Tests that simulated data are marked, and that trials are counted alike everywhere."""

import csv
import io
import json
import shutil
from pathlib import Path

import pytest
from command_line import call, output
from places import RECORDED
from sound_sitting import SOUND, sit

from tactometry.analysis.pipeline import analyse_trials
from tactometry.analysis.reading import origin
from tactometry.analysis.reading.quality import tally_of
from tactometry.analysis.reading.trials import read_trials
from tactometry.analysis.report.page import render
from tactometry.records.data_set import sessions
from tactometry.records.head import heads
from tactometry.records.journal import read
from tactometry.trials.trial import tally

LINE = "Simulated participants, no people (seed 1)."
TITLE = "Tutorial: is there a vibration under the finger?"
METHOD = "The participants were simulated by Tactometry (seed 1); no person took part."


def test_report_states_that_participants_are_simulated(whole):
    page = render(analyse_trials(read_trials(whole)))
    body = page.split("<body>")[1]
    assert body.index(f"<h1>{TITLE} (simulated)</h1>") < body.index(LINE) < body.index("<h2>")
    assert METHOD in page
    assert f"<title>{TITLE} (simulated)</title>" in page
    assert body.count(LINE.removesuffix(".")) == 1


def test_terminal_states_simulation_first(whole, capsys):
    assert output(capsys, "analyse", whole).startswith(f"! {LINE.removesuffix('.')}")
    found = json.loads(output(capsys, "analyse", whole, "--json"))
    assert (found["simulated"], found["seeds"]) == (True, [1])


def test_analyse_decodes_each_journal_once(whole, capsys, monkeypatch):
    decoded = []
    monkeypatch.setattr(origin, "heads", lambda path: decoded.append(path) or heads(path))
    assert call(capsys, "analyse", whole)[0] == 0
    assert sorted(decoded) == sorted((whole / "journals").glob("*.jsonl"))


def test_origin_without_stated_participants_is_read_from_trials(whole):
    single = analyse_trials(read_trials(next((whole / "data").glob("*.csv"))))
    assert single.origin.line == "Simulated participants, no people (seed not known)."
    of_older_version = analyse_trials(read_trials(RECORDED / "yes-no"))
    assert of_older_version.origin.line == "Simulated participants, no people (seed 14)."


def test_recorded_participants_have_no_simulation_line(tmp_path):
    sit(tmp_path, SOUND)
    found = analyse_trials(read_trials(tmp_path))
    assert (found.origin.line, found.origin.method, found.origin.warnings) == ("", "", ())
    assert "imulated" not in render(found).split("<body>")[1]
    console = analyse_trials(read_trials(RECORDED / "console"))
    assert not console.origin.is_simulated


@pytest.fixture
def mixed(tmp_path, whole):
    """Return recorded participants with copied files of a simulated participant."""
    sit(tmp_path / "d", SOUND)
    for folder in ("data", "journals"):
        for path in (whole / folder).iterdir():
            copy = tmp_path / "d" / folder / path.name.replace("P01", "P77")
            copy.write_bytes(path.read_bytes().replace(b"P01", b"P77"))
    return tmp_path


def test_mixed_table_leaves_out_simulated_participants(mixed, whole, capsys):
    n_rows = len(next((whole / "data").glob("*.csv")).read_text().splitlines()) - 1
    real, simulated = sorted((mixed / "d" / "data").glob("*.csv"))
    alone, both = analyse_trials(read_trials(real)), mixed / "both.csv"
    both.write_text(real.read_text() + simulated.read_text().partition("\n")[2])
    pooled = analyse_trials(read_trials(both))
    assert pooled.tables["thresholds"].equals(alone.tables["thresholds"])
    assert pooled.warnings[0] == (
        f"simulated participants were excluded, as the table also contains real ones (P77: {n_rows} rows); "
        "analyse them separately"
    )
    assert not pooled.origin.is_simulated
    status, _, out = call(capsys, "validate", mixed / "d")
    assert (status, "found simulated participants" in out) == (1, True)


def test_journals_identify_simulated_participants_of_older_version(tmp_path):
    root, other = Path(shutil.copytree(RECORDED / "console", tmp_path / "d")), RECORDED / "yes-no"
    own = "participant-P77_session-1_study-console"
    (journal,) = (other / "journals").glob("*P01*.jsonl")
    head, _, rest = journal.read_text().partition("\n")
    (root / "journals" / f"{own}.jsonl").write_text(head.replace('"P01"', '"P77"') + "\n" + rest)
    rows = [row for path in (root / "data").glob("*.csv") for row in csv.DictReader(path.read_text().splitlines())]
    (table,) = (other / "data").glob("*P01*.csv")
    added = [row | {"participant": "P77", "study": "console"} for row in csv.DictReader(table.read_text().splitlines())]
    assert list(added[0]) == list(rows[0])
    with (root / "data" / f"{own}_data.csv").open("w", newline="") as text:
        writer = csv.DictWriter(text, added[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows(added)
    found = analyse_trials(read_trials(root))
    assert "P77" not in set(found.trials.rows["participant"])
    assert found.origin.warnings[0].startswith("simulated participants were excluded, as the table also contains real")


def test_changed_setting_between_sittings_has_warning(tmp_path):
    sit(tmp_path, SOUND, stops_at=4)
    sit(tmp_path, {**SOUND, "output_volts_per_unit": 400.0}, resume=True)
    assert analyse_trials(read_trials(tmp_path)).warnings[0] == (
        "P01, session 1: sitting 2 differs from the previous one: output_volts_per_unit was 200.0, is 400.0"
    )


def test_damaged_journal_does_not_prevent_analysis(lived):
    next((lived / "journals").glob("*.jsonl")).write_bytes(b"{\n")
    assert analyse_trials(read_trials(lived)).origin.is_simulated


def test_simulated_sessions_have_separate_default_folder(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for rig in ("simulated", "console"):
        monkeypatch.setattr("sys.stdin", io.StringIO("1\n" * 99))
        assert call(capsys, "run", "tutorial", "--participant", "P01", "--rig", rig)[0] == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["tutorial-data", "tutorial-simulated"]


DATA_SETS = sorted(path.parent for path in RECORDED.glob("*/journals"))


@pytest.mark.parametrize("root", DATA_SETS, ids=lambda root: root.name)
def test_tally_of_table_is_that_of_sessions(root):
    of_sessions = [tally(read(path).trials) for path in sessions(root)]
    names = ("n_presented", "n_invalid", "n_answers", "n_again")
    found = tally_of(read_trials(root))
    for name in names:
        assert getattr(found, name) == sum(getattr(one, name) for one in of_sessions), name


def test_demo_and_report_count_same_trials(tmp_path, capsys):
    study, data, report = "two-interval-forced-choice", tmp_path / "data", tmp_path / "report.html"
    text = output(capsys, "simulate", study, "--participants", "2", "--seed", "1", "--out", data)
    n_trials = text.split("participants, ")[1].split(" trials")[0]
    found = json.loads(output(capsys, "analyse", data, "--report", report, "--json"))
    assert found["n_trials"] == int(n_trials) < found["n_rows"]
    assert f"2 participants, {n_trials} trials in {found['n_rows']} presentations" in report.read_text("utf-8")
