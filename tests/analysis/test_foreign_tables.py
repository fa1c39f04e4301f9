"""Tests of tables of PsychoPy and jsPsych and of their messages."""

import json
import re
import subprocess
import sys
import tracemalloc
from importlib.util import find_spec
from pathlib import Path

import pytest
from command_line import call, output, refused
from hypothesis import example, given, strategies as st
from patience import LONGEST_PROGRAM_S
from places import FOREIGN

from tactometry.analysis.reading.column_map import ColumnMap
from tactometry.analysis.reading.text_table import json_cells
from tactometry.analysis.reading.trials import read_trials, used_rows
from tactometry.errors import InvalidFile

PSYCHOPY = ColumnMap(
    columns={"level": "contrast", "response": "key_resp.keys", "latency_s": "key_resp.rt"},
    constants={"task": "yes_no"},
    values={"response": {"y": 1, "n": 0}},
    missing=("None",),
)
JSPSYCH = ColumnMap(
    columns={"participant": "subject", "level": "amplitude", "target": "interval", "latency_s": "rt"},
    constants={"task": "forced_choice", "level_unit": "dB"},
    values={"response": {"f": 1, "j": 2}, "correct": {"true": 1, "false": 0}},
    keep={"trial_type": ("html-keyboard-response",)},
    units={"latency_s": "ms"},
    missing=("null",),
)


def test_psychopy_file_is_read_unchanged():
    trials = read_trials(FOREIGN / "psychopy_2026.2.5.csv", within=["cond"], column_map=PSYCHOPY)
    assert trials.rows["level"].tolist() == [0.1, 0.2, 0.4] * 4
    assert trials.rows["response"].tolist() == ["1", "0", ""] * 4
    assert trials.rows["row"].tolist() == list(range(3, 15))
    assert set(trials.rows["participant"]) == {"7"}
    assert used_rows(trials)["latency_s"].tolist() == pytest.approx([0.5, 0.51, 0.53, 0.54, 0.56, 0.57, 0.59, 0.6])
    assert trials.notes == (
        "2 rows were left out: they have no level, answer or item, like rows that other programs write for routines "
        "(the first: psychopy_2026.2.5.csv, row 2)",
        "4 rows without an answer were left out (the first: psychopy_2026.2.5.csv, row 5)",
    )


def test_psychopy_staircase_file_is_read_unchanged():
    columns = {"level": "stair.intensity", "response": "stair.response"}
    found = read_trials(
        FOREIGN / "psychopy_2026.2.5_stairs.csv", within=["rt"], column_map=ColumnMap(columns, {"task": "yes_no"})
    )
    assert len(used_rows(found)) == 15
    assert found.notes == ()


@pytest.mark.soak
@pytest.mark.skipif(find_spec("psychopy") is None, reason="no psychopy: extra window")
@pytest.mark.parametrize("delimiter", ["comma", "tab", "semicolon"])
def test_output_of_installed_psychopy_is_read(tmp_path, delimiter):
    name = "7.tsv" if delimiter == "tab" else "7.csv"
    script = f"""
import warnings
warnings.simplefilter("ignore")
from psychopy import data
exp = data.ExperimentHandler(extraInfo=dict(participant="7", session="001"), savePickle=False, saveWideText=False)
exp.addData("welcome.started", 0.5)
exp.nextEntry()
loop = data.TrialHandler(trialList=[dict(contrast=c, cond="a") for c in (0.1, 0.2)], nReps=1, method="sequential")
exp.addLoop(loop)
for n, trial in enumerate(loop):
    loop.addData("key_resp.keys", "yn"[n])
    loop.addData("key_resp.rt", 0.5)
    exp.nextEntry()
exp.saveAsWideText({name!r}, delim={delimiter!r})
exp.abort()
"""
    subprocess.run(
        [sys.executable, "-c", script], cwd=tmp_path, check=True, capture_output=True, timeout=LONGEST_PROGRAM_S
    )
    separator = {"comma": "", "tab": "", "semicolon": ";"}[delimiter]
    own = ColumnMap(PSYCHOPY.columns, PSYCHOPY.constants, PSYCHOPY.values, separator=separator)
    assert read_trials(tmp_path / name, within=["cond"], column_map=own).rows["response"].tolist() == ["1", "0"]


def test_psychopy_sessions_with_different_columns_are_merged(tmp_path):
    """PsychoPy writes a column only if it contains something."""
    text = (FOREIGN / "psychopy_2026.2.5.csv").read_text(encoding="utf-8-sig")
    header, *rows = text.splitlines()
    (tmp_path / "7.csv").write_text(text, encoding="utf-8")
    wider = [f"late,{header}", *(f"{n},{row.replace(',7,001', ',8,001')}" for n, row in enumerate(rows))]
    (tmp_path / "8.csv").write_text("\n".join(wider), encoding="utf-8")
    trials = read_trials(tmp_path, within=["cond"], column_map=PSYCHOPY)
    assert trials.rows["participant"].value_counts().to_dict() == {"7": 12, "8": 12}
    assert set(trials.rows.loc[trials.rows["participant"] == "7", "late"]) == {""}
    assert len(used_rows(trials)) == 16


def test_jspsych_files_are_read_unchanged():
    trials, of_json = (
        read_trials(FOREIGN / f"jspsych_8.3.0.{ending}", within=["phase"], column_map=JSPSYCH)
        for ending in ("csv", "json")
    )
    rows = trials.rows
    assert rows["level"].tolist() == [6, 9, 12, 15] * 3 + [12]
    assert rows["response"].tolist()[:3] == ["1", "2", "2"]
    assert rows["response"].iloc[-1] == ""
    assert rows["correct"].tolist()[:3] == [1, 1, 0]
    assert rows["latency_s"].tolist()[:3] == [0.474, 0.656, 0.692]
    assert len(used_rows(trials)) == 12
    names = ["participant", "level", "response", "correct", "target", "latency_s", "phase"]
    assert rows[names].equals(of_json.rows[names])


@pytest.mark.parametrize("between", ["\n", "", " \r\n\n"])
def test_concatenated_json_lists_are_one_table(tmp_path, between):
    """JATOS stores the results of several participants in this form."""
    first = (FOREIGN / "jspsych_8.3.0.json").read_text()
    (tmp_path / "results.json").write_text(first + between + first.replace('"s3"', '"s4"') + between)
    rows = read_trials(tmp_path / "results.json", within=["phase"], column_map=JSPSYCH).rows
    assert rows["participant"].tolist() == ["s3"] * 13 + ["s4"] * 13
    assert rows["level"].tolist()[:13] == rows["level"].tolist()[13:]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[{", "found no JSON list of objects"),
        ('[{"level": 1}] {}', "found no JSON list of objects"),
        ('[{"level": 1}] [', "found no JSON list of objects"),
        ("[" * 100_000, "found no JSON list of objects"),
        ("{}", "found no JSON list of objects (Expecting a list"),
        ("[]", "(it is empty), expected an object for each trial"),
        ("[1, 2]", "(item 1 is not an object)"),
        ('[{"level": 1}]', "found no column 'participant'"),
        ('[{"participant": "P1", "task": "yes_no", "level": 1, "response": [1]}]', "row 1, column 'response': found"),
    ],
)
def test_json_without_table_is_rejected(tmp_path, text, message):
    file = tmp_path / "j.json"
    file.write_text(text)
    with pytest.raises(InvalidFile, match=re.escape(message)):
        read_trials(file, within=["task"])


TRIAL = {"participant": "P1", "level": 1, "task": "yes_no", "response": 1}


@pytest.mark.parametrize(
    ("trials", "message"),
    [
        ([TRIAL | {f"key_{n}": n} for n in range(20_000)], "trial 4997: found 5001 keys, expected at most 5000"),
        ([TRIAL | {f"key_{t}_{n}": n for n in range(2000)} for t in range(50)], "trial 3: found 6004 keys"),
        ([TRIAL | {f"key_{n % 4900}": n} for n in range(5000)], "with 24495000 empty cells"),
        ([TRIAL | {"data": json.loads("[" * 200 + "]" * 200)}], "nested deeper than 100 levels"),
    ],
    ids=["key per trial", "keys per trial", "sparse", "deep"],
)
def test_json_is_refused_early_when_beyond_bounds(trials, message):
    text = json.dumps(trials)
    tracemalloc.start()
    try:
        with pytest.raises(InvalidFile, match=re.escape(message)):
            json_cells(text, Path("j.json"))
        assert tracemalloc.get_traced_memory()[1] < 2e7
    finally:
        tracemalloc.stop()


def test_a_table_without_a_factor_is_one_condition(tmp_path, capsys):
    answers = [(level, int(n < level * 3)) for level in range(1, 5) for n in range(12)]
    rows = [f"{code},{level},yes_no,{felt}" for code in ("a", "b", "c") for level, felt in answers]
    file = tmp_path / "plain.csv"
    file.write_text("\n".join(["participant,level,task,response", *rows]) + "\n")
    message = refused(capsys, "analyse", file)
    assert message.endswith("name the factors with --within A,B (--within '' if there are none)")
    found = json.loads(output(capsys, "analyse", file, "--within", "", "--json"))
    assert found["factors"] == []
    assert [row["status"] for row in found["thresholds"]] == ["ok"] * 3


def test_column_may_be_mapped_twice(tmp_path):
    file = tmp_path / "t.csv"
    file.write_text("participant,level,key.corr\nP1,1,1\nP1,2,0\n")
    both = ColumnMap({"response": "key.corr", "correct": "key.corr"}, {"task": "yes_no"})
    rows = read_trials(file, within=[], column_map=both).rows
    assert rows["response"].tolist() == ["1", "0"]
    assert rows["correct"].tolist() == [1.0, 0.0]


def test_note_on_single_row_is_singular(tmp_path):
    file = tmp_path / "t.csv"
    file.write_text("participant,level,task,response\nP1,,yes_no,\nP1,2,yes_no,0\n")
    said = read_trials(file, within=[], column_map=ColumnMap({"level": "level"})).notes[0]
    assert said.startswith("1 row was left out: it has no level")


IN_MAP = "in a column map (--columns)"
BELOW = f"; translate it {IN_MAP}, below [values.response], for example:"
INTERVAL = "expected the number of an interval, from 1 to 999, or nothing (task forced_choice)"


@pytest.mark.parametrize(
    ("task", "word", "hint"),
    [
        ("yes_no", "y", f"{BELOW} 'y' = 1"),
        ("forced_choice", "left", f"{INTERVAL}{BELOW} 'left' = 1"),
        ("forced_choice", "0", f"found '0', {INTERVAL}"),  # jsPsych counts buttons from 0
        ("yes_no", "None", f"; mark it as missing {IN_MAP}: missing = ['None']"),
        ("preference", "first", f"{BELOW} 'first' = 1"),
        ("yes_no", "7", "(task yes_no)"),
    ],
)
def test_unmapped_answer_error_suggests_a_map_line(tmp_path, capsys, task, word, hint):
    file = tmp_path / "t.csv"
    file.write_text(f"participant,side,level,task,response,item,item_b,target\nP1,a,1,{task},{word},x,y,1\n")
    assert refused(capsys, "analyse", file, "--within", "side").endswith(hint)


@example("\x7f")  # JSON may hold it as it is, TOML may not
@given(word=st.text(st.characters(max_codepoint=0xD7FF), min_size=1).filter(lambda text: text.strip()))
def test_suggested_map_line_is_valid_toml(word):
    import tomllib

    from tactometry.analysis.reading.rows import meaning

    hint = meaning("response", word)
    if "for example: " in hint:
        assert tomllib.loads(hint.partition("for example: ")[2]).keys() == {word}
    elif hint:
        assert tomllib.loads(hint.partition(": ")[2]) == {"missing": [word]}


def test_equal_defects_are_counted_in_one_sentence(tmp_path, capsys):
    file = tmp_path / "t.csv"
    rows = [f"P1,a,{n},yes_no,{'1' if n == 3 else 'y'}" for n in range(1, 739)]
    file.write_text("\n".join(["participant,side,level,task,response", *rows]) + "\n")
    message = refused(capsys, "analyse", file, "--within", "side")
    assert "t.csv, row 2 and 736 more (3, 5, 6, 7, ...), column 'response': found 'y', expected 1, 0 or" in message


def numbered(path: Path, *extra: str) -> Path:
    lines = ["participant,session,block,trial,side,procedure,level,task,response,onset_s"]
    lines += [f"P1,1,1,{n},a,staircase,{n},yes_no,{int(n > 4)},{n}.5" for n in range(1, 9)]
    file = path / "t.csv"
    file.write_text("\n".join([*lines, *extra]) + "\n")
    return file


def test_copied_rows_are_warned_of(tmp_path, capsys):
    file = numbered(tmp_path, "P1,1,1,3,a,staircase,3,yes_no,0,3.5", "P1,1,1,5,a,staircase,5,yes_no,0,9.5")
    assert (
        "2 rows repeat earlier trials (the first: t.csv, row 10; 1 of 2 identical in every cell): each "
        "counts as a separate trial. Remove copies, or number trials consecutively in each session"
    ) in json.loads(output(capsys, "analyse", file, "--json"))["warnings"]


def test_distinct_rows_are_not_reported_as_copies(tmp_path):
    places = ("1,1,2,3,a,staircase", "1,1,1,3,b,staircase", "1,1,1,3,a,q")
    assert read_trials(numbered(tmp_path, *(f"P{place},3,yes_no,0,3.5" for place in places))).notes == ()
    file = tmp_path / "n.csv"
    file.write_text("participant,side,level,task,response\n" + "P1,a,1,yes_no,1\n" * 5)
    assert read_trials(file, within=["side"]).notes == ()


@pytest.mark.parametrize(("command", "code"), [("analyse", 2), ("validate", 1)])
def test_table_with_too_many_columns_is_rejected(tmp_path, capsys, command, code):
    file = tmp_path / "t.csv"
    file.write_text(",".join(f"c{n}" for n in range(100_000)) + "\n" + ",".join("1" * 100_000) + "\n")
    status, errors, out = call(capsys, command, file)
    assert (status, "row 1: found 100000 columns, expected at most 5000" in errors + out) == (code, True)
