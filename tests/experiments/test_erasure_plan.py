"""Files of an erasure: own, derived and other ones, and links."""

import shutil

import pytest
from command_line import refused
from places import RECORDED
from tables import contents

from tactometry.errors import InvalidFile, InvalidParameter, SessionInUse
from tactometry.experiments.data_sets import erasing
from tactometry.experiments.data_sets.erasing import erase, find, is_named_for
from tactometry.records.data_set import Session, keys_of, participants, sessions
from tactometry.records.open_journal import Journal

RECORD = "erasures.jsonl"
OPTIONS = ("--participant", "P77", "--rig", "simulated", "--seed", "1", "--out")
SIMULATED = ("--participants", "1", "--seed", "1", "--resume", "--out")
DATA_SET = next(path for path in sorted(RECORDED.iterdir()) if path.is_dir())


@pytest.fixture
def root(tmp_path):
    """Return a data set with two participants whose codes begin alike."""
    root = tmp_path / "d"
    put(root, "dataset_description.json", "{}")
    for code in ("P1", "P10"):
        put(root, f"journals/{stem(code)}.jsonl", "")
        put(root, f"data/{stem(code)}_data.csv", f"participant,level\n{code},1\n")
    return root


def stem(code):
    return Session(code, 1, "study").stem


def put(root, name, content):
    (root / name).parent.mkdir(parents=True, exist_ok=True)
    (root / name).write_text(content, "utf-8")
    return root / name


def test_journals_go_last(monkeypatch, root):
    put(root, "report.html", "")
    put(root, "report_tables/means.csv", "1")
    names, unlink = [], erasing.Path.unlink

    def noted(path, missing_ok=False):
        names.append(path.name)
        unlink(path, missing_ok=missing_ok)

    monkeypatch.setattr(erasing.Path, "unlink", noted)
    erase(root, "P1")
    gone = [name for name in names if not name.startswith(".")]
    assert gone[:4] == ["report.html", "means.csv", f"{stem('P1')}_data.csv", f"{stem('P1')}.jsonl"]


def test_erasure_includes_drafts_of_the_participant(root):
    name = f"data/.{stem('P1')}_data.csv.123"
    put(root, name, "P1,1\n")
    assert name in find(root, "P1").own


@pytest.mark.parametrize(
    ("name", "listed"),
    [
        *((name, name) for name in ("notes.md", "who.csv", "touch_P1.png")),
        (f"mine/{stem('P10')}_data.csv", f"mine/{stem('P10')}_data.csv"),
        (f"data/.{stem('P10')}_data.csv.123", f"data/.{stem('P10')}_data.csv.123"),
        ("data/.checkpoints/a.csv", "data/.checkpoints"),
    ],
)
def test_erasure_keeps_and_lists_other_files(root, name, listed):
    path = put(root, name, "P1")
    assert erase(root, "P1").others == (listed,)
    assert path.exists()


def test_erasure_does_not_list_data_set_files(root):
    put(root, "study.toml", "# P1")
    draft = put(root, f".{RECORD}.123", "P1")
    put(root, f"journals/{stem('P10')}_events.tsv", "time_s\tremark\n1.0\tas P1\n")
    assert erase(root, "P1").others == ()
    assert not draft.exists()


@pytest.mark.parametrize(
    ("folder", "name", "content"),
    [
        ("", "trials.R", "# Reads trials.csv"),
        ("", "columns.toml", "# tactometry analyse"),
        ("mine/", "trials.R", "x <- 1"),
        ("mine/", "columns.toml", "a = 1"),
    ],
)
def test_data_set_and_user_folders_are_no_exports(root, folder, name, content):
    put(root, f"{folder}{name}", content)
    put(root, f"{folder}setup.png", "")
    put(root, "mine/README.md", "")
    assert find(root, "P1").derived == ()


@pytest.mark.parametrize("key", ["participant", "subject", "sub"])
@pytest.mark.parametrize("name", ["{}-P1", "a/{}-P1/x.tsv", "data/.{}-P1.csv", "ses-1_{}-P1_x.tsv"])
def test_file_names_with_keys_belong_to_the_participant(key, name):
    assert is_named_for(name.format(key), "P1")
    assert not is_named_for(name.format(key), "P")


def test_erasure_keeps_empty_standard_folders(root):
    (root / "traces").mkdir()
    put(root, f"traces/{stem('P1')}_x.tsv", "")
    put(root, "exports/r/trials.R", "# Reads trials.csv")
    put(root, "exports/r/trials.csv", "P1 P10")
    for code in ("P1", "P10"):
        erase(root, code)
    assert {path.name for path in root.iterdir()} == {"data", "dataset_description.json", RECORD, "journals", "traces"}


def test_repeated_erasure_reports_the_original_sessions(monkeypatch, root):
    """Files of interruptions do not count as sessions."""
    put(root, f"journals/{stem('P1')}_interruptions.jsonl", "")
    looked = find(root, "P1")

    def failed(*_):
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(erasing, "_remove_empty", failed)
        with pytest.raises(KeyboardInterrupt):
            erase(root, "P1")
    assert (looked.n_sessions, erase(root, "P1").n_sessions, len(looked.own)) == (1, 1, 3)


def test_renamed_journal_alone_identifies_a_participant(root):
    recorded = next(iter(sessions(next(RECORDED.iterdir()))))
    whose = keys_of(recorded.stem)["participant"]
    shutil.copy(recorded, root / "journals" / "copy.jsonl")
    assert find(root, whose).own == ("journals/copy.jsonl",)


def test_participant_with_only_a_table_is_known(root):
    (root / f"journals/{stem('P10')}.jsonl").unlink()
    with pytest.raises(InvalidParameter, match="expected one of P1, P10"):
        find(root, "P2")


def test_session_begun_meanwhile_is_not_erased(monkeypatch, root):
    """The session begins between the search for locks and that for files."""
    looks, begun = erasing._plan, []

    def begins(*asked):
        found = looks(*asked)
        begun.append(Journal(Session("P1", len(begun) + 2, "study").journal(root), resume=False))
        return found

    monkeypatch.setattr(erasing, "_plan", begins)
    with pytest.raises(SessionInUse, match="another process is writing this session"):
        erase(root, "P1")
    for journal in begun:
        journal.close()
    assert (root / f"data/{stem('P1')}_data.csv").exists()
    assert not (root / RECORD).exists()


# --- links, whose targets stay


@pytest.mark.parametrize("part", ["data", "journals"])
def test_erasure_refuses_linked_data_set_folders(tmp_path, part):
    root = with_link(tmp_path, DATA_SET, part)
    before = sorted(tmp_path.rglob("*"))
    with pytest.raises(InvalidFile, match=f"{part}: found a link, expected the folder itself"):
        erase(root, participants(root)[0])
    assert sorted(tmp_path.rglob("*")) == before


def with_link(tmp_path, data_set, part):
    root, elsewhere = shutil.copytree(data_set, tmp_path / "d"), tmp_path / "elsewhere"
    (root / part).mkdir(exist_ok=True)
    (root / part).rename(elsewhere)
    (root / part).symlink_to(elsewhere)
    return root


@pytest.mark.parametrize("part", ["data", "journals", "traces"])
@pytest.mark.parametrize("words", [("rebuild",), ("run", "tutorial", *OPTIONS), ("simulate", "tutorial", *SIMULATED)])
def test_linked_folder_is_not_written_through(tmp_path, capsys, part, words):
    root = with_link(tmp_path, RECORDED / "format-2-simulated", part)
    before = contents(tmp_path)
    said = refused(capsys, *words, root)
    assert f"{part}: found a link, expected the folder itself" in said
    assert contents(tmp_path) == before


def test_linked_interruptions_are_not_written_through(tmp_path, capsys):
    root = shutil.copytree(RECORDED / "format-2-simulated", tmp_path / "d")
    journal, outside = sessions(root)[0], tmp_path / "outside"
    outside.write_text("mine")
    journal.with_name(f"{journal.stem}_interruptions.jsonl").symlink_to(outside)
    with journal.open("ab") as file:
        file.write(b"torn")
    assert "_interruptions.jsonl: found a link, expected a file" in refused(capsys, "rebuild", root)
    assert outside.read_text() == "mine"


def test_broken_link_in_place_of_folder_is_refused(tmp_path, capsys):
    root = shutil.copytree(RECORDED / "format-2-simulated", tmp_path / "d")
    shutil.rmtree(root / "data")
    (root / "data").symlink_to(tmp_path / "gone")
    assert "data: found a link, expected the folder itself" in refused(capsys, "rebuild", root)
    assert not (tmp_path / "gone").exists()


@pytest.mark.parametrize("folder", ["data", "journals"])
@pytest.mark.parametrize("end", ["missing", "absent/missing", None], ids=["missing", "absent folder", "itself"])
def test_broken_link_is_erased_and_its_target_listed(tmp_path, folder, end):
    """The target may be on a disk that is not connected."""
    root = shutil.copytree(DATA_SET, tmp_path / "d")
    code = participants(root)[0]
    link = Session(code, 9, "link").journal(root) if folder == "journals" else Session(code, 9, "link").trials(root)
    target = link if end is None else tmp_path / end
    link.symlink_to(target)
    assert erase(root, code).others == (f"{folder}/{link.name} -> {target}",)
    assert not link.is_symlink()
    assert not target.exists()
