"""Errors for devices and files that the user has no permission to open."""

import io
import os
import shutil
import tempfile
import tty
from contextlib import contextmanager
from datetime import date
from pathlib import Path

import numpy as np
import pytest
from command_line import call
from emulated import available
from places import RECORDED
from tutorial_session import EXPERIMENT, TOML

from tactometry.devices.outputs.file import FileSettings
from tactometry.devices.outputs.gain import Gain
from tactometry.devices.outputs.packed import PackedSettings
from tactometry.devices.sensors.reader import Reader
from tactometry.devices.sensors.recorded import RecordedSettings
from tactometry.devices.sensors.serial_line import SerialSettings
from tactometry.devices.sensors.touch_screen import TouchSettings
from tactometry.errors import DeviceFailed, InvalidFile
from tactometry.experiments.bench.bench_file import load_bench
from tactometry.experiments.bench.preflight_checks import exit_status, findings_of
from tactometry.experiments.study.study_file import load
from tactometry.records.data_set import prepare
from tactometry.safety.limits import Limits
from tactometry.signal import Signal

NOBODY = 65534
TONE = Signal(np.zeros((1, 10)), 1e3, "V")
pytestmark = pytest.mark.skipif(not hasattr(os, "geteuid"), reason="no users as POSIX has them")


@contextmanager
def unprivileged():
    """Run as an unprivileged user if this process runs as root."""
    root = os.geteuid() == 0
    if root:
        os.seteuid(NOBODY)
    try:
        yield
    finally:
        if root:
            os.seteuid(0)


@pytest.fixture
def folder():
    """Folder that every user may enter and write to."""
    path = Path(tempfile.mkdtemp())
    path.chmod(0o777)
    yield path
    shutil.rmtree(path)


@pytest.fixture
def line(folder):
    """Serial line that no other user may open."""
    master, slave = os.openpty()
    tty.setraw(slave)
    path = Path(os.ttyname(slave))
    path.chmod(0)
    yield path
    os.close(slave)
    os.close(master)


@pytest.mark.skipif(not available("serial"), reason="no pyserial: extra serial")
def test_serial_line_without_permission_is_refused(line):
    refused = pytest.raises(DeviceFailed, match="serial /dev/.*: cannot open the line .*Permission denied")
    with unprivileged(), refused as no:
        Reader(SerialSettings(str(line), 1000.0).source()).open()
    assert no.value.exit_status == 3


def closed(folder, name, content=""):
    path = folder / name
    path.write_text(content, encoding="utf-8")
    path.chmod(0)
    return path


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (TouchSettings, "touch .*: cannot open it .Permission denied., expected a readable event device"),
        (lambda path: RecordedSettings(path, 100.0), "cannot be read as a recording .*Permission denied"),
    ],
)
def test_sensor_without_permission_is_refused(folder, settings, message):
    path = closed(folder, "event5", "time_s,count\n0,1\n")
    with unprivileged(), pytest.raises(DeviceFailed, match=message) as refused:
        Reader(settings(str(path)).source()).open()
    assert refused.value.exit_status == 3


@pytest.mark.parametrize("settings", [FileSettings, PackedSettings])
def test_output_without_permission_is_refused(folder, settings):
    inner = folder / "inner"
    inner.mkdir(mode=0o755)
    output = settings(str(inner / "played"), n_channels=1, rate_hz=1e3).driver(Gain(1.0, 1.0))

    def played():
        output.open()
        output.play(TONE)

    refused = pytest.raises(DeviceFailed, match="played: .*Permission denied.*nothing was played")
    with unprivileged(), refused as no:
        played()
    assert no.value.exit_status == 3
    assert list(inner.iterdir()) == []


def test_data_set_without_permission_is_refused(folder):
    inner = folder / "inner"
    inner.mkdir(mode=0o755)
    refused = pytest.raises(DeviceFailed, match="cannot create the folder .Permission denied., expected disk space and")
    with unprivileged(), refused:
        prepare(inner / "data", EXPERIMENT.design(TOML))
    with unprivileged():
        prepare(folder / "data", EXPERIMENT.design(TOML))


def test_bench_file_and_study_without_permission_are_refused(folder):
    path = closed(folder, "bench.toml")
    with unprivileged(), pytest.raises(InvalidFile, match="bench.toml: cannot be read .Permission denied."):
        load_bench(path)
    with unprivileged(), pytest.raises(InvalidFile, match="bench.toml.*Permission denied"):
        load(str(path))


@pytest.mark.skipif(not available("serial"), reason="no pyserial: extra serial")
def test_check_reports_missing_permission_with_exit_status_3(line, folder):
    path = folder / "bench.toml"
    path.write_text(f'[sensors.hand]\nkind = "serial"\nrate_hz = 1000\nport = "{line}"\n', encoding="utf-8")
    reader = load_bench(path).devices(Limits(1.0), date(2026, 11, 21)).readers["hand"]

    def opened():
        reader.open()
        yield

    with unprivileged():
        findings = list(findings_of("sensor hand", opened()))
    assert "Permission denied" in findings[0].found
    assert exit_status(findings) == 3


# --- the files of a data set

FILES = {
    "table": "data/participant-P01_session-1_study-console_data.csv",
    "columns": "data/participant-P01_session-1_study-console_data.json",
    "journal": "journals/participant-P01_session-1_study-console.jsonl",
    "study": "study.toml",
    "description": "dataset_description.json",
    "tables": "data",
    "journals": "journals",
}


def removed(path):
    shutil.rmtree(path) if path.is_dir() else path.unlink()


DAMAGES = {
    "closed": lambda path: path.chmod(0),
    "a folder": lambda path: (removed(path), path.mkdir()),
    "a pipe": lambda path: (removed(path), os.mkfifo(path)),
    "a link to nothing": lambda path: (removed(path), path.symlink_to("gone")),
    "a link to itself": lambda path: (removed(path), path.symlink_to(path.name)),
}


def in_sentences(capsys, *words):
    """Run a command and check that its error, if any, is one sentence."""
    status, said, out = call(capsys, *words)
    assert status in (0, 1, 2, 3)
    assert "Traceback" not in said + out
    assert (status < 2) or (said.startswith("tactometry: ") and "\n" not in said)
    return status, said, out


@pytest.fixture(scope="module")
def loaded():
    """Import all modules of the commands, as another user may not read them."""
    import tactometry.analysis.pipeline
    import tactometry.experiments.data_sets.export

    del tactometry


@pytest.mark.parametrize("damage", DAMAGES)
@pytest.mark.parametrize("file", FILES)
def test_unreadable_data_set_files_give_one_sentence(folder, capsys, monkeypatch, loaded, file, damage):
    recorded, root = RECORDED / "console", folder / "d"
    shutil.copy(recorded / "study.toml", folder / "s.toml")
    resume = ("run", folder / "s.toml", "--participant", "P01", "--rig", "console", "--out", root, "--resume")
    for words in (("replay", root), ("validate", root), ("rebuild", root), resume):
        shutil.copytree(recorded, root)
        for path in (root, *root.rglob("*")):
            os.chown(path, NOBODY, NOBODY) if os.geteuid() == 0 else None
        DAMAGES[damage](root / FILES[file])
        monkeypatch.setattr("sys.stdin", io.StringIO(""))
        with unprivileged():
            status, said, out = in_sentences(capsys, *words)
        if words[0] == "validate" and damage != "a folder":
            assert status in (1, 2)
            assert (Path(FILES[file]).name if "journal" not in file else "journal") in said + out
        for path in (root / "data", root / "journals"):
            if path.is_dir() and not path.is_symlink():
                path.chmod(0o700)
        shutil.rmtree(root)


def test_unreadable_data_folder_is_not_reported_as_empty(folder, capsys, loaded):
    root = shutil.copytree(RECORDED / "console", folder / "d")
    root.chmod(0o755)
    (root / "data").chmod(0)
    with unprivileged():
        status, said, _ = in_sentences(capsys, "analyse", root)
    (root / "data").chmod(0o700)
    assert status == 2
    assert said == f"tactometry: {root / 'data'}: cannot be read (Permission denied), expected a readable folder"
