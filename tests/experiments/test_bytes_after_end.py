"""Reports of any bytes after the end of a complete journal."""

import shutil
import tracemalloc

import pytest
from command_line import call, output

from tactometry.errors import InvalidFile
from tactometry.experiments.data_sets.validation import validate
from tactometry.records.data_set import sessions
from tactometry.records.journal import read

RUBBISH = {
    "one byte": b"x",
    "no newline": b"rubbish without newline",
    "spaces": b"   ",
    "zeros": bytes(4096),
    "invalid text": b"\xff\xfe",
    "torn line": b'{"event":"note","at',
}
LINES = {"newline": b"\n", "lines": b"a\nb\n", "line and rest": b"\r\n\0", "empty line and rest": b"\n\r"}
WORDS = ("run", "tutorial", "--participant", "P01", "--rig", "simulated", "--seed", "1", "--out")


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    from tactometry.cli import main

    root = tmp_path_factory.mktemp("recorded") / "d"
    with pytest.raises(SystemExit):
        main([*WORDS, str(root)])
    return root


@pytest.fixture
def journal(recorded, tmp_path):
    [path] = sessions(shutil.copytree(recorded, tmp_path / "d"))
    return path


def append(path, content):
    with path.open("ab") as file:
        file.write(content)


@pytest.mark.parametrize("rubbish", RUBBISH | LINES)
def test_validate_reports_bytes_after_end(journal, rubbish):
    n_lines = journal.read_bytes().count(b"\n")
    append(journal, (RUBBISH | LINES)[rubbish])
    [defect] = validate(journal.parent.parent).defects
    assert (defect.file, defect.row) == (f"journals/{journal.name}", n_lines + 1)
    n_bytes = len(RUBBISH.get(rubbish, b""))
    expected = f"found {n_bytes} byte{'s' * (n_bytes != 1)} after the" if n_bytes else "found a line after the"
    assert f"{expected} end of the session, expected none" in defect.text


@pytest.mark.parametrize("rubbish", RUBBISH)
def test_rebuild_moves_bytes_after_end(capsys, journal, rubbish):
    before = journal.read_bytes()
    append(journal, RUBBISH[rubbish])
    output(capsys, "rebuild", journal.parent.parent)
    assert journal.read_bytes() == before
    assert journal.with_name(f"{journal.stem}_interruptions.jsonl").stat().st_size > 0
    assert validate(journal.parent.parent).defects == ()


def test_resume_names_bytes_after_end(capsys, journal):
    append(journal, b"rubbish")
    code, said, _ = call(capsys, *WORDS, journal.parent.parent, "--resume")
    assert code == 0
    assert f"7 bytes after the end of the session are kept in {journal.stem}_interruptions.jsonl" in said


def test_many_lines_after_end_need_little_memory(journal):
    append(journal, b"\n" * 10_000_000)
    tracemalloc.start()
    try:
        with pytest.raises(InvalidFile, match="found a line after the end"):
            read(journal)
        assert tracemalloc.get_traced_memory()[1] < 30e6
    finally:
        tracemalloc.stop()
