"""Share of simulated participants with both thresholds of the tutorial."""

import pytest

from tactometry.analysis.pipeline import analyse_trials
from tactometry.experiments.sessions.in_memory import NOWHERE, trials_of
from tactometry.experiments.sessions.simulation import Simulation
from tactometry.experiments.study.study_file import load


def statuses(seed, n_participants):
    """Return the fit statuses of each participant."""
    trials = trials_of(Simulation(load("tutorial")[1], "tutorial", NOWHERE, n_participants, seed))
    estimates = analyse_trials(trials).estimates
    codes = {one.cell.participant for one in estimates}
    return [[one.fit.status for one in estimates if one.cell.participant == code] for code in sorted(codes)]


@pytest.mark.parametrize(
    ("seeds", "n_participants"), [((2,), 10), pytest.param(range(1, 41), 5, marks=pytest.mark.slow)], ids=["few", "40"]
)
def test_tutorial_finds_both_thresholds_of_most_participants(seeds, n_participants):
    of_all = [each for seed in seeds for each in statuses(seed, n_participants)]
    assert sum(each == ["ok", "ok"] for each in of_all) >= 0.95 * len(of_all)
