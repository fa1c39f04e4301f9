"""Files classified by an erasure as own, derived or other."""

import shutil

import pytest
from places import RECORDED

from tactometry.errors import InvalidParameter, SessionInUse
from tactometry.experiments.data_sets import erasing
from tactometry.experiments.data_sets.erasing import erase, find, is_named_for
from tactometry.records.data_set import Session, keys_of, sessions
from tactometry.records.open_journal import Journal

RECORD = "erasures.jsonl"


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


def others(root):
    return list(find(root, "P1").others)


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


def test_a_draft_of_the_participant_goes(root):
    name = f"data/.{stem('P1')}_data.csv.123"
    put(root, name, "P1,1\n")
    assert name in find(root, "P1").own


@pytest.mark.parametrize(
    "name", ["notes.md", "who.csv", "touch_P1.png", f"mine/{stem('P10')}_data.csv", f"data/.{stem('P10')}_data.csv.123"]
)
def test_other_files_stay_and_are_listed(root, name):
    path = put(root, name, "P1")
    assert others(root) == [name]
    erase(root, "P1")
    assert path.exists()


def test_files_of_the_set_are_not_listed(root):
    put(root, "study.toml", "# P1")
    put(root, f".{RECORD}.123", "P1")
    put(root, f"journals/{stem('P10')}_events.tsv", "time_s\tremark\n1.0\tas P1\n")
    assert others(root) == []


@pytest.mark.parametrize(
    ("name", "content"), [("trials.R", "# Reads trials.csv"), ("columns.toml", "# tactometry analyse")]
)
def test_the_data_set_itself_is_no_export(root, name, content):
    put(root, name, content)
    put(root, "setup.png", "")
    put(root, "mine/README.md", "")
    assert find(root, "P1").derived == ()


@pytest.mark.parametrize(("name", "content"), [("trials.R", "x <- 1"), ("columns.toml", "a = 1")])
def test_a_folder_with_a_script_of_somebody_is_no_export(root, name, content):
    put(root, f"mine/{name}", content)
    put(root, "mine/setup.png", "")
    assert find(root, "P1").derived == ()


def test_tables_of_a_report_go_though_none_names_anybody(root):
    put(root, "report.html", "")
    put(root, "report_tables/means.csv", "1")
    assert find(root, "P1").derived == ("report.html", "report_tables/means.csv")


@pytest.mark.parametrize("key", ["participant", "subject", "sub"])
@pytest.mark.parametrize("name", ["{}-P1", "a/{}-P1/x.tsv", "data/.{}-P1.csv", "ses-1_{}-P1_x.tsv"])
def test_file_names_with_keys_belong_to_the_participant(key, name):
    assert is_named_for(name.format(key), "P1")
    assert not is_named_for(name.format(key), "P")


def test_the_folders_of_a_data_set_stay_when_they_are_empty(root):
    (root / "traces").mkdir()
    put(root, f"traces/{stem('P1')}_x.tsv", "")
    put(root, "exports/r/trials.R", "# Reads trials.csv")
    put(root, "exports/r/trials.csv", "P1 P10")
    for code in ("P1", "P10"):
        erase(root, code)
    assert sorted(path.name for path in root.iterdir()) == [
        "data",
        "dataset_description.json",
        RECORD,
        "journals",
        "traces",
    ]


def test_leftovers_of_interruptions_are_no_session(root):
    put(root, f"journals/{stem('P1')}_interruptions.jsonl", "")
    looked, done = find(root, "P1"), erase(root, "P1")
    assert (looked.n_sessions, done.n_sessions, done.erasure.n_sessions, len(done.own)) == (1, 1, 1, 3)


def test_said_again_it_tells_of_the_sessions_that_it_began_with(monkeypatch, root):
    def failed(*_):
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(erasing, "_remove_empty", failed)
        with pytest.raises(KeyboardInterrupt):
            erase(root, "P1")
    assert erase(root, "P1").n_sessions == 1


def test_a_journal_under_another_name_is_enough(root):
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
