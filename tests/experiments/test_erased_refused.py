"""Refusal of erased participants, and of two erasures at the same time."""

import json
import re
import shutil
import subprocess
import sys

import pytest
from command_line import output, refused, status
from tables import contents

from tactometry.errors import InvalidFile, InvalidParameter
from tactometry.experiments.data_sets.erasing import erase, find
from tactometry.records.data_set import Session, participants
from tactometry.records.erasures import RECORD, refuse_erased

SIMULATE = ("simulate", "tutorial", "--participants", "3", "--seed", "1", "--out")
RUN = ("run", "tutorial", "--rig", "simulated", "--seed", "1", "--participant", "P02", "--out")
UNFINISHED = {"participant": "P02", "begun_utc": "2026-01-01", "version": "1", "n_sessions": 1, "n_files": 1}


@pytest.fixture(scope="module")
def set_without_p02(tmp_path_factory):
    root = tmp_path_factory.mktemp("erased") / "d"
    assert status(*SIMULATE, root) == 0
    erase(root, "P02")
    return root


@pytest.fixture
def erased(set_without_p02, tmp_path):
    return shutil.copytree(set_without_p02, tmp_path / "d")


def names(root):
    return sorted(path.relative_to(root).as_posix() for path in root.rglob("*"))


@pytest.mark.parametrize(
    "words", [(*SIMULATE,), (*RUN,), ("run", "tutorial", "--rig", "console", "--dry-run", *RUN[-3:])], ids=" ".join
)
@pytest.mark.parametrize("options", [(), ("--resume",)], ids=["new", "resumed"])
def test_command_refuses_erased_participant(capsys, erased, words, options):
    before = names(erased)
    said = refused(capsys, *words, erased, *options)
    assert re.search(r"erasures.jsonl, line 1: found that P02 was erased at 20\d\d-\d\d-\d\dT", said)
    assert "--allow-erased" in said
    assert names(erased) == before


@pytest.mark.parametrize("words", [SIMULATE, RUN], ids=["simulate", "run"])
def test_allow_erased_records_participant_again(capsys, erased, words):
    output(capsys, *words, erased, "--resume", "--allow-erased")
    assert any("-P02_" in name for name in names(erased))


@pytest.mark.parametrize("code", ["P02", "p02"])
def test_capitals_of_erased_code_make_no_difference(erased, code):
    with pytest.raises(InvalidParameter, match="P02 was erased"):
        refuse_erased(erased, ["P01", code])


def test_unfinished_erasure_is_refused_when_allowed(erased):
    """Repeating it would erase the files of the new session."""
    (erased / RECORD).write_text(json.dumps(UNFINISHED))
    with pytest.raises(InvalidParameter, match="found an unfinished erasure of P02"):
        refuse_erased(erased, ["P02"], allowed=True)


@pytest.mark.parametrize(
    "record",
    [
        json.dumps(UNFINISHED | {"participant": "9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08"}),
        '{"participant":"P0',
        "\0" * 40,
        "[" * 200_000,
    ],
    ids=["hash", "torn", "zeros", "deep"],
)
def test_damaged_record_refuses_every_participant(erased, record):
    (erased / RECORD).write_text(record)
    with pytest.raises(InvalidFile, match=r"erasures.jsonl, line 1: found no erasure \("):
        refuse_erased(erased, ["P09"], allowed=True)


def test_record_that_links_nowhere_refuses_participant(erased):
    (erased / RECORD).unlink()
    (erased / RECORD).symlink_to(erased / "missing")
    with pytest.raises(InvalidFile, match="cannot be read"):
        refuse_erased(erased, ["P09"])


# --- two erasures at the same time


LOCK = ".erasures.lock"
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
def test_concurrent_erasure_is_refused_without_changes(capsys, root, first, code):
    before = contents(root)
    said = refused(capsys, "erase", root, "--participant", code, "--yes")
    assert "another process is erasing from this data set" in said
    assert find(root, "P02").others == ()
    assert contents(root) == before


def test_record_has_a_line_for_each_erasure(capsys, root, first):
    refused(capsys, "erase", root, "--participant", "P02", "--yes")
    assert first.communicate("\n", timeout=60) == ("", None)
    assert first.returncode == 0
    output(capsys, "erase", root, "--participant", "P02", "--yes")
    lines = [json.loads(line) for line in (root / RECORD).read_text("utf-8").splitlines()]
    assert [(line["participant"], line["finished_utc"] is None) for line in lines] == [("P01", False), ("P02", False)]
    assert (participants(root), (root / LOCK).exists()) == ([], False)


def test_killed_erasure_does_not_block_others(root, first):
    first.kill()
    first.wait(timeout=60)
    assert (root / LOCK).exists()
    for code in ("P02", "P01"):
        erase(root, code)
    assert (participants(root), (root / LOCK).exists()) == ([], False)
