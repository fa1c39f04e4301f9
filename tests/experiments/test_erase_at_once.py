"""Two erasures in one data set at once: one of them is refused, so that the record keeps a line of each."""

import json
import subprocess
import sys

import pytest
from command_line import output, refused

from tactometry.experiments.data_sets.erasing import erase, find
from tactometry.records.data_set import Session, participants

RECORD, LOCK = "erasures.jsonl", ".erasures.lock"
WAITS = """
import sys
from pathlib import Path
from tactometry.experiments.data_sets.erasing import erase

unlink = Path.unlink


def waits(path, missing_ok=False):
    if path.suffix == ".csv":
        print("erasing", flush=True)
        sys.stdin.readline()
    unlink(path, missing_ok=missing_ok)


Path.unlink = waits
erase(Path(sys.argv[1]), sys.argv[2])
"""


@pytest.fixture
def root(tmp_path):
    root = tmp_path / "d"
    for folder in (root / "journals", root / "data"):
        folder.mkdir(parents=True)
    (root / "dataset_description.json").write_text("{}")
    for code in ("P01", "P02"):
        session = Session(code, 1, "study")
        session.journal(root).write_text("")
        session.trials(root).write_text(f"participant\n{code}\n")
    return root


@pytest.fixture
def first(root):
    """Another process, in the midst of erasing P01."""
    with subprocess.Popen(
        [sys.executable, "-c", WAITS, root, "P01"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout.readline() == "erasing\n"
        yield process
        process.kill()


@pytest.mark.parametrize("code", ["P01", "P02"])
def test_the_second_is_refused_and_changes_nothing(capsys, root, first, code):
    before = {path: path.read_bytes() for path in root.rglob("*") if path.is_file()}
    said = refused(capsys, "erase", root, "--participant", code, "--yes")
    assert "another process is erasing from this data set" in said
    assert {path: path.read_bytes() for path in root.rglob("*") if path.is_file()} == before


def test_the_record_keeps_a_line_of_each(capsys, root, first):
    refused(capsys, "erase", root, "--participant", "P02", "--yes")
    assert first.communicate("\n", timeout=60) == ("", None)
    assert first.returncode == 0
    output(capsys, "erase", root, "--participant", "P02", "--yes")
    lines = [json.loads(line) for line in (root / RECORD).read_text("utf-8").splitlines()]
    assert [(line["participant"], line["finished_utc"] is None) for line in lines] == [("P01", False), ("P02", False)]
    assert (participants(root), (root / LOCK).exists()) == ([], False)


def test_dry_erase_lists_files_during_another(root, first):
    assert find(root, "P02").others == ()


def test_one_that_was_killed_bars_nobody(root, first):
    first.kill()
    first.wait(timeout=60)
    assert (root / LOCK).exists()
    for code in ("P02", "P01"):
        erase(root, code)
    assert (participants(root), (root / LOCK).exists()) == ([], False)
