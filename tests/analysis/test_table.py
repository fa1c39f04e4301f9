"""Tests of reading trials tables, of their errors, and of reserved names."""

import re
from pathlib import Path

import pytest
from click.testing import CliRunner
from examples import examples
from hypothesis import HealthCheck, given, strategies as st

from tactometry.analysis.pipeline import analyse
from tactometry.analysis.reading.column_map import read_column_map
from tactometry.analysis.reading.trials import read_trials, used_rows
from tactometry.cli.analyse import command
from tactometry.errors import InvalidFile, InvalidParameter, TactometryError
from tactometry.trials.columns import DERIVED, RESERVED

HEADER = "participant,session,study,block,trial,force_n,procedure,level,level_unit,task,response,correct,valid,catch"
ROW = "P01,1,s,1,1,0.5,staircase,20,dB re 1 V,yes_no,1,1,1,0"
TASKS = (
    "yes_no, forced_choice, comparison, same_different, magnitude, adjustment, rating, localisation, preference, "
    "measurement"
)
CODE = "a code of 1 to 32 letters and digits, not a name or a path"


def written(path: Path, *lines: str) -> Path:
    file = path / "trials.csv"
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return file


def changed(column: str, value: str) -> str:
    cells = ROW.split(",")
    cells[HEADER.split(",").index(column)] = value
    return ",".join(cells)


def test_reads_numbers_flags_and_factors(tmp_path: Path) -> None:
    trials = read_trials(written(tmp_path, HEADER, ROW, changed("level", "").replace(",0", ",1")))
    assert trials.factors == ("force_n",)
    assert trials.rows["level"].tolist()[0] == 20.0
    assert trials.rows["catch"].tolist() == [0.0, 1.0]
    assert trials.rows["row"].tolist() == [2, 3]


def test_used_rows_exclude_invalid_unanswered_and_practice(tmp_path: Path) -> None:
    header = HEADER + ",practice"
    rows = [ROW + ",0", changed("valid", "0") + ",", changed("response", "") + ",", ROW + ",1"]
    assert used_rows(read_trials(written(tmp_path, header, *rows)))["row"].tolist() == [2]


BLANK = "save it as comma-separated values with decimal points, or set the separator in a column map"
FACTORS = "'trial' and 'procedure'; name the factors with --within A,B (--within '' if there are none)"


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        (["", ""], ": found an empty file, expected a header and trials"),
        ([HEADER], ": found no row below the header, expected at least one trial"),
        (
            [HEADER.replace("level,", "levl,", 1), ROW],
            ": found no column 'level'; assign it in a column map (--columns); did you mean 'levl'?",
        ),
        ([HEADER.replace(",task", ",level"), ROW], ", row 1: found the column 'level' twice, expected unique names"),
        ([HEADER.replace(",task", ","), ROW], ", row 1: found no name for column 10, expected a name for each column"),
        (
            [HEADER.replace(",procedure", ",rule"), ROW],
            f": found no column 'procedure', expected the factors between {FACTORS}",
        ),
        ([HEADER, ROW, ROW + ",1"], ", row 3: found 15 cells, expected 14 as in the header"),
        ([HEADER, ROW, "P01,1,s"], ", row 3: found 3 cells, expected 14 as in the header"),
        (
            [HEADER.replace(",", ";"), ROW],
            f", row 1: found columns separated by ;, expected commas, or tabs in a .tsv file; {BLANK}",
        ),
        ([HEADER, '"P01' + ROW[3:]], ": found an unclosed quotation mark, expected quotation marks in pairs"),
    ],
)
def test_damaged_table_is_rejected_with_one_sentence(tmp_path: Path, lines: list[str], message: str) -> None:
    file = written(tmp_path, *lines)
    with pytest.raises(InvalidFile, match=f"^{re.escape(str(file) + message)}$"):
        read_trials(file)


MAP_OF = "in a column map (--columns), below"
YES = "[values.correct], for example: 'yes' = 1"


@pytest.mark.parametrize(
    ("column", "cell", "message"),
    [
        ("participant", "", f"nothing, expected {CODE}"),
        ("participant", "J D", f"'J D', expected {CODE}; assign codes {MAP_OF} [values.participant]: 'J D' = 'P1'"),
        ("task", "yesno", f"'yesno', expected one of {TASKS}"),
        ("level", "loud", "'loud', expected a finite number or nothing"),
        ("level", "inf", "'inf', expected a finite number or nothing"),
        ("level", '"20,5"', "'20,5', expected a decimal point"),
        ("level", "", "nothing, expected a level, or 1 in the column 'catch'"),
        ("response", "2", "'2', expected 1, 0 or nothing (task yes_no)"),
        ("correct", "yes", f"'yes', expected 1, 0 or nothing; translate it {MAP_OF} {YES}"),
        ("valid", "2", "'2', expected 1, 0 or nothing"),
        ("block", "1.5", "'1.5', expected a whole number from 0"),
        ("force_n", "", "nothing, expected the factor's value"),
    ],
)
def test_invalid_cell_is_rejected_with_its_place(tmp_path: Path, column: str, cell: str, message: str) -> None:
    file = written(tmp_path, HEADER, ROW, changed(column, cell))
    expected = re.escape(f"{file}, row 3, column '{column}': found {message}")
    with pytest.raises(InvalidFile, match=f"^{expected}$"):
        read_trials(file)


def test_invalid_bytes_are_rejected_with_their_row(tmp_path: Path) -> None:
    file = tmp_path / "trials.csv"
    file.write_bytes(f"{HEADER}\n{ROW}\nP0".encode() + b"\xff\n")
    with pytest.raises(InvalidFile, match=re.escape("row 3: found the byte 0xff, expected UTF-8 text")):
        read_trials(file)
    file.write_bytes(f"{HEADER}\nP\0".encode())
    with pytest.raises(InvalidFile, match=re.escape("row 2: found a null byte, expected text")):
        read_trials(file)


def test_missing_files_and_columns_are_named(tmp_path: Path) -> None:
    with pytest.raises(InvalidFile, match="no such file or folder, expected a data set or a CSV file of trials"):
        read_trials(tmp_path / "nowhere")
    with pytest.raises(InvalidFile, match=re.escape("found no data/*_data.csv")):
        read_trials(tmp_path)
    file = written(tmp_path, HEADER, ROW)
    with pytest.raises(InvalidParameter, match=r"--within: found 'forc_n', .*; did you mean 'force_n'"):
        read_trials(file, within=["forc_n"])
    with pytest.raises(InvalidParameter, match=r"--within: found 'source', expected columns of .*(?<!'source'\?)$"):
        read_trials(file, within=["source"])


def test_files_of_different_studies_are_refused(tmp_path: Path) -> None:
    folder = tmp_path / "data"
    folder.mkdir()
    (folder / "a_data.csv").write_text(f"{HEADER}\n{ROW}\n")
    (folder / "b_data.csv").write_text(f"{HEADER.replace('force_n', 'pattern')}\n{ROW}\n")
    with pytest.raises(
        InvalidFile, match=re.escape("b_data.csv: found columns that differ from a_data.csv (force_n, pattern)")
    ):
        read_trials(tmp_path)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[column]\n", "column: found an unknown key, expected one of columns, constants, values, keep, from_name, "),
        ("[columns]\nlevel = [1]\n", "columns.level: found [1], expected a text"),
        ("decimal = ';'", "decimal: found ';', expected '.' or ','"),
        ("decimal = ','", "separator: found '', expected one character that differs from the decimal sign"),
        ("missing = 'NA'", "missing: found 'NA', expected"),
        ("[columns\n", "found no valid TOML"),
    ],
)
def test_a_damaged_column_map_is_refused(tmp_path: Path, text: str, message: str) -> None:
    file = tmp_path / "map.toml"
    file.write_text(text)
    with pytest.raises(InvalidFile, match=re.escape(message)):
        read_column_map(file)


@given(content=st.binary(max_size=400))
@examples(150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_random_bytes_are_rejected_and_left_unchanged(tmp_path: Path, content: bytes) -> None:
    file = tmp_path / "trials.csv"
    file.write_bytes(content)
    with pytest.raises(TactometryError):
        read_trials(file)
    assert file.read_bytes() == content


@given(data=st.data())
@examples(150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_randomly_damaged_table_never_causes_traceback(tmp_path: Path, data: st.DataObject) -> None:
    content = bytearray("\n".join([HEADER, *[ROW] * 4, changed("level", "24")]).encode())
    for _ in range(data.draw(st.integers(1, 3))):
        place = data.draw(st.integers(0, len(content) - 1))
        content[place : place + data.draw(st.integers(0, 3))] = data.draw(st.binary(max_size=3))
    file = tmp_path / "trials.csv"
    file.write_bytes(bytes(content))
    result = CliRunner().invoke(command, [str(file), "--json"])
    assert result.exception is None or isinstance(result.exception, TactometryError)
    assert file.read_bytes() == bytes(content)


OF_FACTOR = "participant,session,study,block,trial,{},procedure,level,level_unit,task,response"


def table(path: Path, factor: str) -> Path:
    rows = [
        f"P{participant},1,x,1,{trial},{condition},constant_stimuli,{level},dB,yes_no,{int(level > 3 - shift)}"
        for participant in (1, 2, 3)
        for condition, shift in (("a", 0), ("b", 1))
        for trial, level in enumerate((1, 2, 3, 4, 5, 2, 3, 4), 1)
    ]
    file = path / "c.csv"
    file.write_text("\n".join([OF_FACTOR.format(factor), *rows]) + "\n")
    return file


def test_factor_with_unreserved_name_is_analysed(tmp_path):
    found = analyse(table(tmp_path, "colour"))
    assert found.trials.factors == ("colour",)
    assert found.tables["thresholds"]["colour"].tolist() == ["a", "b"] * 3


@pytest.mark.parametrize("name", sorted(DERIVED))
def test_factor_with_reserved_name_is_rejected(tmp_path, name):
    with pytest.raises(InvalidFile, match=f"row 1: found '{name}' between 'trial' and 'procedure'"):
        analyse(table(tmp_path, name))


def test_every_column_that_an_analysis_adds_is_reserved(tmp_path):
    found = analyse(table(tmp_path, "colour"))
    named = ("thresholds", "rates", "mean_rates", "quality", "group_threshold")
    added = {column for name in named for column in found.tables[name]} - {"colour"}
    assert added <= RESERVED


@pytest.mark.parametrize("name", ["level", "response", "task", "participant"])
def test_measured_column_is_rejected_as_factor(tmp_path, name):
    with pytest.raises(InvalidParameter, match=f"--within: found '{name}', a reserved name"):
        analyse(table(tmp_path, "colour"), within=[name])


def test_sessions_and_blocks_may_be_compared(tmp_path):
    assert analyse(table(tmp_path, "colour"), within=["session", "colour"]).trials.factors == ("session", "colour")


def test_levels_with_infinite_range_are_rejected(tmp_path):
    file = table(tmp_path, "colour")
    file.write_text(file.read_text().replace(",5,dB", ",1e308,dB").replace(",1,dB", ",-1e308,dB"))
    with pytest.raises(InvalidParameter, match=r"found -1e\+308, expected an absolute value of at most 1e\+300"):
        analyse(file)
