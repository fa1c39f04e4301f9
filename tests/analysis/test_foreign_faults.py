"""Faults of tables from other laboratories, analysed through the command."""

import json

import pytest
from command_line import output, refused

HEAD = "participant,level,response,side,latency_s"
YES_NO = '[constants]\ntask = "yes_no"\n'
CHOICE = '[constants]\ntask = "forced_choice"\nn_alternatives = {}\n'
ROWS = [f"S{n},{level},{int(level > 4 + n)},{side},0.5" for n in (1, 2) for level in range(2, 10) for side in "ab"]


def written(folder, lines=(HEAD, *ROWS), column_map=YES_NO):
    table = folder / "t.csv"
    table.write_text("\n".join(lines) + "\n", encoding="utf-8")
    (folder / "map.toml").write_text(column_map, encoding="utf-8")
    return table


def analysed(capsys, path, within="side", column_map=None):
    column_map = column_map or path.parent / "map.toml"
    return json.loads(output(capsys, "analyse", path, "--columns", column_map, "--within", within, "--json"))


def warned(found, text):
    return [warning for warning in found["warnings"] if text in warning]


def replaced(old, new, every=2):
    """The lines of the table with a text replaced in some rows."""
    return [HEAD, *(row.replace(old, new) if n % every == 0 else row for n, row in enumerate(ROWS))]


def choices(correct, targets=(1, 2)):
    """Write forced choices with alternating targets that are all correct or all wrong."""
    pairs = [(targets[level % 2], targets[(level + (not correct)) % 2], level) for level in range(1, 41)]
    rows = [f"S{n},{level},{response},a,0.5,{target}" for n in (1, 2) for target, response, level in pairs]
    return [f"{HEAD},target", *rows]


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("S1,", "S\u200b1\ufeff,"),
        ("S1,", "S1 ,"),
        ("S1,", " S1\u00a0,"),
        (",a,", ",a ,"),
        (",a,", ", a,"),
        (",a,", ',"a ",'),
        (",1,", ", 1 ,"),
    ],
)
def test_spaces_around_cells_change_no_result(capsys, tmp_path, old, new):
    expected = analysed(capsys, written(tmp_path))
    found = analysed(capsys, written(tmp_path, replaced(old, new)))
    assert (found["thresholds"], found["warnings"]) == (expected["thresholds"], expected["warnings"])


def test_space_bar_keeps_its_meaning_as_a_response(capsys, tmp_path):
    lines = [HEAD, *(row.replace(",1,", ", ,").replace(",0,", ",no ,") for row in ROWS)]
    found = analysed(capsys, written(tmp_path, lines, YES_NO + '[values.response]\n" " = 1\n"no " = 0\n'))
    assert found["thresholds"] == analysed(capsys, written(tmp_path))["thresholds"]


@pytest.mark.parametrize(
    ("lines", "column_map", "text"),
    [
        (replaced(",a,", ",A,", 4), YES_NO, "side has values that differ only in case or spaces: 'A' and 'a'"),
        (replaced(",0.5", ",500", 1), YES_NO, "32 rows have a 'latency_s' above a minute; if these are milliseconds"),
        (choices(False), CHOICE.format(2), "80 rows have answers of participants who score below chance"),
        (
            (HEAD, *ROWS),
            YES_NO + "n_alternatives = 2\n",
            "32 rows have an 'n_alternatives', which the task yes_no does",
        ),
        (
            replaced(",a,", ",A,", 4),
            YES_NO + '[keep]\nside = ["a", "b"]\n',
            "8 rows with side = 'A' not kept; expected",
        ),
        (choices(True), CHOICE.format(3), "80 rows have an 'n_alternatives' above every response and target"),
    ],
)
def test_command_warns_of_doubtful_values(capsys, tmp_path, lines, column_map, text):
    assert len(warned(analysed(capsys, written(tmp_path, lines, column_map)), text)) == 1


@pytest.mark.parametrize(
    ("lines", "column_map"),
    [
        (replaced(",0.5", ",500", 4), YES_NO),
        (choices(True), CHOICE.format(2)),
        (choices(True, targets=(3, 1)), CHOICE.format(3)),
        (choices(True, targets=(1, 1)), CHOICE.format(3)),
    ],
)
def test_command_does_not_doubt_plausible_values(capsys, tmp_path, lines, column_map):
    found = analysed(capsys, written(tmp_path, lines, column_map))
    assert not warned(found, "above a minute") + warned(found, "above every response")


@pytest.mark.parametrize("name", ["S1 (1).csv", "copy.tsv.csv"])
def test_copied_file_is_named_once(capsys, tmp_path, name):
    (tmp_path / "d").mkdir()
    (tmp_path / "d" / "S1.csv").write_bytes(written(tmp_path).read_bytes())
    (tmp_path / "d" / name).write_bytes(written(tmp_path).read_bytes())
    (tmp_path / "d" / "other.csv").write_text("\n".join(replaced("S", "T", 1)) + "\n")
    found = analysed(capsys, tmp_path / "d", column_map=tmp_path / "map.toml")
    (said,) = warned(found, "the same content")
    assert said.startswith(" and ".join(sorted(["S1.csv", name])))


def test_lock_files_of_excel_are_ignored(capsys, tmp_path):
    (tmp_path / "d").mkdir()
    (tmp_path / "d" / "S1.csv").write_bytes(written(tmp_path).read_bytes())
    (tmp_path / "d" / "~$S1.csv").write_text("user")
    assert analysed(capsys, tmp_path / "d", column_map=tmp_path / "map.toml")["n_participants"] == 2


def test_tables_in_subfolders_are_refused_by_folder(capsys, tmp_path):
    (tmp_path / "d" / "day1").mkdir(parents=True)
    (tmp_path / "d" / "day1" / "S1.csv").write_bytes(written(tmp_path).read_bytes())
    said = refused(capsys, "analyse", tmp_path / "d", "--columns", tmp_path / "map.toml", "--within", "side")
    assert "found tables only in its subfolders (day1), expected them in the folder itself" in said


@pytest.mark.parametrize(
    ("old", "new", "column_map", "message"),
    [
        (",1,", ",FALSE,", YES_NO, "below [values.response], for example: 'FALSE' = 0"),
        ("S1,5", "S1,nan", YES_NO, "column 'level': found 'nan', expected a finite number or nothing; mark it as"),
        (",1,", ",yes,", YES_NO, "below [values.response], for example: 'yes' = 1"),
        (",1,", ",#N/A,", YES_NO, "mark it as missing in a column map (--columns): missing = ['#N/A']"),
        (",0.5", ",nan", YES_NO, "column 'latency_s': found 'nan', expected a finite number or nothing; mark it as"),
        (",0.5", ",0.5", CHOICE.format(1), "column 'n_alternatives': found '1', expected a whole number from 2"),
        (
            ",0.5",
            ",0.5",
            YES_NO + "level = 3\n[columns]\nlevel='x'\n",
            "level: found definitions in columns and constants",
        ),
        ("S1,", "S1,", YES_NO + '[columns]\nlevel = "LEVEL"\n', "assigns to 'level'; did you mean 'level'?"),
        (",0.5", ",1.500", 'decimal = ","\n' + YES_NO, "column 'latency_s': found '1.500', expected a decimal comma"),
    ],
)
def test_refusal_names_cause_and_remedy(capsys, tmp_path, old, new, column_map, message):
    separator = 'separator = ";"\n' if "decimal" in column_map else ""
    lines = [line.replace(",", ";") if separator else line for line in replaced(old, new, 1)]
    table = written(tmp_path, lines, separator + column_map)
    assert message in refused(capsys, "analyse", table, "--columns", tmp_path / "map.toml", "--within", "side")


def test_both_letters_mu_state_micrometres(capsys, tmp_path):
    units = [
        analysed(capsys, written(tmp_path, column_map=f'{YES_NO}[units]\nlevel = "{mu}m"\n'))["thresholds"]
        for mu in ("\u00b5", "\u03bc")
    ]
    assert units[0] == units[1]


def test_numbers_of_a_map_keep_every_digit(capsys, tmp_path):
    words = "".join(f"w{level} = {1234567 + level / 8}\n" for level in range(2, 10))
    worded = [row.replace(",", ",w", 1) for row in ROWS]
    written_out = [
        f"S{n},{1234567 + int(row.split(',')[1]) / 8},{row.split(',', 2)[2]}" for row in ROWS for n in row[1]
    ]
    expected = analysed(capsys, written(tmp_path, [HEAD, *written_out]))["thresholds"]
    assert (
        analysed(capsys, written(tmp_path, [HEAD, *worded], f"{YES_NO}[values.level]\n{words}"))["thresholds"]
        == expected
    )


def test_refused_counts_name_each_row_once(capsys, tmp_path):
    lines = ["participant,level,n_positive,n_trials", "S1,1,2,9", "S1,Total,4,9", "S1,none of it,4,9"]
    table = written(tmp_path, lines)
    said = refused(capsys, "analyse", table, "--columns", tmp_path / "map.toml", "--within", "")
    assert "row 3 and 1 more (4), column 'level': found 'Total'" in said


@pytest.mark.parametrize(("code", "ours"), [("sub-01", "sub01"), ("P_01", "P01")])
def test_code_is_written_without_separators_with_a_warning(capsys, tmp_path, code, ours):
    table = written(tmp_path, replaced("S1,", f"{code},", 1))
    found = analysed(capsys, table)
    assert ours in {cell["participant"] for cell in found["thresholds"]}
    assert f"{code} as {ours}; set others in [values.participant]" in warned(found, "separators")[0]


@pytest.mark.parametrize(
    ("codes", "message"),
    [
        (("P_01", "P01"), "found the participants 'P01' and 'P_01'"),
        (("Bob Smith",), "below [values.participant]: 'Bob Smith' = 'P1'"),
    ],
)
def test_code_is_refused_with_the_line_to_write(capsys, tmp_path, codes, message):
    table = written(tmp_path, ["participant,level,response", *(f"{code},1,0" for code in codes)])
    assert message in refused(capsys, "analyse", table, "--columns", tmp_path / "map.toml", "--within", "")
