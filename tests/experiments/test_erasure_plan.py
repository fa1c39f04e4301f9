"""What an erasure takes for a participant's own, for derived and for that of others, in data sets of a few lines."""

import shutil

import pytest
from places import RECORDED

from tactometry.errors import InvalidParameter, SessionInUse
from tactometry.experiments.data_sets import erasing
from tactometry.experiments.data_sets.erasing import erase, find
from tactometry.experiments.data_sets.erasure_plan import is_named_for
from tactometry.records.data_set import Session, keys_of, sessions
from tactometry.records.open_journal import Journal

RECORD = "erasures.jsonl"


@pytest.fixture
def root(tmp_path):
    """Two participants, one of whom has a code that begins as the other's does."""
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


def told(root):
    return [(left.file, left.why, left.names) for left in find(root, "P1").left]


def test_journals_go_last(monkeypatch, root):
    put(root, "who.csv", "P1")
    names, unlink = [], erasing.Path.unlink

    def noted(path, missing_ok=False):
        names.append(path.name)
        unlink(path, missing_ok=missing_ok)

    monkeypatch.setattr(erasing.Path, "unlink", noted)
    erase(root, "P1")
    gone = [name for name in names if not name.startswith(".")]
    assert gone[:3] == ["who.csv", f"{stem('P1')}_data.csv", f"{stem('P1')}.jsonl"]


@pytest.mark.parametrize("before", [*"nrt"])
def test_a_code_behind_an_escape_of_json_is_found(root, before):
    put(root, "said.json", rf'{{"text": "ill\{before}P1"}}')
    assert find(root, "P1").derived == ("said.json",)


@pytest.mark.parametrize("word", ["P10", "XP1", "nP1", "P1a"])
def test_a_word_that_holds_the_code_is_another(root, word):
    put(root, "said.json", f'{{"text": "{word}"}}')
    put(root, "notes.md", word)
    assert (find(root, "P1").derived, told(root)) == ((), [])


def test_a_draft_of_the_record_is_not_told_as_it_goes(root):
    put(root, f".{RECORD}.123", "P1")
    assert told(root) == []


def test_a_draft_of_another_that_names_the_code_is_told(root):
    name = f"data/.{stem('P10')}_data.csv.123"
    put(root, name, "P1,1\n")
    assert told(root) == [(name, "names P1 in line 1; edit or remove it", True)]


def test_a_draft_of_the_participant_goes(root):
    name = f"data/.{stem('P1')}_data.csv.123"
    put(root, name, "P1,1\n")
    assert name in find(root, "P1").own


@pytest.mark.parametrize("folder", ["mine", "old/data", "."])
def test_the_table_of_another_is_theirs_in_the_folders_of_the_set_alone(root, folder):
    path = put(root, f"{folder}/{stem('P10')}_data.csv", "P1,1\n")
    assert find(root, "P1").derived == (path.relative_to(root).as_posix(),)


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


def test_a_cell_of_another_that_is_the_code_is_no_row_of_the_participant(root):
    put(root, f"data/{stem('P10')}_data.csv", "participant,level\nP10,1\nP10,P1\n")
    assert told(root) == []


@pytest.mark.parametrize("line", ['{"event":"stimulus","name":"P10"}', '{"request":"choose","answer":"P1"}'])
def test_an_answer_that_is_the_code_is_no_remark(root, line):
    put(root, f"journals/{stem('P10')}.jsonl", line)
    assert told(root) == []


def test_a_remark_in_the_events_of_another_is_told(root):
    name = f"journals/{stem('P10')}_events.tsv"
    put(root, name, "time_s\tremark\n1.0\tas P1\n")
    assert told(root) == [(name, "names P1 in line 2", True)]


def test_the_record_of_another_erasure_is_not_told(root):
    erasure = '{"participant":"P2","begun_utc":"1","version":"P1","n_sessions":1,"n_files":1,"finished_utc":"2"}'
    put(root, RECORD, f"{erasure}\n")
    assert told(root) == []


def test_a_figure_whose_name_holds_the_code_is_derived(root):
    put(root, "touch_P1.png", "")
    put(root, "touch_P10.png", "")
    assert find(root, "P1").derived == ("touch_P1.png",)


def test_an_end_of_a_name_in_capitals_is_known(root):
    put(root, "WHO.CSV", "P1")
    assert find(root, "P1").derived == ("WHO.CSV",)


def test_tables_of_a_report_go_though_none_names_anybody(root):
    put(root, "report.html", "")
    put(root, "report_tables/means.csv", "1")
    assert find(root, "P1").derived == ("report.html", "report_tables/means.csv")


@pytest.mark.parametrize("code", ["P1", "p1"])
def test_a_note_whose_name_holds_the_code_is_told(root, code):
    put(root, f"notes on {code}.md", "ill")
    assert told(root) == [(f"notes on {code}.md", f"is named for {code}; look at it", True)]


def test_a_note_in_small_letters_is_told_and_left(root):
    note = put(root, "notes.md", "first\np10 and xp1\nand p1, who was ill\n")
    assert told(root) == [("notes.md", "names p1 in line 3; edit or remove it", True)]
    assert not erase(root, "P1").is_free
    assert note.exists()


def test_a_remark_in_small_letters_is_told(root):
    name = f"journals/{stem('P10')}.jsonl"
    put(root, name, '{"event":"remark","text":"as p1"}')
    assert told(root) == [(name, "names p1 in line 1", True)]


@pytest.mark.parametrize(("code", "word"), [("A", "a"), ("UM", "um")])
def test_a_code_of_letters_that_are_a_word_is_told_as_it_is_alone(root, code, word):
    put(root, f"journals/{stem(code)}.jsonl", "")
    put(root, "notes.md", f"{word} word\n")
    assert find(root, code).left == ()
    put(root, "notes.md", f"{code} word\n")
    assert [left.file for left in find(root, code).left] == ["notes.md"]


@pytest.mark.parametrize("key", ["participant", "subject", "sub"])
@pytest.mark.parametrize("name", ["{}-P1", "a/{}-P1/x.tsv", "data/.{}-P1.csv", "ses-1_{}-P1_x.tsv"])
def test_a_name_with_a_key_of_psych_ds_or_bids_is_of_the_participant(key, name):
    assert is_named_for(name.format(key), "P1")
    assert not is_named_for(name.format(key), "P")


def test_the_folders_of_a_data_set_stay_when_they_are_empty(root):
    (root / "traces").mkdir()
    put(root, f"traces/{stem('P1')}_x.tsv", "")
    put(root, "exports/r/who.csv", "P1 P10")
    for code in ("P1", "P10"):
        erase(root, code)
    assert sorted(path.name for path in root.iterdir()) == [
        "data",
        "dataset_description.json",
        RECORD,
        "journals",
        "traces",
    ]


def test_what_interruptions_left_is_no_session(root):
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


def test_who_has_a_table_alone_is_known(root):
    (root / f"journals/{stem('P10')}.jsonl").unlink()
    with pytest.raises(InvalidParameter, match="expected one of P1, P10"):
        find(root, "P2")


def test_a_session_that_begins_meanwhile_is_not_erased(monkeypatch, root):
    """Between the first look, which finds what to lock, and the second, by which files go."""
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
