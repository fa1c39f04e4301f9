"""Tests of column maps and of tables in spreadsheet formats."""

import re
from pathlib import Path

import numpy as np
import pytest
from examples import examples
from hypothesis import HealthCheck, given, strategies as st
from places import DOCS

from tactometry.analysis.reading.column_map import ColumnMap, read_column_map
from tactometry.analysis.reading.rows import numbers_of, plain_numbers
from tactometry.analysis.reading.text_table import plain_cells
from tactometry.analysis.reading.trials import read_trials, used_rows
from tactometry.errors import InvalidFile

PAGE = (DOCS / "reference" / "analysis.md").read_text("utf-8")
_, PSYCHOPY_MAP, JSPSYCH_MAP, BIDS_MAP = re.findall(r"<!-- map -->\n```toml\n(.*?)```", PAGE, re.DOTALL)
PSYCHOPY = """\
text,contrast,cond,trials.thisN,key_resp.keys,key_resp.corr,key_resp.rt,participant,session,date,expName
Welcome!,,,,,,,7,001,2026-11-21_10h00,detect
,0.1,low,0,y,1,0.51,7,001,2026-11-21_10h00,detect
,0.2,low,1,n,0,0.62,7,001,2026-11-21_10h00,detect
,0.3,high,2,None,0,,7,001,2026-11-21_10h00,detect
"""

JSPSYCH = """\
"rt","stimulus","response","trial_type","trial_index","time_elapsed","subject","amplitude","phase","correct","interval"
"812","<p>Press a key, please</p>"," ","html-keyboard-response","0","900","s3","","","",""
"455.2","","f","audio-2afc","1","2000","s3","12","test","true","1"
"501","","j","audio-2afc","2","3100","s3","9","test","false","1"
"620","","j","audio-2afc","3","4000","s3","15","test","true","2"
"""

BIDS = "onset\tduration\tintensity\tanswer\thand\n0.5\tn/a\t2.5\tyes\tleft\n1.5\tn/a\t3.5\tn/a\tleft\n"


def mapped(tmp_path: Path, text: str) -> ColumnMap:
    file = tmp_path / "map.toml"
    file.write_text(text)
    return read_column_map(file)


def written(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


def test_psychopy_table_is_read(tmp_path) -> None:
    for code in ("7", "8"):
        written(tmp_path / f"data/{code}.csv", PSYCHOPY.replace(",7,001", f",{code},001"))
    trials = read_trials(tmp_path / "data", within=["cond"], column_map=mapped(tmp_path, PSYCHOPY_MAP))
    assert trials.n_files == 2
    assert trials.rows["participant"].tolist() == ["7"] * 3 + ["8"] * 3
    assert trials.rows["level"].tolist() == [0.1, 0.2, 0.3] * 2
    assert trials.rows["response"].tolist() == ["1", "0", ""] * 2
    assert trials.rows["row"].tolist() == [3, 4, 5] * 2
    assert used_rows(trials)["latency_s"].tolist() == [0.51, 0.62] * 2
    with pytest.raises(InvalidFile, match=r"expected .* a column map \(--columns\) and a folder"):
        read_trials(tmp_path / "data", within=["cond"])


def test_jspsych_table_is_read(tmp_path) -> None:
    file = written(tmp_path / "j.csv", JSPSYCH)
    trials = read_trials(file, within=["phase"], column_map=mapped(tmp_path, JSPSYCH_MAP))
    assert trials.rows["response"].tolist() == ["1", "2", "2"]
    assert trials.rows["correct"].tolist() == [1, 0, 1]
    assert trials.rows["target"].tolist() == [1, 1, 2]


@pytest.mark.parametrize("name", ["beh", "events"])
def test_bids_data_set_takes_participants_from_file_names(tmp_path, name) -> None:
    for code in ("01", "02"):
        written(tmp_path / f"b/sub-{code}/ses-A/beh/sub-{code}_ses-3_task-x_{name}.tsv", BIDS)
    trials = read_trials(tmp_path / "b", within=["hand"], column_map=mapped(tmp_path, BIDS_MAP))
    assert trials.rows["participant"].tolist() == ["01", "01", "02", "02"]
    assert trials.rows["session"].tolist() == [3] * 4
    assert trials.rows["response"].tolist() == ["1", "", "1", ""]
    assert trials.rows["level"].tolist() == [2.5, 3.5] * 2


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"keep": {"cnd": ("low",)}}, "no column 'cnd', which the column map names in keep; did you mean 'cond'?"),
        ({"keep": {"cond": ("mid", "x")}}, "found no row with cond = mid or x, expected trials (keep)"),
        ({"values": {"respons": {"y": 1}}}, "found no column 'respons', whose values the column map translates"),
        ({"from_name": {"participant": "p"}}, "found no p-... in the file name, expected the value of 'participant'"),
        ({"from_name": {"participant": "sub"}}, "found no sub-... in the file name, expected the value of 'partic"),
        ({"columns": {"session": "date"}}, "found a column 'session', but the column map assigns 'date' to this name"),
    ],
)
def test_unsuitable_column_map_is_rejected(tmp_path, change, message) -> None:
    file = written(tmp_path / "step-1.csv", PSYCHOPY)
    with pytest.raises(InvalidFile, match=re.escape(message)):
        read_trials(file, within=["cond"], column_map=ColumnMap(**change))


def test_unmapped_value_is_rejected_with_its_row(tmp_path) -> None:
    file = written(tmp_path / "p.csv", PSYCHOPY.replace(",n,", ",maybe,"))
    with pytest.raises(InvalidFile, match="row 4, column 'response': found 'maybe', expected 1, 0 or nothing"):
        read_trials(file, within=["cond"], column_map=mapped(tmp_path, PSYCHOPY_MAP))


COLUMNS = ("participant", "level", "task", "response", "side")
CODES = st.sampled_from(["P1", "P2", "x9"])
LEVELS = st.one_of(st.integers(-50, 50).map(float), st.floats(-1e6, 1e6).map(lambda x: float(f"{x:.9g}")))
ROWS = st.lists(st.tuples(CODES, LEVELS, st.just("yes_no"), st.sampled_from("01"), st.sampled_from("lr")), min_size=1,
                max_size=8)  # fmt: skip


@st.composite
def guises(draw):
    """Draw the bytes of a table, the map that reads it, its rows, and the note of its extra columns."""
    rows = draw(ROWS)
    extra = [f"note{n}" for n in range(draw(st.integers(0, 2)))]
    order = draw(st.permutations([*COLUMNS, *extra]))
    comma = draw(st.booleans())
    separator = ";" if comma else draw(st.sampled_from([",", ";", "\t"]))
    quote = '"' if draw(st.booleans()) else ""
    note = draw(st.sampled_from(["", "fine", "0", "µm", *(["a, b"] if quote or separator != "," else [])]))
    lines = [order]
    for row in rows:
        cells = dict(zip(COLUMNS, row, strict=True)) | dict.fromkeys(extra, note)
        cells["level"] = repr(row[1]).replace(".", ",") if comma else repr(row[1])
        lines.append([str(cells[name]) for name in order])
    end = draw(st.sampled_from(["\n", "\r\n"]))
    text = end.join(separator.join(f"{quote}{cell}{quote}" for cell in line) for line in lines)
    text += end * draw(st.integers(0, 3))
    mark = draw(st.sampled_from([b"", b"\xef\xbb\xbf"]))
    return mark + text.encode(), ColumnMap(decimal="," if comma else ".", separator=separator), rows, note


@given(guise=guises())
@examples(120, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_table_is_read_alike_in_every_format(tmp_path, guise) -> None:
    content, column_map, rows, note = guise
    file = tmp_path / "t.csv"
    file.write_bytes(content)
    found = read_trials(file, within=["side"], column_map=column_map).rows
    for place, name in ((0, "participant"), (1, "level"), (3, "response"), (4, "side")):
        assert found[name].tolist() == [row[place] for row in rows]
    assert found["row"].tolist() == list(range(2, len(rows) + 2))
    assert (found.filter(like="note") == note).all(axis=None)


@given(guise=guises(), data=st.data())
@examples(60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_invalid_level_is_rejected_with_its_cell(tmp_path, guise, data) -> None:
    content, column_map, rows, _ = guise
    place = data.draw(st.integers(0, len(rows) - 1))
    bad = data.draw(st.sampled_from(["loud", "1_0", "--1", "inf", "NaN", "0x1f", "1.2.3"]))
    text = content.decode("utf-8-sig").replace("\r\n", "\n").split("\n")
    names = [name.strip('"') for name in text[0].split(column_map.separator)]
    cells = text[1 + place].split(column_map.separator)
    cells[names.index("level")] = bad
    text[1 + place] = column_map.separator.join(cells)
    file = tmp_path / "t.csv"
    file.write_text("\n".join(text))
    with pytest.raises(InvalidFile, match=re.escape(f"t.csv, row {place + 2}, column 'level': found '{bad}'")):
        read_trials(file, within=["side"], column_map=column_map)


@given(st.lists(st.one_of(st.floats(allow_nan=False, allow_infinity=False).map(repr), st.just(""),
                          st.integers(-(10**12), 10**12).map(str)), min_size=1))  # fmt: skip
def test_fast_and_plain_number_readers_agree(words) -> None:
    import pandas as pd

    from tactometry.analysis.reading.rows import _numbers_of_words

    text = pd.Series(words, dtype="str")
    assert np.array_equal(plain_numbers(text), _numbers_of_words(text), equal_nan=True)
    assert np.array_equal(numbers_of(text), _numbers_of_words(text), equal_nan=True)


@pytest.mark.parametrize("text", ['a,b\n"1",2', "a,b\n\n1,2", "a,b\r1,2", "a,b\n1", "a,b\n1,2,3", "a\n1", "", "\na,b"])
def test_fast_reader_declines_irregular_text(text) -> None:
    assert plain_cells(text, ",") is None


@given(st.lists(st.lists(st.sampled_from(["", "1", "NA", " x"]), min_size=1, max_size=4), min_size=1, max_size=5))
def test_fast_reader_accepts_only_rows_matching_header(rows) -> None:
    text = "\n".join(",".join(row) for row in rows)
    found = plain_cells(text, ",")
    whole = text.rstrip("\n").split("\n")
    expected = [line.split(",") for line in whole]
    is_plain = all(len(row) == len(expected[0]) > 1 for row in expected)
    assert (None if found is None else found.to_numpy().tolist()) == (expected if is_plain else None)


@pytest.mark.parametrize(
    ("task", "column", "read"), [("comparison", "standard_level", 0.25), ("adjustment", "response", 0.001)]
)
def test_unit_of_levels_applies_to_standards_and_settings(tmp_path, task, column, read) -> None:
    constants = f'[constants]\ntask = "{task}"\nstandard_level = "250"\n'
    (tmp_path / "map.toml").write_text(f'{constants}[units]\nlevel = "mm"\n')
    (tmp_path / "t.csv").write_text("participant,level,response\nP01,200,1\nP01,300,1\n")
    rows = read_trials(tmp_path / "t.csv", within=(), column_map=read_column_map(tmp_path / "map.toml")).rows
    assert rows["level"].tolist() == [0.2, 0.3]
    assert numbers_of(rows[column]).tolist() == [read] * 2
