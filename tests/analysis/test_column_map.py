"""Tests of column maps, of tables in spreadsheet formats, and of units and ratio scales."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from command_line import output
from examples import examples
from hypothesis import HealthCheck, given, strategies as st
from places import DOCS

from tactometry.analysis.pipeline import analyse
from tactometry.analysis.reading.column_map import ColumnMap, read_column_map
from tactometry.analysis.reading.level_scale import on_scale, wide_levels
from tactometry.analysis.reading.rows import numbers_of, plain_numbers
from tactometry.analysis.reading.text_table import plain_cells
from tactometry.analysis.reading.trials import read_trials, used_rows
from tactometry.config.quantity import si_unit
from tactometry.errors import InvalidFile, InvalidParameter
from tactometry.psychometric import PsychometricFunction

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


@pytest.mark.parametrize(
    ("name", "unit", "cell", "value"),
    [
        ("latency_s", "ms", "812", 0.812),
        ("latency_s", "min", "1.5", 90.0),
        ("level", "mV", "455.2", 0.4552),
        ("level", "kHz", "2.3", 2300.0),
        ("force_n", "mN", "250", 0.25),
        ("speed_mean_m_per_s", "mm/s", "-50", -0.05),
    ],
)
def test_column_is_converted_to_si(tmp_path, name, unit, cell, value):
    file = tmp_path / "t.csv"
    cells = {"participant": "P1", "side": "a", "level": "1", "task": "yes_no", "response": "1"} | {name: cell}
    file.write_text(f"{','.join(cells)}\n{','.join(cells.values())}\n")
    found = read_trials(file, within=["side"], column_map=ColumnMap(units={name: unit})).rows
    assert float(found[name].iloc[0]) == value
    if name == "level":
        assert found["level_unit"].tolist() == [si_unit(unit, "")[0]]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('[units]\nlatency_s = "mV"', "units.latency_s: found 'mV', a unit of V, expected a unit of s"),
        ('[units]\nlevel = "mv"', "units.level: found 'mv', expected a unit such as ms, mV or N; did you mean"),
        ('level_scale = "log"', "level_scale: found 'log', expected one of linear, log10, db"),
    ],
)
def test_map_with_invalid_unit_or_scale_is_rejected(tmp_path, text, message):
    (tmp_path / "m.toml").write_text(text)
    with pytest.raises(InvalidFile, match=re.escape(message)):
        read_column_map(tmp_path / "m.toml")


def test_levels_in_two_units_are_refused(tmp_path):
    file = tmp_path / "t.csv"
    file.write_text("participant,side,level,level_unit,task,response\nP1,a,1,dB,yes_no,1\n")
    message = "found the level_unit 'dB', expected 'V', the unit after conversion by units.level"
    with pytest.raises(InvalidFile, match=message):
        read_trials(file, within=["side"], column_map=ColumnMap(units={"level": "mV"}))


TRUE = PsychometricFunction("weibull", 0.05, 0.1, 0.02, 0.02)
CONTRASTS = tuple(np.geomspace(0.002, 0.5, 9))


def contrasts(path: Path, *, unit: str = "") -> Path:
    """Write yes/no answers at contrasts that span a factor of 250."""
    lines = ["participant,side,level,level_unit,task,response,catch"]
    for level in CONTRASTS:
        n_yes = round(40 * TRUE.probability(level))
        lines += [f"P1,a,{level:.17g},{unit},yes_no,{int(n < n_yes)},0" for n in range(40)]
    lines += [f"P1,a,,{unit},yes_no,{int(n < 1)},1" for n in range(40)]
    file = path / "c.csv"
    file.write_text("\n".join(lines) + "\n")
    return file


def test_wide_linear_levels_have_warning(tmp_path, capsys):
    arguments = ("analyse", contrasts(tmp_path), "--within", "side", "--json")
    (warning,) = [text for text in json.loads(output(capsys, *arguments))["warnings"] if "linear axis" in text]
    assert warning.startswith("levels from 0.002 to 0.5 span a factor of 250 on a linear axis")
    assert "--level-scale log10 or db" in warning
    assert "linear axis" not in output(capsys, *arguments, "--level-scale", "linear")


def test_decibel_or_narrow_levels_have_no_warning(tmp_path):
    rows = read_trials(contrasts(tmp_path, unit="dB re 1 V"), within=["side"]).rows
    assert wide_levels(rows) == []
    few = read_trials(contrasts(tmp_path), within=["side"]).rows
    assert wide_levels(few[few["level"].isna() | (few["level"] > 0.03)]) == []
    assert wide_levels(few.assign(level=few["level"] - 0.01)) == []


def test_threshold_is_on_the_logarithmic_scale(tmp_path):
    file = contrasts(tmp_path, unit="V")
    log10, db = (analyse(file, within=["side"], level_scale=scale).tables["thresholds"] for scale in ("log10", "db"))
    for table, unit, factor in ((log10, "log10 V", 1), (db, "dB re 1 V", 20)):
        (row,) = table.to_dict("records")
        assert (row["level_unit"], row["shape"]) == (unit, "gumbel")
        assert row["interval_low"] < factor * np.log10(TRUE.threshold) < row["interval_high"]
        assert row["interval_high"] - row["interval_low"] < factor * 0.5
    np.testing.assert_allclose(db["threshold"].astype(float), 20 * log10["threshold"].astype(float), rtol=1e-6)


def test_command_option_overrides_scale_of_map(tmp_path, capsys):
    (tmp_path / "m.toml").write_text('level_scale = "db"\n')
    file = contrasts(tmp_path, unit="V")
    arguments = ("analyse", file, "--within", "side", "--json", "--columns", tmp_path / "m.toml")
    for options, unit in (((), "dB re 1 V"), (("--level-scale", "log10"), "log10 V")):
        found = json.loads(output(capsys, *arguments, *options))
        assert found["level_unit"] == unit
        assert not [text for text in found["warnings"] if "linear axis" in text]


def test_level_scale_converts_settings_but_not_magnitudes(tmp_path):
    lines = ["participant,side,level,level_unit,task,response"]
    lines += ["P1,a,1,V,adjustment,10", "P1,a,10,V,magnitude,3", "P1,a,,V,adjustment,"]
    (tmp_path / "t.csv").write_text("\n".join(lines) + "\n")
    rows = read_trials(tmp_path / "t.csv", within=["side"], level_scale="db").rows
    assert rows["response"].tolist() == ["20.0", "3", ""]
    assert rows["level_unit"].tolist() == ["dB re 1 V", "V", "dB re 1 V"]
    assert rows["level"].tolist()[:2] == [0.0, 10.0]


@pytest.mark.parametrize("name", ["level", "level_delivered", "standard_level"])
def test_level_without_logarithm_is_rejected_with_its_row(tmp_path, name):
    file = tmp_path / "t.csv"
    file.write_text(f"participant,side,{name},x,task,response\nP1,a,1,1,yes_no,1\nP1,a,0,1,yes_no,1\n")
    columns = ColumnMap({} if name == "level" else {"level": "x"})
    with pytest.raises(InvalidFile, match=rf"row 3, column '{name}': found 0.0, expected a level above 0 on a log"):
        read_trials(file, within=["side"], column_map=columns, level_scale="log10")


def test_decibels_have_no_second_logarithm(tmp_path):
    with pytest.raises(InvalidParameter, match="found log10 for levels in 'dB re 1 V', which are already logarithms"):
        read_trials(contrasts(tmp_path, unit="dB re 1 V"), within=["side"], level_scale="log10")
    with pytest.raises(InvalidParameter, match="--level-scale: found 'log', expected one of linear, log10, db"):
        on_scale(read_trials(contrasts(tmp_path), within=["side"]).rows, "log")
