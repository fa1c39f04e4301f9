"""Tests of other programs' files and faults with known results, analysed through the command."""

import json
import unicodedata

import pytest
from command_line import call, output, refused
from foreign_cases import MAP, write_case
from places import FOREIGN
from study_texts import changed

CASES = FOREIGN / "cases"
ADJUSTED = CASES / "adjustment.toml"
SIX = "6.07 [5.46, 6.69] (n = 4)"
NEGATIVE = "-5.70 [-6.84, -4.56] (n = 3)"
YES_NO = '[constants]\ntask = "yes_no"\n'
FORCED_CHOICE = '[constants]\ntask = "forced_choice"\n'
CHOICE = FORCED_CHOICE + "n_alternatives = {}\n"
COUNTS = '[columns]\nn_positive = "k"\nn_trials = "n"\n'
HEAD = "participant,level,response,side,latency_s"
ROWS = [f"S{n},{level},{int(level > 4 + n)},{side},0.5" for n in (1, 2) for level in range(2, 10) for side in "ab"]


def written(folder, lines=(HEAD, *ROWS), column_map=YES_NO):
    """Write a table and its map, and return the table's path."""
    (folder / "t.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    (folder / "map.toml").write_text(column_map, encoding="utf-8")
    return folder / "t.csv"


def analysed(capsys, path, within="", column_map=None):
    column_map = column_map or path.parent / "map.toml"
    return json.loads(output(capsys, "analyse", path, "--columns", column_map, "--within", within, "--json"))


def refusal(capsys, path, within=""):
    return refused(capsys, "analyse", path, "--columns", path.parent / "map.toml", "--within", within)


def mean(found):
    return found["outcomes"][0]["group"][0]["text"]


def warned(found, text):
    return [warning for warning in found["warnings"] if text in warning]


def warning(found, text):
    return warned(found, text)[0]


@pytest.mark.parametrize(
    "case",
    [
        *("plain", "csv_beside_json", "counts", "code_in_name", "code_within_name", "row_numbers_of_r"),
        *("row_numbers_of_pandas", "sep_line", "json_as_txt", "folder_of_json_as_txt", "column_twice"),
        *("carriage_returns", "line_in_a_cell", "bids", "missing_latency", "unicode_minus"),
    ],
)
def test_threshold_is_right_for_each_case(capsys, tmp_path, case):
    expected = NEGATIVE if case in ("missing_latency", "unicode_minus") else SIX
    assert mean(analysed(capsys, write_case(case, tmp_path))) == expected


@pytest.mark.parametrize(
    ("case", "message"),
    [
        ("open_quotation_mark", "t.csv, row 22: found a quoted cell that extends over several rows"),
        ("unmapped_counts", "and n_positive and n_trials if the table contains counts"),
        ("key_not_in_name", 'A star stands for the value: "P*" in P01.csv, "_subject_*_" in x_subject_1_y.csv'),
        ("one_line", "found one line of 724 cells, expected a line for each row"),
        ("workbook", "found an Excel workbook; save its sheet as CSV"),
    ],
)
def test_refusal_names_the_fault_of_each_case(capsys, tmp_path, case, message):
    assert message in refusal(capsys, write_case(case, tmp_path))


@pytest.mark.parametrize(
    ("case", "text"),
    [
        ("leading_zeros", "leading zeros: 01 and 1, 02 and 2, 03 and 3, 04 and 4; each was"),
        ("missing_latency", "found no column 'key_resp.rt' in 3.csv, so latency_s is empty there"),
        ("row_numbers_of_r", "t.csv: the first column has no name and contains row numbers"),
        ("column_twice", "t.csv: the column 'note' appears 2 times and was not read"),
    ],
)
def test_warning_names_what_each_case_leaves_out(capsys, tmp_path, case, text):
    assert warning(analysed(capsys, write_case(case, tmp_path)), text)


def test_alternatives_are_counted_in_each_condition(capsys, tmp_path):
    found = analysed(capsys, write_case("alternatives", tmp_path), within="n_afc")
    group = {row["n_afc"]: row["text"] for row in found["outcomes"][0]["group"]}
    assert group == {2: "3.21 [2.79, 3.63] (n = 6)", 4: "3.34 [3.17, 3.52] (n = 6)"}
    assert found["outcomes"][0]["anova"][0]["F"] == pytest.approx(0.87, abs=0.005)
    assert "(2: 2; 4: 4)" in warning(found, "differ in the number of alternatives")


def test_alternatives_must_agree_within_a_condition(capsys, tmp_path):
    table = write_case("alternatives", tmp_path)
    (tmp_path / "map.toml").write_text(FORCED_CHOICE + '[columns]\nn_alternatives = "n_afc"\n')
    assert "column 'n_alternatives': found 2 and 4 in one condition" in refusal(capsys, table)
    found = analysed(capsys, table, within="n_alternatives")
    assert {row["guess_rate"] for row in found["thresholds"]} == {0.5, 0.25}


def test_few_answers_do_not_lower_alternatives(capsys, tmp_path):
    sides = [("a", n, n % 4 + 1) for n in range(40)] + [("b", n, n % 3 + 1) for n in range(6)]
    rows = [
        f"S1,{level},{side},{target if 4 * level > 2 * n % 13 else 1 + target % 3},{target}"
        for side, n, target in sides
        for level in (1, 2, 3)
    ]
    table = written(tmp_path, ["participant,level,side,response,target", *rows], FORCED_CHOICE)
    assert {row["guess_rate"] for row in analysed(capsys, table, within="side")["thresholds"]} == {0.25}


def test_row_number_counts_the_sep_line(capsys, tmp_path):
    table = write_case("sep_line", tmp_path)
    table.write_text(table.read_text().replace("S01,2,y", "S01,loud,n", 1))
    assert "t.csv, row 3, column 'level': found 'loud'" in refusal(capsys, table)


def test_folder_ignores_case_of_file_endings(capsys, tmp_path):
    folder = write_case("csv_beside_json", tmp_path)
    (folder / "S04.csv").rename(folder / "S04.CSV")
    assert mean(analysed(capsys, folder)) == SIX


@pytest.mark.parametrize("name", ["S09.xlsx", "S09.psydat", "notes.txt", "settings.json", "S01.json", "more/S09.csv"])
def test_folder_warns_of_files_it_does_not_read(capsys, tmp_path, name):
    folder = write_case("csv_beside_json", tmp_path)
    (folder / name).parent.mkdir(exist_ok=True)
    (folder / name).write_text("{}")
    found = analysed(capsys, folder)
    assert (found["n_participants"], warning(found, "not read")) == (4, f"files not read: {name}")


def test_folder_does_not_warn_of_duplicate_formats(capsys, tmp_path):
    folder = write_case("csv_beside_json", tmp_path)
    (folder / "S01.psydat").write_bytes(b"\x80\x04")
    assert not [warning for warning in analysed(capsys, folder)["warnings"] if "not read" in warning]


def test_bids_folder_warns_of_subjects_without_trials(capsys, tmp_path):
    folder = write_case("bids", tmp_path)
    beh = folder / "sub-04" / "beh"
    (beh / "sub-04_task-detect_beh.tsv").rename(beh / "sub-04_task-detect.tsv")
    found = analysed(capsys, folder)
    assert (found["n_participants"], warning(found, "not read")) == (3, "files not read: sub-04")


def test_participants_without_a_kept_row_are_named(capsys, tmp_path):
    rows = [f"{code},{level},n,{part}" for code, part in (("S1", "test"), ("S2", "Test")) for level in (1, 2, 3)]
    table = written(tmp_path, ["participant,level,response,part", *rows], MAP + '[keep]\npart = ["test"]\n')
    assert "no trial was read of S2" in warning(analysed(capsys, table), "no trial was read")


def test_participants_without_an_answer_are_named(capsys, tmp_path):
    rows = [f"{code},{level},{'y' if level > 2 else 'n'}" for code in ("S1", "S2") for level in (1, 2, 3)]
    found = analysed(capsys, written(tmp_path, ["participant,level,response", *rows, "S3,1,", "S3,2,"], MAP))
    assert warning(found, "no valid answers") == "no valid answers, and therefore no results, of S3"
    left_out = "2 rows without an answer were left out (the first: t.csv, row 8)"
    assert warning(found, "without an answer").startswith(left_out)


def test_choices_without_a_right_answer_are_counted(capsys, tmp_path):
    rows = [f"S1,{level},1,{1 if level > 1 else ''}" for level in (1, 2, 3)]
    table = written(tmp_path, ["participant,level,response,target", *rows], FORCED_CHOICE)
    assert warning(analysed(capsys, table), "neither 'correct'").startswith("1 row of a forced choice")


@pytest.mark.parametrize(
    ("column", "message"),
    [
        ("response", "forced choices need a column 'correct' or 'target'"),
        ("correct", "set n_alternatives = 2 in [constants] of the column map"),
    ],
)
def test_choices_require_the_correct_answer(capsys, tmp_path, column, message):
    table = written(tmp_path, [f"participant,level,{column}", "S1,1,1"], FORCED_CHOICE)
    assert message in refusal(capsys, table)


def test_files_sharing_a_participant_are_named(capsys, tmp_path):
    (tmp_path / "d").mkdir()
    for name in ("results_1.csv", "results_2.csv"):
        (tmp_path / "d" / name).write_text("level,response\n1,n\n2,y\n3,y\n")
    (tmp_path / "map.toml").write_text(MAP + '[from_name]\nparticipant = "*_"\n')
    shared = "files read as one participant, results (from_name): results_1.csv, results_2.csv"
    assert warning(analysed(capsys, tmp_path / "d"), "from_name") == shared


@pytest.mark.parametrize("n_alternatives", [2, 4])
def test_trials_and_counts_have_same_threshold(capsys, tmp_path, n_alternatives):
    correct = {1: 10, 2: 12, 3: 16, 4: 19, 5: 20}
    counts = [f"S1,{level},{k},20" for level, k in correct.items()]
    trials = [f"S1,{level},{int(n < k)}" for level, k in correct.items() for n in range(20)]
    constants = CHOICE.format(n_alternatives)
    of_counts = analysed(capsys, written(tmp_path, ["participant,level,k,n", *counts], constants + COUNTS))
    of_trials = analysed(capsys, written(tmp_path, ["participant,level,correct", *trials], constants))
    first, second = (found["thresholds"][0] for found in (of_counts, of_trials))
    assert first["threshold"] == second["threshold"]
    assert first["guess_rate"] == second["guess_rate"] == 1 / n_alternatives
    assert (first["n_trials"], first["residual_order_p"]) == (100, None)


@pytest.mark.parametrize(("k", "n"), [(13, 12), (-1, 12), (1.5, 12), ("", 12), (1, "")])
def test_impossible_counts_are_refused_with_their_row(capsys, tmp_path, k, n):
    table = written(tmp_path, ["participant,level,k,n", "S1,1,1,12", f"S1,2,{k},{n}"], YES_NO + COUNTS)
    counts = f"found {k or 'nothing'} of {n or 'nothing'} (n_positive of n_trials)"
    assert f"t.csv, row 3: {counts}" in refusal(capsys, table)


@pytest.mark.parametrize(
    ("header", "row", "text"),
    [
        ("target,correct", "2,1", "30 rows have a value of 'correct' that contradicts 'response' and 'target'"),
        ("target,n_alternatives", "3,2", "30 rows have a response or target above 'n_alternatives'"),
        ("target,level_unit", "1,V", "30 rows have a negative level in a non-logarithmic unit"),
        ("target,latency_s", "1,-0.2", "30 rows have a negative 'latency_s' (an answer before the question)"),
    ],
)
def test_contradictions_are_warned_of_with_their_rows(capsys, tmp_path, header, row, text):
    rows = [f"S1,{level},1,{row}" for level in (-3, -2, -1) for _ in range(10)]
    table = written(tmp_path, [f"participant,level,response,{header}", *rows], FORCED_CHOICE)
    assert warning(analysed(capsys, table), text).endswith("(the first: t.csv, row 2)")


def test_survey_answers_of_jspsych_are_ratings(capsys, tmp_path):
    trials = [{"participant": "S1", "level": level, "response": "y"} for level in (1, 2, 3)]
    survey = {"participant": "S1", "trial_type": "survey-likert", "response": {"Q0": 3, "Q1": None}}
    (tmp_path / "t.json").write_text(json.dumps([*trials, survey]))
    (tmp_path / "map.toml").write_text(MAP)
    found = analysed(capsys, tmp_path / "t.json")
    assert warning(found, "survey") == "1 row of survey answers read as the task rating (the first: t.json, row 4)"
    assert warning(found, "rows of other tasks") == "rows of other tasks, not analysed: 2 (rating)"


def test_decomposed_names_match_composed_ones(capsys, tmp_path):
    rows = ["participant,größe,level,response", *(f"S1,groß,{level},n" for level in (1, 2, 3))]
    table = written(tmp_path, [unicodedata.normalize("NFD", row) for row in rows], MAP)
    assert analysed(capsys, table, within="größe")["factors"] == ["größe"]


GUESSED = "guess_rates = [0.02]\n"
INTERVALS = {GUESSED: "", 'kind = "yes_no"\ncatch_rate = 0.2': 'kind = "forced_choice"\nn_intervals = 4'}


def changed_study(folder, changes):
    """Write a study whose guess rate or levels do not fit the task."""
    (folder / "study.toml").write_text(changed((CASES / "stated_guess_rate.toml").read_text(), changes))
    return folder / "study.toml"


def test_reason_names_the_factor_between_participants(capsys):
    found = analysed(capsys, CASES / "between_groups.csv", "A", ADJUSTED)
    (outcome,) = found["outcomes"]
    reason = "by default: every participant has a value, and A differs between participants"
    assert outcome["primary"]["reason"] == reason
    assert outcome["anova"][0]["F"] == pytest.approx(2.33, abs=0.005)
    assert warning(found, "--within A: each participant has only one level")


def test_group_of_one_has_no_anova(capsys):
    found = analysed(capsys, CASES / "one_in_a_group.csv", "A,group", ADJUSTED)
    expected = "no analysis of variance: group = g2: found one participant, expected at least 2 in each group"
    assert expected in found["outcomes"][0]["notes"]


def test_design_without_complete_participants_names_its_empty_cells(capsys):
    found = analysed(capsys, CASES / "not_one_complete.csv", "A,B", ADJUSTED)
    assert warning(found, "have no valid trial").startswith("8 of ")
    assert found["outcomes"][0]["primary"]["analysis"] == "censored_anova"


def test_threshold_above_levels_has_lower_bound(capsys, tmp_path):
    changes = {"n_intervals = 4": "n_intervals = 2", "high = 46.0": "high = 15.0", "n_levels = 24": "n_levels = 16"}
    study = changed_study(tmp_path, INTERVALS | changes)
    output(capsys, "simulate", study, "--participants", 3, "--seed", 1, "--out", tmp_path / "d")
    found = json.loads(output(capsys, "analyse", tmp_path / "d", "--json"))
    assert warning(found, "6 of 6 cells with a threshold above the levels: only its lower bound is known")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({GUESSED: ""}, "procedure.guess_rates: found 0.5 by default in the task yes_no"),
        (INTERVALS, "procedure.guess_rates: found 0.5 by default in the task forced_choice, expected chance, 0.25"),
    ],
)
@pytest.mark.parametrize("command", ["simulate", "power", "dry run"])
def test_guess_rate_must_match_the_task(capsys, tmp_path, changes, message, command):
    path, out = changed_study(tmp_path, changes), tmp_path / "d"
    arguments = {
        "simulate": ("simulate", path, "--participants", 2, "--seed", 3, "--out", out),
        "power": ("power", path, "--effect", "frequency_hz: 2 dB", "--participants", 8, "--seed", 3),
        "dry run": ("run", path, "--participant", "P01", "--dry-run"),
    }
    assert message in refused(capsys, *arguments[command])
    assert not out.exists()


def test_stated_guess_rate_of_the_task_is_simulated(capsys, tmp_path):
    study = CASES / "stated_guess_rate.toml"
    output(capsys, "simulate", study, "--participants", 1, "--seed", 3, "--out", tmp_path / "d")


BENCH = """output = { kind = "null" }
sensors.force = { kind = "recorded", path = "force.csv", rate_hz = 1000.0 }
force = { sensor = "force", newtons_per_count = 0.001 }
"""


def test_check_counts_overload_values_as_lost_samples(capsys, monkeypatch, tmp_path):
    monkeypatch.setattr("tactometry.experiments.bench.preflight.LISTEN_S", 0.1)
    monkeypatch.setattr("tactometry.experiments.bench.preflight_checks.HEARD_S", 0.7)
    counts = [9.99999999e37 if n % 500 == 499 else 1000 + n % 3 for n in range(4000)]
    rows = "".join(f"{n / 1000},{count}\n" for n, count in enumerate(counts))
    (tmp_path / "force.csv").write_text(f"time_s,counts\n{rows}")
    (tmp_path / "bench.toml").write_text(BENCH)
    monkeypatch.chdir(tmp_path)
    _, _, out = call(capsys, "check", "--bench", "bench.toml", "--json")
    findings = {row["what"]: row for row in json.loads(out)["findings"] if row["part"] == "force"}
    assert findings["samples in the calibrated range"]["fine"] is False
    assert float(findings["mean, at rest"]["found"].removesuffix(" N")) < 2


def replaced(old, new, every=2):
    """The lines of the table with a text replaced in some rows."""
    return [HEAD, *(row.replace(old, new) if n % every == 0 else row for n, row in enumerate(ROWS))]


KEPT_SIDES = '[keep]\nside = ["a", "b"]\n'


def choices(correct, targets=(1, 2)):
    """Write forced choices with alternating targets that are all correct or all wrong."""
    pairs = [(targets[level % 2], targets[(level + (not correct)) % 2], level) for level in range(1, 41)]
    rows = [f"S{n},{level},{response},a,0.5,{target}" for n in (1, 2) for target, response, level in pairs]
    return [f"{HEAD},target", *rows]


@pytest.mark.parametrize(
    ("old", "new"),
    [
        *(("S1,", code) for code in ("S\u200b1\ufeff,", "S1 ,", " S1\u00a0,")),
        *((",a,", side) for side in (",a ,", ", a,", ',"a ",')),
        (",1,", ", 1 ,"),
    ],
)
def test_spaces_around_cells_change_no_result(capsys, tmp_path, old, new):
    expected = analysed(capsys, written(tmp_path), "side")
    found = analysed(capsys, written(tmp_path, replaced(old, new)), "side")
    assert (found["thresholds"], found["warnings"]) == (expected["thresholds"], expected["warnings"])


def test_space_bar_keeps_its_meaning_as_a_response(capsys, tmp_path):
    lines = [HEAD, *(row.replace(",1,", ", ,").replace(",0,", ",no ,") for row in ROWS)]
    found = analysed(capsys, written(tmp_path, lines, YES_NO + '[values.response]\n" " = 1\n"no " = 0\n'), "side")
    assert found["thresholds"] == analysed(capsys, written(tmp_path), "side")["thresholds"]


@pytest.mark.parametrize(
    ("lines", "column_map", "text"),
    [
        (replaced(",a,", ",A,", 4), YES_NO, "side has values that differ only in case or spaces: 'A' and 'a'"),
        (replaced(",0.5", ",500", 1), YES_NO, "32 rows have a 'latency_s' above a minute; if these are milliseconds"),
        (choices(False), CHOICE.format(2), "80 rows have answers of participants who score below chance"),
        ((HEAD, *ROWS), YES_NO + "n_alternatives = 2\n", "32 rows have an 'n_alternatives', which the task yes_no"),
        (replaced(",a,", ",A,", 4), YES_NO + KEPT_SIDES, "8 rows with side = 'A' not kept; expected"),
        (choices(True), CHOICE.format(3), "80 rows have an 'n_alternatives' above every response and target"),
    ],
)
def test_command_warns_of_doubtful_values(capsys, tmp_path, lines, column_map, text):
    assert len(warned(analysed(capsys, written(tmp_path, lines, column_map), "side"), text)) == 1


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
    found = analysed(capsys, written(tmp_path, lines, column_map), "side")
    assert not warned(found, "above a minute") + warned(found, "above every response")


def in_folder(tmp_path, **files):
    """Write files into a folder, each with the plain table unless it has a text."""
    plain = written(tmp_path).read_text("utf-8")
    (tmp_path / "d").mkdir()
    for name, text in files.items():
        (tmp_path / "d" / name).parent.mkdir(exist_ok=True)
        (tmp_path / "d" / name).write_text(text or plain, "utf-8")
    return tmp_path / "d"


@pytest.mark.parametrize("name", ["S1 (1).csv", "copy.tsv.csv"])
def test_copied_file_is_named_once(capsys, tmp_path, name):
    other = "\n".join(replaced("S", "T", 1)) + "\n"
    folder = in_folder(tmp_path, **{"S1.csv": "", name: "", "other.csv": other})
    (text,) = warned(analysed(capsys, folder, "side"), "the same content")
    assert text.startswith(" and ".join(sorted(["S1.csv", name])))


def test_lock_files_of_excel_are_ignored(capsys, tmp_path):
    folder = in_folder(tmp_path, **{"S1.csv": "", "~$S1.csv": "user"})
    assert analysed(capsys, folder, "side")["n_participants"] == 2


def test_tables_in_subfolders_are_refused_by_folder(capsys, tmp_path):
    message = refusal(capsys, in_folder(tmp_path, **{"day1/S1.csv": ""}), "side")
    assert "found tables only in its subfolders (day1), expected them in the folder itself" in message


@pytest.mark.parametrize(
    ("old", "new", "column_map", "message"),
    [
        (",1,", ",FALSE,", YES_NO, "below [values.response], for example: 'FALSE' = 0"),
        ("S1,5", "S1,nan", YES_NO, "column 'level': found 'nan', expected a finite number or nothing; mark it as"),
        (",1,", ",yes,", YES_NO, "below [values.response], for example: 'yes' = 1"),
        (",1,", ",#N/A,", YES_NO, "mark it as missing in a column map (--columns): missing = ['#N/A']"),
        (",0.5", ",nan", YES_NO, "column 'latency_s': found 'nan', expected a finite number or nothing; mark it as"),
        (",0.5", ",0.5", CHOICE.format(1), "column 'n_alternatives': found '1', expected a whole number from 2"),
        (",0.5", ",0.5", YES_NO + "level = 3\n[columns]\nlevel='x'\n", "found definitions in columns and constants"),
        ("S1,", "S1,", YES_NO + '[columns]\nlevel = "LEVEL"\n', "assigns to 'level'; did you mean 'level'?"),
        (",0.5", ",1.500", 'decimal = ","\n' + YES_NO, "column 'latency_s': found '1.500', expected a decimal comma"),
    ],
)
def test_refusal_names_cause_and_remedy(capsys, tmp_path, old, new, column_map, message):
    separator = 'separator = ";"\n' if "decimal" in column_map else ""
    lines = [line.replace(",", ";") if separator else line for line in replaced(old, new, 1)]
    table = written(tmp_path, lines, separator + column_map)
    assert message in refusal(capsys, table, "side")


def test_both_letters_mu_state_micrometres(capsys, tmp_path):
    maps = [f'{YES_NO}[units]\nlevel = "{mu}m"\n' for mu in ("\u00b5", "\u03bc")]
    one, other = (analysed(capsys, written(tmp_path, column_map=text), "side")["thresholds"] for text in maps)
    assert one == other


def test_numbers_of_a_map_keep_every_digit(capsys, tmp_path):
    levels = {str(level): 1234567 + level / 8 for level in range(2, 10)}
    cells = [row.split(",", 2) for row in ROWS]
    numbers = written(tmp_path, [HEAD, *(f"{code},{levels[level]},{rest}" for code, level, rest in cells)])
    expected = analysed(capsys, numbers, "side")["thresholds"]
    map_of_words = f"{YES_NO}[values.level]\n" + "".join(f"w{level} = {number}\n" for level, number in levels.items())
    words = written(tmp_path, [HEAD, *(f"{code},w{level},{rest}" for code, level, rest in cells)], map_of_words)
    assert analysed(capsys, words, "side")["thresholds"] == expected


def test_refused_counts_name_each_row_once(capsys, tmp_path):
    rows = [f"S1,{level},2,9" for level in (1, "Total", "none of it")]
    table = written(tmp_path, ["participant,level,n_positive,n_trials", *rows])
    assert "row 3 and 1 more (4), column 'level': found 'Total'" in refusal(capsys, table)


@pytest.mark.parametrize(("code", "ours"), [("sub-01", "sub01"), ("P_01", "P01")])
def test_code_is_written_without_separators_with_a_warning(capsys, tmp_path, code, ours):
    found = analysed(capsys, written(tmp_path, replaced("S1,", f"{code},", 1)), "side")
    assert ours in {cell["participant"] for cell in found["thresholds"]}
    assert f"{code} as {ours}; set others in [values.participant]" in warning(found, "separators")


@pytest.mark.parametrize(
    ("codes", "message"),
    [
        (("P_01", "P01"), "found the participants 'P01' and 'P_01'"),
        (("Bob Smith",), "below [values.participant]: 'Bob Smith' = 'P1'"),
    ],
)
def test_code_is_refused_with_the_line_to_write(capsys, tmp_path, codes, message):
    table = written(tmp_path, ["participant,level,response", *(f"{code},1,0" for code in codes)])
    assert message in refusal(capsys, table)
