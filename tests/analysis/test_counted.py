"""Tests of the design and the trial counts in a report."""

import json

import pytest
from command_line import output
from places import RECORDED

from tactometry.analysis.reading.quality import tally_of
from tactometry.analysis.reading.trials import read_trials
from tactometry.records.data_set import sessions
from tactometry.records.journal import read
from tactometry.trials.trial import tally

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
