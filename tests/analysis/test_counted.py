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
SETTINGS = """participant,A,B,response
P01,b,x,21.053
P01,b,x,22.266
P02,a,x,22.265
P02,a,x,22.595
P03,b,x,23.252
P03,b,x,22.475
P04,a,x,17.463
P04,a,x,18.036
P05,b,x,20.64
P05,b,x,18.992
P06,a,x,19.095
P06,a,x,19.391
"""
MAP = """[constants]
task = "adjustment"
level = 1
"""


@pytest.mark.parametrize("root", DATA_SETS, ids=lambda root: root.name)
def test_tally_of_table_is_that_of_sessions(root):
    of_sessions = [tally(read(path).trials) for path in sessions(root)]
    names = ("n_presented", "n_invalid", "n_answers", "n_again")
    found = tally_of(read_trials(root))
    assert [getattr(found, name) for name in names] == [
        sum(getattr(one, name) for one in of_sessions) for name in names
    ]


def test_demo_and_report_count_same_trials(tmp_path, capsys):
    study = "two-interval-forced-choice"
    said = output(capsys, "simulate", study, "--participants", "2", "--seed", "1", "--out", tmp_path / "data")
    n_trials = said.split("participants, ")[1].split(" trials")[0]
    report = tmp_path / "report.html"
    found = json.loads(output(capsys, "analyse", tmp_path / "data", "--report", report, "--json"))
    assert found["n_trials"] == int(n_trials) < found["n_rows"]
    assert f"2 participants, {n_trials} trials in {found['n_rows']} presentations" in report.read_text("utf-8")


def test_reason_names_factor_that_differs_between_participants(tmp_path, capsys):
    (tmp_path / "settings.csv").write_text(SETTINGS)
    (tmp_path / "map.toml").write_text(MAP)
    files = (tmp_path / "settings.csv", "--columns", tmp_path / "map.toml")
    said = " ".join(output(capsys, "analyse", *files, "--within", "A").split())
    assert "--within A: each participant has only one level of this factor" in said
    assert "between-groups analysis of variance (by default: every participant has a value, and A differs b" in said
