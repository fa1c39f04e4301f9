"""Data sets with old, renamed, orphaned or duplicate files."""

import csv
import json
import shutil
from functools import partial

import pytest
from command_line import call
from copies import at_once
from places import RECORDED
from tutorial_session import EXPERIMENT, STUDY, TOML, journal_of, live

from tactometry.errors import InvalidFile, InvalidParameter
from tactometry.experiments.data_sets.validation import validate
from tactometry.experiments.sessions.recording import Who
from tactometry.files.durable import drafts
from tactometry.records.data_set import disagreement, prepare


def trials_of(root):
    return next((root / "data").glob("*_data.csv"))


def shortened(journal, n_lines):
    """Truncate a journal to its first `n_lines` lines."""
    journal.write_bytes(b"".join(journal.read_bytes().splitlines(keepends=True)[:n_lines]))


def kept_rows(root):
    path = next((root / "journals").glob("*_interruptions.jsonl"))
    return [row for line in path.read_text().splitlines() for row in json.loads(line).get("rows", [])]


def resume(root):
    return ("run", root / "study.toml", "--participant", "P01", "--rig", "simulated", "--out", root, "--resume")


# --- a journal that is older than the trials file


def test_resume_keeps_rows_missing_from_an_older_journal(lived, capsys):
    rows = trials_of(lived).read_text().splitlines()[1:]
    shortened(journal_of(lived), 30)
    status, said, _ = call(capsys, *resume(lived))
    assert status == 0
    kept = kept_rows(lived)
    assert kept
    assert rows[-len(kept) :] == kept
    assert f"had {len(kept)} rows missing from the journal of {len(rows) - len(kept)} trials: they are kept" in said
    assert "restore the newer copy" in said


def test_resume_keeps_rows_edited_by_hand(lived, capsys):
    path = trials_of(lived)
    path.write_bytes(path.read_bytes().replace(b",1,1,", b",1,0,", 1))
    status, said, _ = call(capsys, *resume(lived))
    assert (status, len(kept_rows(lived))) == (0, 1)
    assert "had 1 row missing from the journal" in said


def test_resume_rewrites_torn_trials_file_without_a_message(lived, capsys):
    path, whole = trials_of(lived), trials_of(lived).read_bytes()
    for left in (whole[:-20], whole[:-20] + bytes(64), b""):
        path.write_bytes(left)
        assert call(capsys, *resume(lived))[:2] == (0, "")
        assert path.read_bytes() == whole


# --- a trials file that lacks rows


@pytest.mark.parametrize("n", [1, 2])
def test_missing_last_rows_are_reported_and_rebuilt(lived, capsys, n):
    path, whole = trials_of(lived), trials_of(lived).read_bytes()
    path.write_bytes(b"".join(whole.splitlines(keepends=True)[:-n]))
    lacks = f"lacks the last {n} row{'s' * (n > 1)} of the journal, expected all of them; rewrite it with tactometry"
    status, said, _ = call(capsys, "replay", lived)
    assert status == 1
    assert lacks in said
    status, _, out = call(capsys, "validate", lived)
    assert status == 1
    assert lacks in out
    status, _, out = call(capsys, "rebuild", lived)
    assert status == 0
    assert "repaired" in out
    assert path.read_bytes() == whole
    assert call(capsys, "rebuild", lived)[2].strip().endswith("trials")


def test_zero_bytes_after_last_row_are_reported():
    row, how = disagreement(b"a\n1\n\0\0", b"a\n1\n")
    assert (row, how.partition(";")[0]) == (3, "found zero bytes after the last row, expected none")


def test_rebuild_refuses_folder_without_journal(tmp_path, capsys):
    status, said, _ = call(capsys, "rebuild", tmp_path)
    assert status == 2
    assert "found no journal, expected" in said


def test_rebuild_leaves_complete_data_set_unchanged(lived, capsys):
    before = {path: path.read_bytes() for path in lived.rglob("*") if path.is_file()}
    assert call(capsys, "rebuild", journal_of(lived))[0] == 0
    assert before == {path: path.read_bytes() for path in lived.rglob("*") if path.is_file()}


# --- names and heads


def copied_as(root, code):
    for path in [*(root / "data").iterdir(), *(root / "journals").iterdir()]:
        shutil.copy(path, path.with_name(path.name.replace("participant-P01", f"participant-{code}")))


ROW, CODE = "P99_session-1_study-tutorial_data.csv, row 2", "column 'participant': found 'P01', expected 'P99'"
HEAD = "found session 1 of P01 (tutorial), expected the session in"


@pytest.mark.parametrize(
    ("command", "status", "messages"),
    [
        ("validate", 1, (f"P99_session-1_study-tutorial.jsonl, row 1: {HEAD}", f"{ROW}: {CODE}")),
        ("analyse", 2, (ROW, f"{CODE} as in the file name; remove the file")),
        ("rebuild", 2, (f"{HEAD} the file name; remove the copy",)),
        ("replay", 2, (f"{HEAD} the file name; remove the copy",)),
    ],
)
def test_commands_refuse_a_copy_under_another_name(lived, capsys, command, status, messages):
    copied_as(lived, "P99")
    found, said, out = call(capsys, command, lived)
    assert found == status
    assert all(words in said + out for words in messages)


def test_copy_under_another_name_is_not_resumed(lived):
    copied_as(lived, "P99")
    with pytest.raises(
        InvalidFile, match=r"P99.*jsonl, line 1: found session 1 of P01 \(tutorial\), expected the session in"
    ):
        live(lived, Who("P99", number=1), resume=True)


@pytest.mark.parametrize(("column", "value"), [("session", "2"), ("study", "tutorials")])
def test_validate_reports_rows_of_another_session_or_study(lived, column, value):
    with trials_of(lived).open(newline="") as text:
        rows = list(csv.DictReader(text))
    rows[3][column] = value
    with trials_of(lived).open("w", newline="") as text:
        writer = csv.DictWriter(text, rows[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    assert any(f"row 5: column {column!r}: found {value!r}" in str(defect) for defect in validate(lived).defects)


def test_resume_refuses_journal_of_another_study(lived, tmp_path):
    from tactometry.experiments.sessions.recording import record, simulated

    other = TOML.replace(b"trial_s = 5.0", b"trial_s = 6.0")
    (lived / "study.toml").write_bytes(other)
    with pytest.raises(InvalidFile, match="line 1: found the digest of another study"):
        record(EXPERIMENT, other, lived, Who("P01"), simulated(EXPERIMENT, Who("P01")), resume=True)


def test_participant_codes_must_differ_beyond_case(lived):
    with pytest.raises(InvalidParameter, match="participant: found 'p01' next to 'P01', expected codes that differ in"):
        live(lived, Who("p01", seed=1))
    assert validate(lived).notes == ()
    for path in [*(lived / "data").iterdir(), *(lived / "journals").iterdir()]:
        shutil.copy(path, path.with_name(path.name.replace("P01", "p01")))
    assert any("P01 and p01 differ only in capital letters" in note for note in validate(lived).notes)


def test_only_one_of_concurrent_studies_gets_the_folder(tmp_path):
    """Of four concurrent studies in a new folder, one continues."""
    designs = [EXPERIMENT.design(TOML + b"# %d\n" % n) for n in range(4)]

    def prepared(root, design):
        try:
            prepare(root, design)
        except InvalidFile:
            return 2
        return 0

    for n in range(10):
        assert sorted(at_once(partial(prepared, tmp_path / str(n), design) for design in designs)) == [0, 2, 2, 2]


# --- files that killed processes leave


def test_rebuild_removes_drafts_and_keeps_their_rows(lived, capsys):
    orphan = trials_of(lived).with_name(f".{trials_of(lived).name}.4711")
    orphan.write_bytes(trials_of(lived).read_bytes() + b"P01,1,tutorial,9,99\n")
    (lived / "journals" / f".{journal_of(lived).name}.4711").write_bytes(b"{")
    (lived / ".study.toml.4711").write_bytes(b"name")
    report = validate(lived)
    assert report.defects == ()
    assert [note.partition(": ")[2] for note in report.notes] == [
        "a temporary file left by an interruption; remove it",
        *["a temporary file left by an interruption; tactometry rebuild removes it"] * 2,
    ]
    assert call(capsys, "rebuild", lived)[0] == 0
    assert kept_rows(lived) == ["P01,1,tutorial,9,99"]
    assert drafts(lived / "data") == drafts(lived / "journals") == []


def test_rebuild_keeps_drafts_of_other_sessions(lived, capsys):
    other = lived / "data" / ".participant-P02_session-1_study-tutorial_data.csv.4711"
    other.write_bytes(b"")
    assert call(capsys, "rebuild", lived)[0] == 0
    assert other.exists()
    assert STUDY.name == "tutorial"


def test_validate_refuses_trials_file_without_rows(lived, capsys):
    path = trials_of(lived)
    path.write_bytes(path.read_bytes().partition(b"\n")[0] + b"\n")
    status, _, out = call(capsys, "validate", path)
    assert status == 1
    assert "found only a header, expected a row for each trial" in out


def test_validate_reports_simulated_participants_mixed_with_people(lived, capsys):
    """Combined by hand, as the commands refuse to."""
    for path in (RECORDED / "console").rglob("*P02*"):
        shutil.copy(path, lived / path.parent.name / path.name)
    status, _, out = call(capsys, "validate", lived)
    assert status == 1
    assert "journals: found simulated participants (P01, ...) next to people (P02, ...), expected only one kind" in out


def test_hidden_system_files_are_ignored(lived, capsys):
    (lived / "data" / f"._{trials_of(lived).name}").write_bytes(b"\0\5\26\7")
    (lived / "journals" / f"._{journal_of(lived).name}").write_bytes(b"\0\5\26\7")
    for command in ("validate", "replay", "analyse"):
        assert call(capsys, command, lived)[0] == 0
