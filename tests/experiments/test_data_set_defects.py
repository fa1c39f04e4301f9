"""Lost or exchanged lines, files, rigs and values found in data sets."""

import json

import pytest
from command_line import call
from tutorial_session import journal_of, live

from tactometry.errors import InvalidFile, InvalidParameter
from tactometry.experiments.data_sets.session_files import positions_defects
from tactometry.experiments.data_sets.validation import validate
from tactometry.provenance import digest_of
from tactometry.records.data_set import Session
from tactometry.records.journal import read
from tactometry.records.open_session import POSITIONS_HEADER
from tactometry.trials.row_rules import Defect, defects, merge_alike
from tactometry.trials.trial import Trial


def found(root):
    return [str(defect) for defect in validate(root).defects]


@pytest.mark.parametrize("missing", [2, 9, 40])
def test_missing_or_exchanged_line_is_named(lived, missing):
    lines = journal_of(lived).read_bytes().splitlines(keepends=True)
    journal_of(lived).write_bytes(b"".join(lines[: missing - 1] + lines[missing:]))
    with pytest.raises(InvalidFile, match=f"line {missing}: the line is damaged, or an earlier line is missing"):
        read(journal_of(lived))
    assert any(f"row {missing}: the line is damaged, or an earlier line is missing" in text for text in found(lived))
    lines[missing - 1], lines[missing] = lines[missing], lines[missing - 1]
    journal_of(lived).write_bytes(b"".join(lines))
    with pytest.raises(InvalidFile, match=f"line {missing}: the line is damaged"):
        read(journal_of(lived))


def test_columns_without_their_description_are_a_defect(lived):
    sidecar = next((lived / "data").glob("*.json"))
    content = sidecar.read_text()
    sidecar.unlink()
    assert any("found no such file, expected the description of every column" in text for text in found(lived))
    sidecar.write_text("[")
    assert any("found no JSON" in text for text in found(lived))
    sidecar.write_text(content.replace('"latency_s"', '"late_s"'))
    assert any("found no description of the column 'latency_s'" in text for text in found(lived))


def test_folder_among_journals_is_ignored(lived):
    (lived / "journals" / "x.jsonl").mkdir()
    assert found(lived) == []


def test_file_at_the_data_set_path_is_refused(tmp_path):
    (tmp_path / "d").write_text("mine")
    with pytest.raises(InvalidFile, match="found a file, expected a folder for the data set"):
        live(tmp_path / "d")
    assert (tmp_path / "d").read_text() == "mine"


@pytest.mark.parametrize("code", ["a" * 33, "P 1", "é1", "", "../x"])
def test_participant_code_has_1_to_32_letters(code):
    Session("a" * 32, 1, "x")
    with pytest.raises(InvalidParameter, match="found"):
        Session(code, 1, "x")


@pytest.mark.parametrize(
    ("column", "value", "expected"),
    [
        ("onset_s", "-0.1", "a number, at least 0"),
        ("force_mean_n", "-1", "a number, at least 0"),
        ("force_in_band", "1.01", "a number from 0 to 1"),
        ("force_in_band", "-0.01", "a number from 0 to 1"),
        ("level", "nan", "a number"),
        ("trial", "0", "a whole number from 1"),
        ("valid", "2", "1, 0 or nothing"),
        ("response", "2", "1, 0 or nothing"),
        ("timestamp_utc", "yesterday", "a time in ISO 8601"),
    ],
)
def test_impossible_cell_is_a_defect(whole, column, value, expected):
    file = next((whole / "data").glob("*.csv"))
    assert list(defects(file.read_bytes(), file.name)) == []
    header, first, *rest = file.read_text().splitlines()
    cells = first.split(",")
    cells[header.split(",").index(column)] = value
    (defect,) = defects("\n".join([header, ",".join(cells), *rest]).encode(), file.name)
    assert str(defect) == f"{file.name}, row 2: column {column!r}: found {value!r}, expected {expected}"


@pytest.mark.parametrize("task", ["yes_no", "comparison", "same_different"])
def test_two_option_answers_are_1_or_0(whole, task):
    file = next((whole / "data").glob("*.csv"))
    header, first, *_ = file.read_text().splitlines()
    cells = dict(zip(header.split(","), first.split(","), strict=True)) | {"task": task, "response": "3"}
    (defect,) = defects(f"{header}\n{','.join(cells.values())}".encode(), file.name)
    assert "column 'response': found '3', expected 1, 0 or nothing" in str(defect)


def test_trials_file_is_synced_when_a_sitting_ends(tmp_path, synced):
    recorded = live(tmp_path)
    assert recorded.trials in synced


def plain(n):
    rows = [f"P1,{level},yes_no,{'y' if level % 2 else 'n'}" for level in range(n)]
    return "\n".join(["participant,level,task,response", *rows, ""])


def test_alike_defects_are_one_sentence_with_their_number(tmp_path, capsys):
    (tmp_path / "plain.csv").write_text(plain(737))
    status, _, out = call(capsys, "validate", tmp_path / "plain.csv")
    missing, answers, summary = out.splitlines()
    assert status == 1
    assert missing.startswith("plain.csv, row 1: found no columns 'session', 'study', 'block', ")
    assert answers == (
        "plain.csv, row 2 and 736 more (3, 4, 5, 6, ...): column 'response': found 'n', expected 1, 0 or nothing"
    )
    assert "738 defects" in summary
    _, _, out = call(capsys, "validate", tmp_path / "plain.csv", "--json")
    assert [(each["row"], each["n_rows"]) for each in json.loads(out)["defects"]] == [(1, 1), (2, 737)]


def test_defects_of_different_kinds_stay_apart():
    one, other = Defect("a.csv", 2, "x", "level"), Defect("a.csv", 3, "y", "task")
    alike = [Defect("a.csv", n, "x", "level") for n in range(4, 10)]
    apart = [Defect("b.csv", 2, "x", "level"), Defect("a.csv", 1, "x"), Defect("a.csv", 1, "x")]
    found = merge_alike([one, other, *alike, *apart])
    assert [str(each) for each in found] == [
        "a.csv, row 2 and 6 more (4, 5, 6, 7, ...): x",
        "a.csv, row 3: y",
        "b.csv, row 2: x",
        "a.csv, row 1: x",
        "a.csv, row 1: x",
    ]


@pytest.mark.parametrize(("path", "n_defects"), [(b"", 0), (b"0.001000\t0.050000000\n", 1)])
def test_only_an_empty_path_has_no_rows(tmp_path, path, n_defects):
    """The path of a touch is empty if the position sensor was silent."""
    (tmp_path / "j_positions.tsv").write_bytes(POSITIONS_HEADER)
    touch = Trial(1, 1, {}, "staircase", 1.0, "V", "yes_no", None, valid=False, positions_digest=digest_of(path))
    assert len(list(positions_defects(tmp_path / "j.jsonl", [touch]))) == n_defects
