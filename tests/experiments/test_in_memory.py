"""Studies simulated in memory equal those on the disk."""

from pathlib import Path

import pandas as pd
import pytest
from command_line import call
from pandas.api.types import is_numeric_dtype

from tactometry.analysis.pipeline import analyse_trials
from tactometry.analysis.reading.trials import read_trials
from tactometry.experiments.sessions import in_memory
from tactometry.experiments.sessions.in_memory import NOWHERE, simulated_session, simulated_trials, trials_of
from tactometry.experiments.sessions.recording import Who
from tactometry.experiments.sessions.simulation import Simulation
from tactometry.experiments.study.study_file import load
from tactometry.records.journal import read

STUDIES = ("tutorial", "time-reversal-patterns", "time-reversal-localisation", "hybrid-button")


def small_study(name: str) -> Simulation:
    return Simulation(load(name)[1], name, NOWHERE, n_participants=2, seed=3)


@pytest.mark.parametrize("name", STUDIES)
def test_trials_in_memory_equal_recorded_trials(capsys, tmp_path, name):
    assert call(capsys, "simulate", name, "--participants", 2, "--seed", 3, "--out", tmp_path)[0] == 0
    kept, study = read_trials(tmp_path), small_study(name)
    made = simulated_trials(study.experiment(), study.sessions())
    assert (made.factors, made.n_files, made.notes) == (kept.factors, kept.n_files, kept.notes)
    in_folder = made.rows.assign(source=[str(tmp_path / Path(file).relative_to(NOWHERE)) for file in made.rows.source])
    pd.testing.assert_frame_equal(in_folder[list(kept.rows.columns)], kept.rows)
    assert call(capsys, "replay", tmp_path)[:2] == (0, "")


@pytest.mark.parametrize("name", STUDIES)
def test_typed_trials_equal_rendered_text(monkeypatch, name):
    study = small_study(name)
    typed = simulated_trials(study.experiment(), study.sessions())
    monkeypatch.setattr(in_memory, "NUMERIC", frozenset())
    rendered = simulated_trials(study.experiment(), study.sessions())
    pd.testing.assert_frame_equal(typed.rows, rendered.rows, check_exact=True)
    assert (typed.factors, typed.notes) == (rendered.factors, rendered.notes)


@pytest.mark.parametrize(
    ("name", "values", "is_typed"),
    [
        ("level", [1.5, None, 2], True),
        ("valid", [True, False, None], True),
        ("level", [float("nan"), 1.0], False),
        ("level", ["1.5"], False),
        ("response", [1, 0], False),
    ],
)
def test_column_is_typed_when_every_number_is_finite(name, values, is_typed):
    assert is_numeric_dtype(in_memory._column(name, values)) is is_typed


def test_trials_in_memory_equal_on_two_processes():
    study = small_study("tutorial")
    here, spread = simulated_trials(study.experiment(), study.sessions()), trials_of(study, n_jobs=2)
    assert (spread.factors, spread.n_files, spread.notes) == (here.factors, here.n_files, here.notes)
    pd.testing.assert_frame_equal(spread.rows, here.rows)


def test_session_in_memory_equals_journal(capsys, tmp_path):
    assert call(capsys, "simulate", "tutorial", "--participants", 1, "--seed", 3, "--out", tmp_path)[0] == 0
    (journal,) = (tmp_path / "journals").glob("*.jsonl")
    assert simulated_session(small_study("tutorial").experiment(), Who("P01", seed=3)) == read(journal).trials


def test_trials_in_memory_are_analysed_as_simulated(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    study = small_study("tutorial")
    analysis = analyse_trials(simulated_trials(study.experiment(), study.sessions()))
    assert analysis.origin.is_simulated
    assert len(analysis.table("thresholds")) == 4
    assert list(tmp_path.iterdir()) == []
