"""Errors for broken data sets and journals, which stay unchanged."""

import re
import shutil
import tempfile
from pathlib import Path

import pytest
from command_line import call, refused, status as exit_status
from examples import examples
from hypothesis import given, strategies as st
from tables import trial_rows


@pytest.fixture(scope="module")
def data_set(tmp_path_factory):
    root = tmp_path_factory.mktemp("data") / "d"
    assert exit_status("simulate", "tutorial", "--participants", "2", "--seed", "3", "--out", root) == 0
    return root


@pytest.fixture
def copied(data_set, tmp_path):
    return shutil.copytree(data_set, tmp_path / "d")


def trials_of(root):
    return sorted((root / "data").glob("*.csv"))[0]


def edit(path, old, new, count=1):
    content = path.read_bytes()
    assert old in content
    path.write_bytes(content.replace(old, new, count))


TRIALS, STUDY, DESCRIPTION = "data/*P01*.csv", "study.toml", "dataset_description.json"
DEFECTS = [
    (TRIALS, b",yes_no,", b",yes,", "column 'task': found 'yes', expected one of"),
    (TRIALS, b"P01,1,tutorial,1,2,", b"P01,1,tutorial,1,2,9,", "row 3: found 29 cells"),
    (TRIALS, b"latency_s", b"latenz_s", "found no column 'latency_s'"),
    (TRIALS, b"tutorial", b"\xff", "found no CSV in UTF-8"),
    (TRIALS, b",1,1,", b",1,0,", "found a row that differs from the journal"),
    (STUDY, b"tutorial", b"tutoria", "digest of another study.toml"),
    (DESCRIPTION, b"schema.org", b"example.org", "@context: found"),
    (DESCRIPTION, b"{", b"[", "dataset_description.json: found no JSON"),
    (DESCRIPTION, b'"name": "latency_s"', b'"name": null', "expected an object with a text 'name'"),
    (DESCRIPTION, b'"name": "Tutorial', b'"name": [], "title": "Tutorial', "name: found [], expected 'a text'"),
    (DESCRIPTION, b'"name": "latency_s"', b'"name": "latenz_s"', "has a column 'latency_s', expected both to agree"),
    ("journals/*P01*", b'"at_s":2.0', b'"at_s":3.0', "row 2: the line is damaged"),
]
MISSING = [
    (TRIALS, "found no such file, expected the trials of the journal"),
    (STUDY, "study.toml: cannot be read (No such file or directory), expected the study that ran"),
    ("journals/*P01*", "found no journal of this session"),
]


def assert_defect(capsys, root, message):
    status, _, out = call(capsys, "validate", root)
    assert status == 1
    assert message in out


@pytest.mark.parametrize(("file", "old", "new", "message"), DEFECTS)
def test_validate_names_the_defect(copied, capsys, file, old, new, message):
    edit(min(copied.glob(file)), old, new)
    assert_defect(capsys, copied, message)


@pytest.mark.parametrize(("file", "message"), MISSING)
def test_validate_names_a_missing_file(copied, capsys, file, message):
    min(copied.glob(file)).unlink()
    assert_defect(capsys, copied, message)


def test_validate_finds_empty_files_and_repeated_rows(copied, capsys):
    content = trials_of(copied).read_bytes()
    trials_of(copied).write_bytes(b"")
    assert_defect(capsys, copied, "found an empty file")
    trials_of(copied).write_bytes(content + content.splitlines()[-1] + b"\n")
    assert_defect(capsys, copied, "expected each trial once")


@pytest.mark.parametrize("words", [("analyse",), ("export", "--to", "r", "--out", "out")])
def test_table_without_valid_is_refused(copied, tmp_path, capsys, monkeypatch, words):
    monkeypatch.chdir(tmp_path)
    for path in (copied / "data").glob("*.csv"):
        edit(path, b",valid,", b",valis,")
    command, *rest = words
    said = refused(capsys, command, copied, *rest)
    assert "found no column 'valid'; every table of a session has it; did you mean 'valis'?" in said


def test_validate_reports_what_analyse_refuses(copied, capsys):
    edit(trials_of(copied), b",catch,", b",catsh,")  # a column that a table may lack
    said = refused(capsys, "analyse", trials_of(copied))
    status, _, out = call(capsys, "validate", trials_of(copied))
    assert status == 1
    assert said.split(": ", 2)[2] in out


def test_validate_finds_nothing_in_a_sound_data_set(copied, capsys):
    status, _, out = call(capsys, "validate", copied)
    assert (status, out.strip()) == (0, f"{copied}: sound; 2 sessions, {len(trial_rows(copied))} rows")


def test_replay_names_the_first_row_that_differs(copied, capsys):
    edit(trials_of(copied), b",1,1,", b",1,0,")
    status, said, _ = call(capsys, "replay", copied)
    assert status == 1
    assert re.search(r"row \d+: found a row that differs from the journal", said)


def test_resuming_with_another_seed_is_refused(copied, capsys):
    journal = next((copied / "journals").glob("*P01*"))
    journal.write_bytes(journal.read_bytes()[:-50])
    arguments = ["run", "tutorial", "--participant", "P01", "--rig", "simulated", "--seed", 4, "--resume"]
    status, said, _ = call(capsys, *arguments, "--out", copied)
    assert (status, said) == (2, "tactometry: --seed: found 4, but this session began with 3; leave it out to continue")


@pytest.mark.parametrize("begin", [b"", b'{"head":', b'{"sitting":', b'{"event":"stimulus","facts":'])
def test_deeply_nested_journal_is_damaged(copied, capsys, begin):
    journal = next((copied / "journals").glob("*P01*"))
    whole = journal.read_bytes()
    journal.write_bytes((whole if begin.startswith((b'{"s', b'{"e')) else b"") + begin + b"[" * 100_000 + b"\n")
    assert call(capsys, "validate", copied)[:2] == (1, "")
    arguments = ["run", "tutorial", "--participant", "P01", "--rig", "simulated", "--resume"]
    status, said, _ = call(capsys, *arguments, "--out", copied)
    assert (status, len(said.splitlines())) == (2, 1)


@given(content=st.binary(max_size=400))
@examples(50)
def test_random_bytes_for_a_journal_never_give_a_traceback(data_set, content):
    with tempfile.TemporaryDirectory() as folder:
        root = Path(shutil.copytree(data_set, Path(folder) / "d"))
        journal = next((root / "journals").glob("*P01*"))
        journal.write_bytes(content)
        for command in ("replay", "validate"):
            assert exit_status(command, root) in (0, 1, 2)
        assert journal.read_bytes() == content
