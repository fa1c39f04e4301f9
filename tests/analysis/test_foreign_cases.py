"""Tests of other programs' files with defects and known results."""

import json

import pytest
from command_line import call, output, refused
from foreign_cases import MAP, write_case
from places import FOREIGN

CASES = FOREIGN / "cases"
YES_NO = "6.07 [5.46, 6.69] (n = 4)"
NEGATIVE = "-5.70 [-6.84, -4.56] (n = 3)"


def analysed(capsys, table, column_map=None, within=""):
    column_map = column_map or (table.parent / "map.toml")
    return json.loads(output(capsys, "analyse", table, "--columns", column_map, "--within", within, "--json"))


def mean(found):
    return found["outcomes"][0]["group"][0]["text"]


def warning(found, beginning):
    return next(warning for warning in found["warnings"] if beginning in warning)


@pytest.mark.parametrize(
    "case",
    [
        *("plain", "csv_beside_json", "counts", "code_in_name", "code_within_name", "row_numbers_of_r"),
        *("row_numbers_of_pandas", "sep_line", "json_as_txt", "folder_of_json_as_txt", "column_twice"),
        *("carriage_returns", "line_in_a_cell", "bids", "missing_latency", "unicode_minus"),
    ],
)
def test_threshold_is_right_for_each_case(capsys, tmp_path, case):
    expected = NEGATIVE if case in ("missing_latency", "unicode_minus") else YES_NO
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
    path = write_case(case, tmp_path)
    assert message in refused(capsys, "analyse", path, "--columns", tmp_path / "map.toml", "--within", "")


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
    lines = '[constants]\ntask = "forced_choice"\n[columns]\nn_alternatives = "n_afc"\n'
    (tmp_path / "map.toml").write_text(lines)
    said = refused(capsys, "analyse", table, "--columns", tmp_path / "map.toml", "--within", "")
    assert "column 'n_alternatives': found 2 and 4 in one condition" in said
    found = analysed(capsys, table, within="n_alternatives")
    assert {row["guess_rate"] for row in found["thresholds"]} == {0.5, 0.25}


def test_few_answers_do_not_lower_alternatives(capsys, tmp_path):
    sides = [("a", n, n % 4 + 1) for n in range(40)] + [("b", n, n % 3 + 1) for n in range(6)]
    rows = [
        f"S1,{level},{side},{target if 4 * level > 2 * n % 13 else 1 + target % 3},{target}"
        for side, n, target in sides
        for level in (1, 2, 3)
    ]
    table = written(
        tmp_path, ["participant,level,side,response,target", *rows], '[constants]\ntask = "forced_choice"\n'
    )
    assert {row["guess_rate"] for row in analysed(capsys, table, within="side")["thresholds"]} == {0.25}


def test_row_number_counts_the_sep_line(capsys, tmp_path):
    table = write_case("sep_line", tmp_path)
    table.write_text(table.read_text().replace("S01,2,y", "S01,loud,n", 1))
    assert "t.csv, row 3, column 'level': found 'loud'" in refused(
        capsys, "analyse", table, "--columns", tmp_path / "map.toml", "--within", ""
    )


def test_folder_ignores_case_of_file_endings(capsys, tmp_path):
    folder = write_case("csv_beside_json", tmp_path)
    (folder / "S04.csv").rename(folder / "S04.CSV")
    assert mean(analysed(capsys, folder)) == YES_NO


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
    table = tmp_path / "t.csv"
    rows = [f"{code},{level},n,{part}" for code, part in (("S1", "test"), ("S2", "Test")) for level in (1, 2, 3)]
    table.write_text("\n".join(["participant,level,response,part", *rows]))
    (tmp_path / "map.toml").write_text(MAP + '[keep]\npart = ["test"]\n')
    assert "no trial was read of S2" in warning(analysed(capsys, table), "no trial was read")


TRIALS = [f"{code},{level},{'y' if level > 2 else 'n'}" for code in ("S1", "S2") for level in (1, 2, 3)]


def test_participants_without_an_answer_are_named(capsys, tmp_path):
    table = written(tmp_path, ["participant,level,response", *TRIALS, "S3,1,", "S3,2,"], MAP)
    found = analysed(capsys, table)
    assert warning(found, "no valid answers") == "no valid answers, and therefore no results, of S3"
    assert warning(found, "without an answer").startswith(
        "2 rows without an answer were left out (the first: t.csv, row 8)"
    )


def test_choices_without_a_right_answer_are_counted(capsys, tmp_path):
    rows = [f"S1,{level},1,{1 if level > 1 else ''}" for level in (1, 2, 3)]
    table = written(tmp_path, ["participant,level,response,target", *rows], '[constants]\ntask = "forced_choice"\n')
    assert warning(analysed(capsys, table), "neither 'correct'").startswith("1 row of a forced choice")


def test_choices_need_correct_or_target(capsys, tmp_path):
    table = written(tmp_path, ["participant,level,response", "S1,1,1"], '[constants]\ntask = "forced_choice"\n')
    said = refused(capsys, "analyse", table, "--columns", tmp_path / "map.toml", "--within", "")
    assert said.endswith("forced choices need a column 'correct' or 'target'")


def test_files_sharing_a_participant_are_named(capsys, tmp_path):
    for name in ("results_1.csv", "results_2.csv"):
        (tmp_path / name).write_text("level,response\n1,n\n2,y\n3,y\n")
    (tmp_path / "map.toml").write_text(MAP + '[from_name]\nparticipant = "*_"\n')
    said = warning(analysed(capsys, tmp_path, tmp_path / "map.toml"), "from_name")
    assert said == "files read as one participant, results (from_name): results_1.csv, results_2.csv"


def written(tmp_path, rows, lines):
    """A table and its map."""
    (tmp_path / "t.csv").write_text("\n".join(rows) + "\n")
    (tmp_path / "map.toml").write_text(lines)
    return tmp_path / "t.csv"


CHOICE = '[constants]\ntask = "forced_choice"\nn_alternatives = {}\n'
COUNTS = '[columns]\nn_positive = "k"\nn_trials = "n"\n'
CORRECT = {1: 10, 2: 12, 3: 16, 4: 19, 5: 20}


@pytest.mark.parametrize("n_alternatives", [2, 4])
def test_trials_and_counts_have_same_threshold(capsys, tmp_path, n_alternatives):
    counts = [f"S1,{level},{k},20" for level, k in CORRECT.items()]
    trials = [f"S1,{level},{int(n < k)}" for level, k in CORRECT.items() for n in range(20)]
    constants = CHOICE.format(n_alternatives)
    of_counts = analysed(capsys, written(tmp_path, ["participant,level,k,n", *counts], constants + COUNTS))
    of_trials = analysed(capsys, written(tmp_path, ["participant,level,correct", *trials], constants))
    first, second = (found["thresholds"][0] for found in (of_counts, of_trials))
    assert first["threshold"] == second["threshold"]
    assert first["guess_rate"] == second["guess_rate"] == 1 / n_alternatives
    assert (first["n_trials"], first["residual_order_p"]) == (100, None)


def test_correct_alone_is_refused_without_alternatives(capsys, tmp_path):
    table = written(tmp_path, ["participant,level,correct", "S1,1,1"], '[constants]\ntask = "forced_choice"\n')
    said = refused(capsys, "analyse", table, "--columns", tmp_path / "map.toml", "--within", "")
    assert "set n_alternatives = 2 in [constants] of the column map" in said


@pytest.mark.parametrize(("k", "n"), [(13, 12), (-1, 12), (1.5, 12), ("", 12), (1, "")])
def test_impossible_counts_are_refused_with_their_row(capsys, tmp_path, k, n):
    rows = ["participant,level,k,n", "S1,1,1,12", f"S1,2,{k},{n}"]
    table = written(tmp_path, rows, '[constants]\ntask = "yes_no"\n' + COUNTS)
    said = refused(capsys, "analyse", table, "--columns", tmp_path / "map.toml", "--within", "")
    assert f"t.csv, row 3: found {k or 'nothing'} of {n or 'nothing'} (n_positive of n_trials)" in said


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
    table = written(tmp_path, [f"participant,level,response,{header}", *rows], '[constants]\ntask = "forced_choice"\n')
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
    import unicodedata

    rows = ["participant,größe,level,response", *(f"S1,groß,{level},n" for level in (1, 2, 3))]
    table = written(tmp_path, [unicodedata.normalize("NFD", row) for row in rows], MAP)
    assert analysed(capsys, table, within="größe")["factors"] == ["größe"]


GUESSED = "guess_rates = [0.02]\n"
INTERVALS = {GUESSED: "", 'kind = "yes_no"\ncatch_rate = 0.2': 'kind = "forced_choice"\nn_intervals = 4'}


def changed_study(folder, changes):
    text = (CASES / "stated_guess_rate.toml").read_text()
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    (folder / "study.toml").write_text(text)
    return folder / "study.toml"


ADJUSTED = CASES / "adjustment.toml"


def test_reason_names_the_factor_between_participants(capsys):
    found = analysed(capsys, CASES / "between_groups.csv", ADJUSTED, within="A")
    outcome = found["outcomes"][0]
    assert outcome["primary"]["reason"] == (
        "by default: every participant has a value, and A differs between participants"
    )
    assert outcome["anova"][0]["F"] == pytest.approx(2.33, abs=0.005)
    assert warning(found, "--within A: each participant has only one level")


def test_group_of_one_has_no_anova(capsys):
    found = analysed(capsys, CASES / "one_in_a_group.csv", ADJUSTED, within="A,group")
    expected = "no analysis of variance: group = g2: found one participant, expected at least 2 in each group"
    assert expected in found["outcomes"][0]["notes"]


def test_design_without_complete_participants_names_its_empty_cells(capsys):
    found = analysed(capsys, CASES / "not_one_complete.csv", ADJUSTED, within="A,B")
    assert warning(found, "have no valid trial").startswith("8 of ")
    assert found["outcomes"][0]["primary"]["analysis"] == "censored_anova"


def test_threshold_above_levels_has_lower_bound(capsys, tmp_path):
    study = changed_study(
        tmp_path,
        {
            **INTERVALS,
            "n_intervals = 4": "n_intervals = 2",
            "high = 46.0": "high = 15.0",
            "n_levels = 24": "n_levels = 16",
        },
    )
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
    output(
        capsys, "simulate", CASES / "stated_guess_rate.toml", "--participants", 1, "--seed", 3, "--out", tmp_path / "d"
    )


BENCH = """[output]
kind = "null"

[sensors.force]
kind = "recorded"
path = "force.csv"
rate_hz = 1000.0

[force]
sensor = "force"
newtons_per_count = 0.001
"""


def test_check_counts_overload_values_as_lost_samples(capsys, monkeypatch, tmp_path):
    monkeypatch.setattr("tactometry.experiments.bench.preflight.LISTEN_S", 0.1)
    monkeypatch.setattr("tactometry.experiments.bench.preflight_checks.HEARD_S", 0.7)
    counts = [9.99999999e37 if n % 500 == 499 else 1000 + n % 3 for n in range(4000)]
    (tmp_path / "force.csv").write_text(
        "time_s,counts\n" + "".join(f"{n / 1000},{count}\n" for n, count in enumerate(counts))
    )
    (tmp_path / "bench.toml").write_text(BENCH)
    monkeypatch.chdir(tmp_path)
    _, _, out = call(capsys, "check", "--bench", "bench.toml", "--json")
    said = {row["what"]: row for row in json.loads(out)["findings"] if row["part"] == "force"}
    lost = said["samples in the calibrated range"]
    assert lost["fine"] is False
    assert float(said["mean, at rest"]["found"].removesuffix(" N")) < 2
