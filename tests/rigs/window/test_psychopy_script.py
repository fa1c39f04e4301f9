"""The documented PsychoPy script, run in a real window."""

import json

import pytest
from command_line import call
from page_blocks import texts_of
from script_bench import run_script
from tables import rows_of

from tactometry.analysis.reading.column_map import read_column_map
from tactometry.analysis.reading.trials import read_trials, used_rows
from tactometry.errors import InvalidParameter
from tactometry.experiments.psychopy_plugin.script import PsychoPyStudy
from tactometry.questionnaire import load

N_TRIALS = 4


@pytest.fixture(scope="module")
def sitting(display, tmp_path_factory):
    """Result of the documented script with an emulated hand that presses 1 N."""
    folder = tmp_path_factory.mktemp("script")
    [script] = texts_of("how_to/psychopy.md", "python")
    (folder / "script.py").write_text(script, encoding="utf-8")
    return folder, *run_script(folder, display, "script.py", ["y", "4", "Return"] * 1000)


def test_psychopy_script_records_trials_and_questionnaire(sitting):
    folder, status, output, errors = sitting
    assert status == 0, errors
    assert output.splitlines()[-1] == "threshold None censored_below"  # everything was felt
    rows = rows_of(folder / "P01.csv")
    trials = rows[:N_TRIALS]
    answers = [(row["quest.response"], row["quest.valid"], row["quest.force_mean_n"]) for row in trials]
    assert answers == [("1", "1", "1.0")] * N_TRIALS
    assert [row["quest.intensity"] for row in trials] == [row["quest.level_delivered"] for row in trials]
    answers = {row["attrakdiff.item"]: row["attrakdiff.response"] for row in rows[N_TRIALS:]}
    assert answers == {item.id: "4.0" for item in load("attrakdiff").items}
    assert len(list((folder / "played").glob("*.npz"))) == N_TRIALS + 1


def test_script_data_load_with_documented_column_map(sitting):
    folder, *_ = sitting
    trials = read_trials(folder / "P01.csv", within=[], column_map=read_column_map(folder / "columns.toml"))
    used = used_rows(trials)
    assert len(used) == N_TRIALS
    assert set(used["participant"]) == {"P01"}
    assert set(used["level_unit"]) == {"dB re 1 V peak"}


@pytest.fixture
def study(screen):
    with PsychoPyStudy(screen._window, "tutorial") as made:
        yield made


def test_unknown_cell_is_named(study):
    for factors, found in ({}, "none"), ({"frequency_hz": 61}, "frequency_hz = 61"):
        with pytest.raises(InvalidParameter, match=f"found {found}, expected the factors of a cell: frequency_hz"):
            study.procedure(**factors)


def test_background_stimulus_ends_after_its_duration(study):
    beside, n_looks = study.begin(34.0, frequency_hz=60), 0
    while beside.look():
        n_looks += 1
    assert n_looks > 1
    assert not beside.cut
    assert beside.end().level_delivered is None  # there is no output


def test_unknown_questionnaire_is_refused(study):
    with pytest.raises(InvalidParameter, match="found 'attrackdiff', expected one of .*; did you mean 'attrakdiff'"):
        study.questionnaire("attrackdiff")


def test_questionnaire_scores_with_documented_column_map(sitting, capsys):
    folder, *_ = sitting
    words = ("--columns", folder / "attrakdiff.toml", "--within", "", "--json")
    status, _, told = call(capsys, "analyse", folder / "P01.csv", *words)
    assert status == 0
    [scores] = json.loads(told)["questionnaires"].values()
    means = {row["dimension"]: row["mean"] for row in scores}
    assert means == dict.fromkeys(("ATT", "HQ", "HQI", "HQS", "PQ"), 0.0)  # every answer was the scale midpoint
