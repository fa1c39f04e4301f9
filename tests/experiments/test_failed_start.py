"""A session that fails before its first request leaves no data set behind."""

import os
import subprocess
import sys
from dataclasses import replace

import pytest
from tables import contents
from tutorial_session import EXPERIMENT, TOML, WHO, live

from tactometry.errors import DeviceFailed
from tactometry.experiments.sessions.recording import Who, record, simulated
from tactometry.records.journal import read


def failing(root, error, who=WHO, *, resume=False):
    """Record a session whose rig cannot open."""

    def make(seed, log):
        raise error

    with pytest.raises(type(error)):
        record(EXPERIMENT, TOML, root, who, replace(simulated(EXPERIMENT, who), make=make), resume=resume)


@pytest.mark.parametrize("error", [DeviceFailed("no sensor"), KeyboardInterrupt()], ids=repr)
def test_failed_start_leaves_no_folder(tmp_path, error):
    failing(tmp_path / "data", error)
    assert not (tmp_path / "data").exists()


def test_failed_start_leaves_given_folder_empty(tmp_path):
    failing(tmp_path, DeviceFailed("no sensor"))
    assert list(tmp_path.iterdir()) == []


def test_failed_start_leaves_other_sessions_unchanged(tmp_path):
    live(tmp_path)
    before = contents(tmp_path)
    failing(tmp_path, DeviceFailed("no sensor"), Who("P02", seed=1))
    assert contents(tmp_path) == before


def test_failed_resume_keeps_recorded_trials(journal):
    journal.holds(20)
    before = read(journal.path).trials
    failing(journal.root, DeviceFailed("no sensor"), resume=True)
    assert read(journal.path).trials == before


def test_run_without_psychopy_leaves_no_data_set(tmp_path):
    (tmp_path / "psychopy.py").write_text("raise ImportError('not installed')")
    command = [sys.executable, "-m", "tactometry", "run", "tutorial", "--participant", "P01", "--out", "data"]
    env = os.environ | {"PYTHONPATH": os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])}
    done = subprocess.run(command, check=False, cwd=tmp_path, env=env, capture_output=True, text=True)
    assert done.returncode == 3, done.stderr
    assert not (tmp_path / "data").exists()
