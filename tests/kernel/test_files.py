"""Files of a data set: permissions, atomic writes and refused paths."""

import os
import re
import stat
from functools import partial
from pathlib import Path

import pytest
from command_line import call
from copies import at_once
from tutorial_session import live

from tactometry.errors import DeviceFailed, InvalidFile
from tactometry.files.durable import drafts, make_folder, read_file, replace_file, write_atomically, write_first


def mode(path):
    return stat.S_IMODE(path.stat().st_mode)


@pytest.fixture
def open_umask():
    """Set a umask with which new files are readable by all users."""
    before = os.umask(0)
    yield
    os.umask(before)


def test_recorded_files_are_private(tmp_path, open_umask):
    root = tmp_path / "new" / "data"
    live(root)
    for path in (tmp_path / "new", root, *root.rglob("*")):
        assert mode(path) == (0o700 if path.is_dir() else 0o600), path


def test_files_written_by_commands_are_private(whole, tmp_path, open_umask, capsys):
    out = tmp_path / "made" / "report.html"
    assert call(capsys, "analyse", whole, "--report", out, "--figures", tmp_path / "figures")[0] == 0
    assert call(capsys, "export", whole, "--to", "bids", "--out", tmp_path / "bids", "--author", "A. Lovelace")[0] == 0
    written = [path for path in tmp_path.rglob("*") if not path.is_relative_to(whole)]
    assert len(written) > 10
    for path in written:
        assert mode(path) == (0o700 if path.is_dir() else 0o600), path
    probe = tmp_path / "after"
    probe.touch()
    assert mode(probe) == 0o666


def test_existing_files_keep_their_mode(lived, open_umask):
    trials = next((lived / "data").glob("*.csv"))
    trials.chmod(0o640)
    (lived / "data").chmod(0o750)
    content = trials.read_bytes()
    live(lived, resume=True)
    assert (mode(trials), mode(lived / "data"), trials.read_bytes()) == (0o640, 0o750, content)


def test_write_first_keeps_the_first_writer(tmp_path):
    """Several processes write. The file has one content completely."""
    path, contents = tmp_path / "f", [f"{n}" * 5000 for n in range(8)]
    assert at_once(partial(write_first, path, content.encode()) for content in contents) == [0] * len(contents)
    assert path.read_text() in contents
    assert drafts(tmp_path) == []


def test_write_first_works_without_hard_links(tmp_path, monkeypatch):
    def no_links(*_):
        raise PermissionError

    monkeypatch.setattr(os, "link", no_links)
    write_first(tmp_path / "f", b"first")
    write_first(tmp_path / "f", b"second")
    assert (tmp_path / "f").read_bytes() == b"first"
    assert mode(tmp_path / "f") == 0o600
    assert drafts(tmp_path) == []


def test_readers_see_old_or_new_content(tmp_path):
    path = tmp_path / "f"
    write_atomically(path, b"old")
    with path.open("rb") as reader:
        os.close(replace_file(path, b"newer"))
        assert (reader.read(), path.read_bytes()) == (b"old", b"newer")


@pytest.mark.parametrize("kind", ["folder", "pipe", "absent", "dangling"])
def test_read_file_refuses_paths_that_are_no_file(tmp_path, kind):
    path = tmp_path / "f"
    makers = {"folder": path.mkdir, "pipe": lambda: os.mkfifo(path), "dangling": lambda: path.symlink_to("gone")}
    makers.get(kind, lambda: None)()
    found = {"folder": "found a folder", "pipe": "found a pipe or a device"}.get(kind, "cannot be read .No such file")
    with pytest.raises(InvalidFile, match=re.escape(str(path)) + f": {found}.*, expected a table"):
        read_file(path, "a table")


def test_make_folder_reports_failures(tmp_path):
    with pytest.raises(DeviceFailed, match="cannot create the folder"):
        make_folder(tmp_path / ("x" * 300))
    (tmp_path / "f").touch()
    with pytest.raises(InvalidFile, match="f: found a file, expected a folder for the data set"):
        make_folder(tmp_path / "f" / "deeper")


def test_drafts_lists_only_drafts(tmp_path):
    for name in (".f.csv.12", ".f.csv.x", "f.csv.12", ".g.csv.3"):
        (tmp_path / name).touch()
    assert drafts(tmp_path, "f.csv") == [tmp_path / ".f.csv.12"]
    assert drafts(Path(tmp_path)) == [tmp_path / ".f.csv.12", tmp_path / ".g.csv.3"]


def test_write_atomically_replaces_a_stale_draft(tmp_path):
    (tmp_path / f".f.{os.getpid()}").symlink_to(tmp_path / "other")
    (tmp_path / "other").write_bytes(b"precious")
    write_atomically(tmp_path / "f", b"new")
    assert ((tmp_path / "f").read_bytes(), (tmp_path / "other").read_bytes()) == (b"new", b"precious")
    assert drafts(tmp_path) == []
