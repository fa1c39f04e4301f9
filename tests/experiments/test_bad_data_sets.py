"""Errors for broken data sets and journals, which stay unchanged."""

import re

import pytest
from command_line import call
from examples import examples
from hypothesis import given, strategies as st

from tactometry.cli import main
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.study_file import load


@pytest.fixture(scope="module")
def data_set(tmp_path_factory):
    root = tmp_path_factory.mktemp("data") / "d"
    with pytest.raises(SystemExit):
        main(["simulate", "tutorial", "--participants", "2", "--seed", "3", "--out", str(root)])
    return root


@pytest.fixture
def copied(data_set, tmp_path):
    import shutil

    return shutil.copytree(data_set, tmp_path / "d")


def trials_of(root):
    return sorted((root / "data").glob("*.csv"))[0]


def edit(path, old, new, count=1):
    content = path.read_bytes()
    assert old in content
    path.write_bytes(content.replace(old, new, count))


DEFECTS = {
    "cell": (lambda root: edit(trials_of(root), b",yes_no,", b",yes,"), "column 'task': found 'yes', expected one of"),
    "row": (
        lambda root: edit(trials_of(root), b"P01,1,tutorial,1,2,", b"P01,1,tutorial,1,2,9,"),
        "row 3: found 29 cells",
    ),
    "header": (lambda root: edit(trials_of(root), b"latency_s", b"latenz_s"), "found no column 'latency_s'"),
    "bytes": (lambda root: edit(trials_of(root), b"tutorial", b"\xff"), "found no CSV in UTF-8"),
    "empty": (lambda root: trials_of(root).write_bytes(b""), "found an empty file"),
    "missing": (lambda root: trials_of(root).unlink(), "found no such file, expected the trials of the journal"),
    "extra row": (
        lambda root: trials_of(root).write_bytes(
            trials_of(root).read_bytes() + trials_of(root).read_bytes().splitlines()[-1] + b"\n"
        ),
        "expected each trial once",
    ),
    "value": (lambda root: edit(trials_of(root), b",1,1,", b",1,0,"), "found a row that differs from the journal"),
    "study": (lambda root: edit(root / "study.toml", b"tutorial", b"tutoria"), "digest of another study.toml"),
    "no study": (
        lambda root: (root / "study.toml").unlink(),
        "study.toml: cannot be read (No such file or directory), expected the study that ran",
    ),
    "description": (
        lambda root: edit(root / "dataset_description.json", b"schema.org", b"example.org"),
        "@context: found",
    ),
    "broken description": (
        lambda root: (root / "dataset_description.json").write_text("{"),
        "dataset_description.json: found no JSON",
    ),
    "unnamed column": (
        lambda root: edit(root / "dataset_description.json", b'"name": "latency_s"', b'"name": null'),
        "expected an object with a text 'name'",
    ),
    "title": (
        lambda root: edit(root / "dataset_description.json", b'"name": "Tutorial', b'"name": [], "title": "Tutorial'),
        "name: found [], expected 'a text'",
    ),
    "undescribed column": (
        lambda root: edit(root / "dataset_description.json", b'"name": "latency_s"', b'"name": "latenz_s"'),
        "has a column 'latency_s', expected both to agree",
    ),
    "journal": (
        lambda root: edit(next((root / "journals").glob("*P01*")), b'"at_s":2.0', b'"at_s":3.0'),
        "row 2: the line is damaged",
    ),
    "no journal": (lambda root: next((root / "journals").glob("*P01*")).unlink(), "found no journal of this session"),
}


@pytest.mark.parametrize("defect", DEFECTS)
def test_validate_names_the_defect(copied, capsys, defect):
    break_it, message = DEFECTS[defect]
    break_it(copied)
    status, _, out = call(capsys, "validate", copied)
    assert status == 1
    assert message in out


@pytest.mark.parametrize("words", [("analyse",), ("export", "--to", "r", "--out", "out")])
def test_table_without_valid_is_refused(copied, tmp_path, capsys, monkeypatch, words):
    monkeypatch.chdir(tmp_path)
    for path in (copied / "data").glob("*.csv"):
        edit(path, b",valid,", b",valis,")
    command, *rest = words
    status, said, _ = call(capsys, command, copied, *rest)
    assert status == 2
    assert "found no column 'valid'; every table of a session has it; did you mean 'valis'?" in said


def test_validate_reports_what_analyse_refuses(copied, capsys):
    edit(trials_of(copied), b",catch,", b",catsh,")  # a column that a table may lack
    status, said, _ = call(capsys, "analyse", trials_of(copied))
    assert status == 2
    status, _, out = call(capsys, "validate", trials_of(copied))
    assert status == 1
    assert said.split(": ", 2)[2] in out


def test_validate_finds_nothing_in_a_sound_data_set(copied, capsys):
    status, _, out = call(capsys, "validate", copied)
    assert (status, out.strip()) == (0, f"{copied}: sound; 2 sessions, {n_trials(copied)} rows")


def n_trials(root):
    return sum(path.read_bytes().count(b"\n") - 1 for path in (root / "data").glob("*.csv"))


def test_replay_names_the_first_row_that_differs(copied, capsys):
    edit(trials_of(copied), b",1,1,", b",1,0,")
    status, said, _ = call(capsys, "replay", copied)
    assert status == 1
    assert re.search(r"row \d+: found a row that differs from the journal", said)


def test_replay_of_a_damaged_journal_is_bad_input(copied, capsys):
    edit(next((copied / "journals").glob("*P01*")), b'"at_s":2.0', b'"at_s":3.0')
    status, said, _ = call(capsys, "replay", copied)
    assert status == 2
    assert "line 2: the line is damaged" in said


def test_validation_names_first_differing_row_with_wrong_seed(copied):
    from tactometry.errors import Diverged
    from tactometry.records.journal import read
    from tactometry.session.run import replay

    study, _ = load("tutorial")
    experiment = wire(study, "tutorial")
    recording = read(next((copied / "journals").glob("*P01*")))
    with pytest.raises(Diverged, match=r"line \d+: .*the recording has .*, but the protocol requests"):
        replay(experiment.course("P01", 1, 1, 4), recording.replay("journal"))


def test_resuming_with_another_seed_is_refused(copied, capsys):
    journal = next((copied / "journals").glob("*P01*"))
    journal.write_bytes(journal.read_bytes()[:-50])
    arguments = ["run", "tutorial", "--participant", "P01", "--rig", "simulated", "--seed", 4, "--resume"]
    status, said, _ = call(capsys, *arguments, "--out", copied)
    assert (status, said) == (
        2,
        "tactometry: --seed: found 4, but this session began with 3; leave it out to continue",
    )


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
    import shutil
    import tempfile
    from pathlib import Path

    with tempfile.TemporaryDirectory() as folder:
        root = Path(shutil.copytree(data_set, Path(folder) / "d"))
        journal = next((root / "journals").glob("*P01*"))
        journal.write_bytes(content)
        for command in ("replay", "validate"):
            with pytest.raises(SystemExit) as ended:
                main([command, str(root)])
            assert ended.value.code in (0, 1, 2)
        assert journal.read_bytes() == content
