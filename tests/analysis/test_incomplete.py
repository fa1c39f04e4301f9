"""Tests of incomplete, duplicated and edited tables, and of dropped frames."""

import json
import re
from pathlib import Path

import analysis_data
import numpy as np
import pandas as pd
import pytest
from command_line import output, refused
from places import RECORDED
from tutorial_session import journal_of, live

from tactometry.analysis.pipeline import analyse
from tactometry.analysis.reading.quality import frames, quality, with_frames
from tactometry.analysis.reading.trials import read_trials
from tactometry.errors import InvalidFile
from tactometry.experiments.data_sets.session_files import edit_warnings
from tactometry.session.event import COLUMNS, Event

PAIR = {"side": "a", "procedure": "pairs", "level": "1", "task": "preference"}


def written(path: Path, rows) -> Path:
    file = path / "t.csv"
    pd.DataFrame(rows).to_csv(file, index=False)
    return file


def pairs(**changed: str):
    items = [("x", "y"), ("y", "z"), ("z", "x")] * 4
    return [
        {"participant": code, "trial": str(n + 1), **PAIR, "item": a, "item_b": b, "response": str(1 + n % 2)} | changed
        for code in ("P1", "P2")
        for n, (a, b) in enumerate(items)
    ]


@pytest.mark.parametrize("missing", [("item",), ("item_b",), ("item", "item_b")])
def test_preference_without_items_is_rejected(tmp_path, capsys, missing):
    rows = [{name: cell for name, cell in row.items() if name not in missing} for row in pairs()]
    message = refused(capsys, "analyse", written(tmp_path, rows), "--report", tmp_path / "r.html")
    assert f"t.csv: found no column {missing[0]!r}" in message
    assert message.endswith("expected the first item of each pair in 'item' and the second in 'item_b'")


@pytest.mark.parametrize(
    ("changed", "items"), [({"item": ""}, "'' and 'y'"), ({"item": "x", "item_b": "x"}, "'x' and 'x'")]
)
def test_preference_with_empty_or_equal_items_is_rejected(tmp_path, capsys, changed, items):
    message = refused(capsys, "analyse", written(tmp_path, pairs(**changed)))
    assert f"t.csv, row 2 and 23 more (3, 4, 5, 6, ...): found the items {items}, expected the first item" in message


@pytest.mark.parametrize("task", ["yes_no", "forced_choice", "comparison"])
def test_catch_trials_alone_are_reported_without_threshold(tmp_path, capsys, task):
    rows = [
        {"participant": code, "trial": n + 1, "side": "a", "procedure": "constant", "level": "", "task": task}
        | {"response": 1 + n % 2 if task == "forced_choice" else n % 2, "catch": 1, "target": 1}
        for code in ("P1", "P2")
        for n in range(8)
    ]
    arguments = ("--report", tmp_path / "r.html", "--figures", tmp_path / "f", "--json")
    found = json.loads(output(capsys, "analyse", written(tmp_path, rows), *arguments))
    assert {(row["status"], row["n_catch"]) for row in found["thresholds"]} == {("no_data", 8)}
    assert "no_data" in (tmp_path / "r.html").read_text()


def test_repeated_questionnaire_touch_counts_once(tmp_path):
    answer = {"participant": "P1", "session": 1, "block": 1, "trial": 1, "pattern": "P0", "procedure": "attrakdiff"}
    answer |= {"level": 28, "task": "rating", "response": 4, "valid": 1}
    failed = answer | {"item": "", "response": "", "valid": 0, "attempt": 1}
    items = [answer | {"item": f"PQ{n}", "attempt": 2} for n in range(1, 8)]
    alone = [answer | {"trial": 2, "item": f"PQ{n}", "attempt": 1} for n in range(1, 8)]
    table = quality(read_trials(written(tmp_path, [failed, *items, *alone])))
    assert table[["n_repeated", "n_invalid"]].to_numpy().tolist() == [[1, 1]]


def test_quality_table_counts_each_row_once(tmp_path):
    """Three attempts of one trial; then a false alarm, a rejection, an unanswered and an invalid catch trial."""
    header = "participant,trial,force_n,procedure,level,task,response,valid,attempt,catch"
    attempts = [f"P01,1,1,x,3,yes_no,1,{int(n == 3)},{n},0" for n in (1, 2, 3)]
    catches = [
        f"P01,{n},1,x,,yes_no,{answer}" for n, answer in ((2, "1,1,1,1"), (3, "0,1,1,1"), (4, ",1,1,1"), (5, "1,0,1,1"))
    ]
    file = tmp_path / "t.csv"
    file.write_text("\n".join([header, *attempts, *catches]))
    (row,) = quality(read_trials(file)).to_dict("records")
    counts = {name.removeprefix("n_"): row[name] for name in row if name.startswith("n_")}
    of_catch = {"catch": 2, "false_alarms": 1, "unanswered": 1}
    assert counts == {"rows": 7, "practice": 0, "invalid": 3, "repeated": 2} | of_catch
    assert row["false_alarm_rate"] == 0.5


@pytest.mark.parametrize(
    "factor", [1e-5, 400.0, *(pytest.param(factor, marks=pytest.mark.slow) for factor in (0.01, 1.0))]
)
def test_thresholds_keep_three_digits_in_all_output(tmp_path, capsys, factor):
    rows = [
        {"participant": f"P{person}", "trial": 100 * x + n, "side": side, "procedure": "c", "level": factor * x}
        | {"level_unit": "V", "task": "comparison", "response": int(n % 10 < 2 * x - person - (side == "b"))}
        for person in (1, 2, 3)
        for side in "ab"
        for x in range(1, 7)
        for n in range(20)
    ]
    text = output(capsys, "analyse", written(tmp_path, rows), "--report", tmp_path / "r.html")
    group = pd.read_csv(tmp_path / "r_tables/group_pse.csv")
    for row in group.itertuples():
        printed = re.match(r"(\S+) \[(\S+), (\S+)\]", row.text).groups()
        exact = [row.mean, row.mean_low, row.mean_high]
        assert [float(number) for number in printed] == pytest.approx(exact, rel=0.005)
        assert row.text.split(" (")[0] in " ".join(text.split())
    (sd,) = re.findall(r"thresholds (\S+) V", text)
    assert float(sd) > 0


@pytest.fixture
def data_set(tmp_path) -> Path:
    live(tmp_path / "d")
    return tmp_path / "d"


def table_of(root: Path) -> Path:
    return next((root / "data").glob("*_data.csv"))


def test_unedited_table_has_no_warning(data_set, capsys):
    assert edit_warnings(data_set) == edit_warnings(table_of(data_set)) == []
    assert not journal_warnings(capsys, data_set)


def journal_warnings(capsys, path):
    warnings = json.loads(output(capsys, "analyse", path, "--json"))["warnings"]
    return [text for text in warnings if "journal" in text or "the line is damaged" in text]


@pytest.mark.parametrize("single", [False, True])
def test_edited_answer_has_warning_in_all_output(data_set, capsys, single):
    file = table_of(data_set)
    file.write_bytes(file.read_bytes().replace(b",yes_no,1,", b",yes_no,0,", 1))
    path = file if single else data_set
    text = output(capsys, "analyse", path, "--report", data_set.parent / "r.html")
    sentence = "1 of 1 trials file differs from its journal, but the tables are analysed unchanged: "
    assert sentence in " ".join(text.split()) + " "
    assert sentence in (data_set.parent / "r.html").read_text()
    (warning,) = journal_warnings(capsys, path)
    assert re.search(rf"{re.escape(file.name)}, row \d+: found a row that differs from the journal", warning)


@pytest.mark.parametrize(
    ("edit", "warning"),
    [
        (lambda text: text.replace("latency_s", "latenz_s", 1), "row 1: found other columns than"),
        (lambda text: "\n".join(text.split("\n")[:-3]) + "\n", "lacks the last 2 rows of the journal"),
        (lambda text: text + text.split("\n")[-2] + "\n", "found a row that differs from the journal"),
    ],
)
def test_changed_columns_and_rows_have_warning(data_set, edit, warning):
    file = table_of(data_set)
    file.write_text(edit(file.read_text()))
    assert warning in edit_warnings(data_set)[0]


def test_damaged_journal_has_warning_without_stopping_analysis(data_set, capsys):
    journal_of(data_set).write_bytes(journal_of(data_set).read_bytes().replace(b'"at_s":2.0', b'"at_s":3.0', 1))
    assert any("the line is damaged" in warning for warning in journal_warnings(capsys, data_set))


def test_data_sets_of_earlier_versions_have_no_warning():
    with_journals = [path for path in RECORDED.iterdir() if (path / "journals").is_dir()]
    assert with_journals
    assert {path.name: edit_warnings(path) for path in with_journals if edit_warnings(path)} == {}


def event(kind, **facts) -> str:
    return "\t".join(Event(kind, 1.0, facts=facts).cells())


def trial(n, dropped, longest_s) -> str:
    return event("trial", trial=1, n_frames=n, n_dropped_frames=dropped, frame_interval_max_s=longest_s)


@pytest.fixture
def with_events(tmp_path):
    (tmp_path / "data").mkdir()
    (tmp_path / "journals").mkdir()
    truth = {(f"P0{p}", (0.5,)): 20.0 for p in (1, 2, 3)}
    analysis_data.write_study(tmp_path / "data" / "all_data.csv", truth, ["force_n"], rng=np.random.default_rng(), n=4)
    interrupted = [trial(500, 20, 0.08), event("remark", text="late"), trial(500, 0, 0.017)]
    for code, rows in {"P01": interrupted, "P02": [trial(1000, 0, 0.018)]}.items():
        text = "\n".join(["\t".join(column.name for column in COLUMNS), *rows]) + "\n"
        (tmp_path / "journals" / f"participant-{code}_session-1_study-x_events.tsv").write_text(text)
    return tmp_path


def test_dropped_frames_are_summed_with_warning(with_events) -> None:
    found = analyse(with_events)
    quality = found.tables["quality"].set_index("participant")
    assert quality.loc["P01", ["n_frames", "n_dropped_frames"]].tolist() == [1000, 20]
    assert quality["frame_interval_max_s"]["P01"] == 0.08
    assert quality["n_dropped_frames"]["P02"] == 0
    assert quality["n_dropped_frames"].isna()["P03"]
    assert "more than 1 % of screen frames dropped: P01 20 of 1020" in found.warnings


def test_quality_is_unchanged_without_events(tmp_path) -> None:
    quality = pd.DataFrame({"participant": ["A"]})
    assert with_frames(quality, frames(tmp_path)) is quality
    assert frames(tmp_path / "trials.csv").empty


def test_a_damaged_file_of_events_is_refused(with_events) -> None:
    next((with_events / "journals").iterdir()).write_text("onset\tduration\n1\t2\n")
    damaged = r"_events.tsv: found a damaged file of events \('trial_type'\), expected the columns"
    with pytest.raises(InvalidFile, match=damaged):
        frames(with_events)
