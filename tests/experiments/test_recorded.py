"""Data sets of earlier versions read, validated, replayed and resumed."""

import io
import shutil
from pathlib import Path

import pytest
from command_line import call
from places import RECORDED
from tables import contents

from tactometry.experiments.data_sets.traces import read_traces

DATA_SETS = sorted(path.name for path in RECORDED.iterdir() if path.is_dir())
SIMULATED = [name for name in DATA_SETS if "bench" not in name and "console" not in name]


@pytest.mark.parametrize("name", DATA_SETS)
def test_recorded_data_set_is_sound(capsys, name):
    status, said, out = call(capsys, "validate", RECORDED / name)
    assert (status, said) == (0, ""), out


@pytest.mark.parametrize("name", DATA_SETS)
def test_recorded_data_set_replays(capsys, name):
    assert call(capsys, "replay", RECORDED / name)[:2] == (0, "")


@pytest.mark.parametrize("name", [name for name in DATA_SETS if name != "inquiries"])
def test_recorded_data_set_is_analysed(capsys, name):
    status, said, out = call(capsys, "analyse", RECORDED / name)
    assert (status, said) == (0, "")
    assert out


@pytest.mark.slow
def test_recorded_inquiries_are_analysed(capsys):
    assert call(capsys, "analyse", RECORDED / "inquiries")[:2] == (0, "")


def test_traces_are_read_as_they_were_kept():
    (first,), (second,) = (read_traces(RECORDED / "format-2-traces-console", trial) for trial in (1, 2))
    assert [len(touch.force.times_s) for touch in (first, second)] == [901, 1048]
    assert [len(touch.position.times_s) for touch in (first, second)] == [978, 1081]
    assert (first.answer.gate_s, first.answer.onset_s) == (1.227363, 1.228066)
    assert set(first.force.values.tolist()) == {0.3, 1.0, 1.04, 1.27}
    assert first.emitted.digest() == first.answer.digest


@pytest.mark.parametrize("name", SIMULATED)
def test_resuming_what_is_complete_changes_nothing(capsys, tmp_path, name):
    root = Path(shutil.copytree(RECORDED / name, tmp_path / name))
    for session in {path.name.split("_")[1].removeprefix("session-") for path in (root / "data").glob("*.csv")}:
        words = ("run", root / "study.toml", "--participant", "P01", "--session", session, "--rig", "simulated")
        status, said, _ = call(capsys, *words, "--out", root, "--resume")
        assert (status, said) == (0, "")
    assert contents(root) == contents(RECORDED / name)


def test_unfinished_recorded_session_resumes(capsys, tmp_path, monkeypatch):
    root = Path(shutil.copytree(RECORDED / "console", tmp_path / "console"))
    monkeypatch.setattr("sys.stdin", io.StringIO("1\n0\n1\n1\n" * 10))
    words = ("run", root / "study.toml", "--participant", "P03", "--rig", "console", "--out", root, "--resume")
    assert call(capsys, *words)[0] == 0
    status, _, out = call(capsys, "validate", root)
    assert status == 0
    assert "not finished" not in out
    assert call(capsys, "replay", root)[0] == 0
    assert call(capsys, "analyse", root)[0] == 0
