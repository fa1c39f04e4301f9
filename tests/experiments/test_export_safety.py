"""Hostile table cells in paths, commands and formulas of exports."""

import csv
import io
import json
import re
import shutil
import subprocess
from pathlib import Path

import pandas as pd
import pytest
from command_line import call, status
from hypothesis import given, strategies as st
from patience import LONGEST_PROGRAM_S

from tactometry.analysis.report.page import write_tables
from tactometry.experiments.data_sets.export import export, name, r_string
from tactometry.files.rows import FORMULA, cell_text, delimited_text, file_text, write_rows

COLUMNS = "participant,session,study,block,trial,{},procedure,level,level_unit,task,response,valid"
HOSTILE = "x; system('touch owned') #"


def table(path: Path, *, factor: str = "colour", level: str = "a", study: str = "made-up") -> Path:
    header = COLUMNS.format(f'"{factor}"').split("\n")
    lines = [
        f'P{person},1,{study},1,{n},"{level if n % 2 else "b"}",staircase,{x},dB,yes_no,{yes},1'
        for person in (1, 2, 3)
        for n, (x, yes) in enumerate(answers(person), 1)
    ]
    file = path / "trials.csv"
    file.write_text("\n".join([*header, *lines]) + "\n", encoding="utf-8")
    return file


def answers(person: int) -> list[tuple[int, int]]:
    """Return increasing levels with answers, and odd ones in between."""
    return [(x, int(x > 3 + n % 2 * (x > 4 - person) - (n == 3))) for x in range(1, 7) for n in range(12)]


def files(folder: Path) -> set[Path]:
    return {path for path in folder.rglob("*") if path.is_file()}


# --- paths


@pytest.mark.parametrize("form", ["bids", "jspsych", "psych-ds", "psychopy", "r"])
def test_study_name_with_a_path_is_refused(tmp_path, capsys, form):
    file = table(tmp_path, study="x/../../../../../OUTSIDE")
    status, said, _ = call(capsys, "export", file, "--to", form, "--out", tmp_path / "deep/er/out")
    assert (status, files(tmp_path)) == (2, {file})
    assert "column 'study': found 'x/../../../../../OUTSIDE'" in call(capsys, "validate", file)[2]
    assert re.fullmatch(
        r"tactometry: .*trials\.csv, row 2, column 'study': found 'x/\.\./.*OUTSIDE', expected the name of a study: "
        "lower-case letters and digits joined by hyphens",
        said,
    )


@pytest.fixture(scope="module")
def analysed(tmp_path_factory):
    folder = tmp_path_factory.mktemp("analysed")
    file = table(folder, factor="=../../../OUTSIDE", level="=cmd|'/c calc'!A1")
    (folder / "a/b").mkdir(parents=True)
    assert status("analyse", file, "--report", folder / "a/b/r.html", "--figures", folder / "c/figures") == 0
    return folder


def test_factor_with_a_path_stays_in_the_folder(analysed):
    outside = {path for path in files(analysed) if not path.is_relative_to(analysed / "a/b")}
    assert {path for path in outside if not path.is_relative_to(analysed / "c/figures")} == {analysed / "trials.csv"}
    assert (analysed / "a/b/r_tables/pairs_threshold_%3D..%2F..%2F..%2FOUTSIDE.csv").is_file()


@given(st.text(), st.text())
def test_file_texts_are_unique_path_parts(one, other):
    assert not set(file_text(one)) & set('/\\:*?"<>|\0\n')
    assert (file_text(one) == file_text(other)) == (one == other)


# --- commands


def test_r_script_quotes_hostile_columns(tmp_path):
    export(table(tmp_path, factor=HOSTILE, level='"" + q() + ""'), "r", tmp_path / "r")
    script = (tmp_path / "r/trials.R").read_text()
    found = [match.start() for match in re.finditer("system", script)]
    assert found
    spans = [match.span() for match in re.finditer(rf'"{re.escape(HOSTILE)}"|`{re.escape(HOSTILE)}`', script)]
    assert all(any(start < place < end for start, end in spans) for place in found)


@pytest.mark.skipif(shutil.which("Rscript") is None, reason="no Rscript: apt-get install r-base-core")
@pytest.mark.parametrize("factor", [HOSTILE, "a`b\\", "q\n cat('owned')", "=1+1", "é ü", "row name"])
def test_r_runs_nothing_of_a_column(tmp_path, factor):
    export(table(tmp_path, factor=factor, level='x\\""); file.create(""owned'), "r", tmp_path / "r")
    script = tmp_path / "r/trials.R"
    script.write_text(script.read_text() + '\ncat(names(used)[6], nrow(used), nlevels(used[[6]]), sep = "|")\n')
    options = {"capture_output": True, "text": True, "timeout": LONGEST_PROGRAM_S}
    done = subprocess.run(["Rscript", "trials.R"], cwd=script.parent, check=False, **options)
    assert done.returncode == 0, done.stderr
    assert done.stdout == f"{cell_text(factor)}|216|2"
    assert {path.name for path in files(tmp_path / "r")} == {"trials.R", "trials.csv"}


@given(st.text())
def test_r_texts_and_names_end_on_one_line(text):
    for form, sign in ((r_string(text), '"'), (name(text), "`")):
        body = form[1:-1]
        assert form[0] == form[-1] == sign
        assert form.isprintable()
        assert re.fullmatch(rf"(?:[^\\{sign}]|\\[\\{sign}]|\\u\{{[0-9a-f]+\}})*", body)


# --- formulas


PAYLOADS = [
    *("=cmd|'/c calc'!A1", "+1+1", "-1+1", "@SUM(A1)", "\tx", "\r=1+1", "\n=1+1", "x\r=1+1", "\ufeff=1+1"),
    *("\uff1d1+1", "\uff0b1", "\uff0d1", "\uff20SUM(A1)"),
]


def is_formula(cell: str) -> bool:
    return cell.startswith((*FORMULA, "\ufeff"))


@given(st.text() | st.sampled_from(PAYLOADS))
def test_cell_text_is_never_a_formula(text):
    assert cell_text(text).removeprefix("'") == text.lstrip("\ufeff").removeprefix("'")
    if is_formula(cell_text(text)):
        float(text)


@given(st.lists(st.lists(st.text(st.sampled_from("a,\t\"'\r\n=")), min_size=2, max_size=2)))
@pytest.mark.parametrize("separator", [",", "\t"])
def test_delimited_text_reads_back_as_it_was(separator, rows):
    text = delimited_text(rows, separator).decode()
    assert list(csv.reader(io.StringIO(text, newline=""), delimiter=separator)) == rows


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_numbers_stay_numbers(number):
    assert cell_text(repr(number)) == repr(number)


@pytest.mark.parametrize("level", PAYLOADS)
@pytest.mark.parametrize("form", ["psych-ds", "psychopy", "jspsych", "r", "bids"])
def test_exports_hold_no_formula(tmp_path, form, level):
    for path in export(table(tmp_path, level=level), form, tmp_path / "out"):
        if path.suffix in (".csv", ".tsv"):
            cells = cells_of(path)
            assert not [cell for cell in cells if is_formula(cell)]
            assert path.name.startswith(("participants", "sub-P1_sessions", "sub-P2_sess", "sub-P3_sess")) or any(
                cell == cell_text(level) for cell in cells
            )


@pytest.mark.parametrize("text", PAYLOADS)
def test_computed_tables_hold_no_formula(tmp_path, text):
    table = pd.DataFrame({text: [text, "b"], "n": [1.5, -2.0]})
    write_tables({"made": table}, tmp_path)
    write_rows([text, "n"], [(text, 1.5), ("b", -2.0)], tmp_path / "rows.csv")
    for path in tmp_path.iterdir():
        assert cells_of(path) == [cell_text(text), "n", cell_text(text), "1.5", "b", "-2.0"]


@pytest.mark.parametrize("form", ["psych-ds", "bids"])
def test_readme_shows_markup_as_text(tmp_path, form):
    (tmp_path / "data").mkdir()
    table(tmp_path / "data").rename(tmp_path / "data/subject-P1_data.csv")
    said = {"name": "\ufeff<script>\nx", "description": "<img src=x> [a](b)"}
    (tmp_path / "dataset_description.json").write_text(json.dumps(said))
    export(tmp_path, form, tmp_path / "out")
    readme = (tmp_path / "out/README.md").read_text(encoding="utf-8")
    assert readme.startswith("# \\<script> x\n\n\\<img src=x> \\[a](b)\n\n")


def test_tables_of_an_analysis_hold_no_formula(analysed):
    written = [path for path in files(analysed) if path.suffix == ".csv" and path.name != "trials.csv"]
    assert written
    found = [cell for path in written for cell in cells_of(path) if is_formula(cell)]
    assert all(float(cell) <= 0 for cell in found)
    assert "'=cmd|'/c calc'!A1" in {cell for path in written for cell in cells_of(path)}


def cells_of(path: Path) -> list[str]:
    with path.open(newline="", encoding="utf-8") as text:
        return [cell for row in csv.reader(text, delimiter="\t" if path.suffix == ".tsv" else ",") for cell in row]
