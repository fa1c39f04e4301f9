"""Erasure of one participant from a data set, with a record of it."""

import json
import shutil
from contextlib import suppress
from pathlib import Path

import pytest
from command_line import call, output, refused, status
from hypothesis import given, strategies as st
from places import RECORDED

from tactometry.experiments.data_sets.erasing import erase, find
from tactometry.experiments.data_sets.validation import validate
from tactometry.records.data_set import Session, participants
from tactometry.records.open_journal import Journal

DATA_SETS = sorted(path.name for path in RECORDED.iterdir() if path.is_dir())
RECORD = "erasures.jsonl"
RECORDED_ONLY = shutil.ignore_patterns("report*", "exports")
FORMS = ("bids", "jspsych", "psych-ds", "psychopy", "r")
CODES = st.from_regex(r"[A-Za-z0-9]{1,8}", fullmatch=True)


@pytest.fixture(scope="module")
def studied(tmp_path_factory):
    root = tmp_path_factory.mktemp("studied") / "d"
    for code, seed in (("P01", 1), ("QX7", 2), ("P03", 3)):
        words = ("run", "tutorial", "--participant", code, "--number", seed, "--rig", "simulated", "--seed", seed)
        assert status(*words, "--out", root) == 0
    assert status("analyse", root, "--report", root / "report.html") == 0
    for form in FORMS:
        assert status("export", root, "--to", form, "--out", root / "exports" / form) == 0
    return root


@pytest.fixture
def copied(studied, tmp_path):
    return Path(shutil.copytree(studied, tmp_path / "d"))


@pytest.fixture
def two(studied, tmp_path):
    return Path(shutil.copytree(studied, tmp_path / "d", ignore=RECORDED_ONLY))


def tree(root):
    return {path.relative_to(root).as_posix(): path.read_bytes() for path in root.rglob("*") if path.is_file()}


def recorded_of(files, code):
    parts = ("data/", "journals/", "traces/")
    return {name: content for name, content in files.items() if name.startswith(parts) and f"-{code}_" in name}


def test_erase_removes_one_participant_only(capsys, copied):
    before = tree(copied)
    told = json.loads(output(capsys, "erase", copied, "--participant", "QX7", "--yes", "--json"))
    after = tree(copied)
    of_record = after.pop(RECORD)
    assert not any("QX7" in path.relative_to(copied).as_posix() for path in copied.rglob("*"))
    assert not [name for name, content in after.items() if b"QX7" in content]
    assert b"QX7" in of_record
    for code in ("P01", "P03"):
        assert recorded_of(after, code) == recorded_of(before, code) != {}
    assert all(after[name] == before[name] for name in ("dataset_description.json", "study.toml"))
    assert {*told["own"], *told["derived"]} == before.keys() - after.keys()
    assert validate(copied).defects == ()


def test_erase_removes_derived_files(capsys, copied):
    said = output(capsys, "erase", copied, "--participant", "QX7", "--yes")
    assert "recreate them with" in said
    kept = {"data", "dataset_description.json", RECORD, "journals", "study.toml"}
    assert {path.name for path in copied.iterdir()} == kept
    output(capsys, "export", copied, "--to", "r", "--out", copied / "exports" / "r")
    assert "QX7" not in (copied / "exports" / "r" / "trials.csv").read_text("utf-8")


def test_erasure_includes_figures_without_codes(two):
    """Group means and single-trial figures do not name the participant."""
    derived = ("figures/force.csv", "figures/force.png", "figures/force.svg", "trial-17.png")
    (two / "figures").mkdir()
    for name in (*derived, "setup.png"):
        (two / name).write_text("force_n\n1\n")
    done = erase(two, "QX7")
    assert (done.derived, done.others) == (derived, ("setup.png",))
    assert not (two / "figures").exists()


def test_erasure_record_has_participant_time_version_and_counts(two):
    done = erase(two, "QX7")
    line = json.loads((two / RECORD).read_text("utf-8"))
    assert (line["participant"], line["n_sessions"], line["n_files"], line["files"]) == ("QX7", 1, 3, [])
    assert line["begun_utc"] <= line["finished_utc"] == done.erasure.finished_utc
    assert line["version"]
    assert any("QX7 (1 session) was erased" in note for note in validate(two).notes)


def test_dry_run_lists_files_without_changes(capsys, two):
    (two / "notes.md").write_text("QX7 was ill\n")
    before = tree(two)
    said = output(capsys, "erase", two, "--participant", "QX7", "--dry-run")
    assert tree(two) == before
    assert all(name in said for name in recorded_of(before, "QX7"))
    assert "! notes.md\n" in said
    assert "P01" not in said


@pytest.mark.parametrize("answer", ["n", ""])
def test_erase_asks_for_confirmation_at_a_terminal(capsys, monkeypatch, two, answer):
    before = tree(two)
    monkeypatch.setattr("sys.stdin.isatty", lambda: True, raising=False)
    monkeypatch.setattr("click.termui.visible_prompt_func", lambda _: answer)
    code, said, out = call(capsys, "erase", two, "--participant", "QX7")
    assert (code, tree(two)) == (1, before)
    assert "nothing was erased" in out + said


def test_running_session_is_not_erased(capsys, two):
    before = tree(two)
    journal = Journal(Session("QX7", 1, "tutorial").journal(two), resume=True)
    try:
        said = refused(capsys, "erase", two, "--participant", "QX7", "--yes")
    finally:
        journal.close()
    assert "another process is writing this session" in said
    assert tree(two) == before


class Killed(BaseException):
    """Simulated kill, which no error handler catches."""


def killed_at(monkeypatch, n):
    """Raise `Killed` at the n-th removal of a file from now on."""
    left = iter(range(n))
    unlink = Path.unlink

    def until(path, missing_ok=False):
        if not path.name.startswith(".") and next(left, None) is None:
            raise Killed
        unlink(path, missing_ok=missing_ok)

    monkeypatch.setattr(Path, "unlink", until)


@pytest.mark.parametrize("n", range(6))
def test_killed_erasure_finishes_when_repeated(monkeypatch, two, n):
    """The plan on the disk lists files that do not name the participant."""
    tables = two / "report_tables"
    tables.mkdir()
    for path, text in ((two / "report.html", "QX7"), (tables / "a.csv", "QX7\n"), (tables / "b.csv", "mean\n1\n")):
        path.write_text(text)
    with monkeypatch.context() as patched:
        killed_at(patched, n)
        with pytest.raises(Killed):
            erase(two, "QX7")
    assert any("unfinished erasure" in str(defect) for defect in validate(two).defects)
    done = erase(two, "QX7")
    assert (done.erasure.n_sessions, done.erasure.n_files) == (1, 6)
    assert sorted(participants(two)) == ["P01", "P03"]
    assert not tables.exists()
    assert not (two / "report.html").exists()
    assert validate(two).defects == ()
    assert len((two / RECORD).read_text("utf-8").splitlines()) == 1


@pytest.mark.parametrize("name", DATA_SETS)
def test_erase_removes_files_of_earlier_versions(tmp_path, name):
    root = Path(shutil.copytree(RECORDED / name, tmp_path / name))
    codes = participants(root)
    for code in codes:
        erase(root, code)
    assert not [path for part in ("data", "journals", "traces") for path in (root / part).glob("*")]
    assert validate(root).defects == ()
    assert [json.loads(line)["participant"] for line in (root / RECORD).read_text().splitlines()] == codes


def test_erasure_keeps_the_order_of_later_participants(capsys, studied, two, tmp_path):
    whole = shutil.copytree(studied, tmp_path / "whole", ignore=RECORDED_ONLY)
    erase(two, "QX7")
    for root in (two, whole):
        output(capsys, "run", "tutorial", "--participant", "P04", "--rig", "simulated", "--seed", 4, "--out", root)
    assert recorded_of(tree(two), "P04") == recorded_of(tree(whole), "P04") != {}


def test_erasure_keeps_and_lists_inner_data_sets(two, studied):
    within = two / "old"
    shutil.copytree(studied / "journals", within / "journals")
    before = tree(within)
    assert erase(two, "QX7").others == ("old",)
    assert tree(within) == before


def test_link_is_erased_and_its_target_kept(two, tmp_path):
    outside = tmp_path / "kept.csv"
    outside.write_text("QX7")
    link = two / "data" / "participant-QX7_session-2_study-tutorial_data.csv"
    link.symlink_to(outside)
    (two / "elsewhere.csv").symlink_to(outside)
    (two / "folder").symlink_to(tmp_path)
    done = erase(two, "QX7")
    assert not link.is_symlink()
    assert outside.read_text() == "QX7"
    assert done.others == (f"data/{link.name} -> {outside}", "elsewhere.csv", "folder")


def test_forged_plan_erases_no_other_files(two, tmp_path):
    outside = tmp_path / "kept.csv"
    outside.write_text("1")
    (tmp_path / "empty").mkdir()
    names = [f"journals/{Session('P01', 1, 'tutorial').stem}.jsonl", "../kept.csv", "../empty/x.csv", "study.toml"]
    forged = {"participant": "QX7", "begun_utc": "2026-01-01", "version": "0", "n_sessions": 1, "n_files": 1}
    (two / RECORD).write_text(json.dumps(forged | {"files": names}) + "\n")
    before = recorded_of(tree(two), "P01")
    erase(two, "QX7")
    assert recorded_of(tree(two), "P01") == before
    assert all(path.exists() for path in (outside, tmp_path / "empty", two / "study.toml"))


def test_erased_participant_is_not_erased_again(capsys, two):
    done = erase(two, "QX7")
    said = refused(capsys, "erase", two, "--participant", "QX7", "--yes")
    assert f"QX7 was erased at {done.erasure.finished_utc}" in said


@pytest.mark.parametrize(
    ("code", "options", "sentence"),
    [
        ("QX8", ["--yes"], "did you mean 'QX7'?"),
        ("../P01", ["--yes"], "expected a code such as P01"),
        ("qx7", ["--yes"], "found nothing of 'qx7'"),
        ("QX7", [], "expected --yes"),
    ],
)
def test_erase_refuses_unknown_or_unconfirmed_code(capsys, two, code, options, sentence):
    before = tree(two)
    assert sentence in refused(capsys, "erase", two, "--participant", code, *options)
    assert tree(two) == before


def test_erase_refuses_a_folder_without_data_set(capsys, tmp_path):
    assert "expected the folder of a data set" in refused(capsys, "erase", tmp_path, "--participant", "P01", "--yes")


def test_damaged_erasure_record_is_a_defect_and_refused(capsys, two):
    (two / RECORD).write_text("{}\n")
    assert any(RECORD in str(defect) for defect in validate(two).defects)
    assert f"{RECORD}, line 1: found no erasure" in refused(capsys, "erase", two, "--participant", "QX7", "--yes")


@given(code=CODES, others=st.lists(CODES, max_size=3))
def test_erase_keeps_similar_codes(tmp_path_factory, code, others):
    """Codes that begin with another code, such as `1` and `11`, are kept."""
    root = tmp_path_factory.mktemp("codes")
    (root / "dataset_description.json").write_text("{}")
    whose = {each.casefold(): each for each in (*others, f"{code}1", code)}.values()
    for each in whose:
        session = Session(each, 1, "a-study")
        for path in (session.journal(root), session.trials(root)):
            path.parent.mkdir(exist_ok=True)
            path.write_bytes(f"participant\n{each},1\n".encode())
    kept = {name: content for name, content in tree(root).items() if f"participant-{code}_" not in name}
    assert not find(root, code).derived
    with suppress(FileNotFoundError):
        erase(root, code)
    left = tree(root)
    assert left.pop(RECORD)
    assert left == kept


def test_interrupted_erasure_says_how_to_continue(capsys, monkeypatch, two):
    def interrupted(path, missing_ok=False):
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(Path, "unlink", interrupted)
        code, said, _ = call(capsys, "erase", two, "--participant", "QX7", "--yes")
    assert (code, said) == (130, "tactometry: interrupted; run the command again to finish the erasure")
