"""Recovery of true thresholds from simulated journals and trials files."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.stats import binom, norm
from soak import SOAK

from tactometry.analysis.pipeline import analyse, analyse_trials
from tactometry.contact import Contact
from tactometry.experiments.sessions.in_memory import NOWHERE, trials_of
from tactometry.experiments.sessions.simulation import Simulation, simulate
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.study_file import builtin, load, parse

N = 1000 if SOAK else 60
AT_1E_4 = 3.72
"""One-sided normal quantile of 1e-4."""

ONE_CELL = (
    builtin()["electrovibration-threshold"]
    .read_text("utf-8")
    .replace("force_n = [0.5, 1.5, 3.0] ", "force_n = [1.5] ")
    .replace("[30, 60, 120, 180, 240, 320, 480]", "[240]")
    .encode()
)
HEAD, _, TAIL = ONE_CELL.partition(b"[procedure]")
CONSTANT = (
    b'[procedure]\nkind = "constant_stimuli"\nlevels = [22, 24, 26, 28, 30, 32, 34, 36, 38]\nrepeats = 6\n\n[limits]'
)
PROCEDURES = {"staircase": ONE_CELL, "constant stimuli": HEAD + CONSTANT + TAIL.partition(b"[limits]")[2]}


def true_threshold(experiment, participant, seed):
    """Return the level whose yes rate is halfway from false alarms to 1."""
    observer = experiment.simulated_participant(participant, seed)
    sensation, condition = experiment.sensation(), experiment.conditions[0]
    stimulus = experiment.bank[condition.stimulus]
    contact = Contact(condition.touch.force_n, condition.touch.speed_m_per_s)
    (feeling,) = experiment.feelings(participant, seed).values()
    criterion = observer.criterion + observer.bias

    def excess(level):
        felt_db = feeling.felt_db(level, lambda: sensation.sensation_db(stimulus.at(level), contact))
        return norm.cdf(observer.d_prime(felt_db) - criterion) - (1 + norm.sf(criterion)) / 2

    return brentq(excess, -40, 46)


@pytest.fixture(scope="module", params=PROCEDURES)
def recovered(request, tmp_path_factory):
    toml, root = PROCEDURES[request.param], tmp_path_factory.mktemp("recovery")
    seed = int(np.random.default_rng().integers(2**31))
    print(f"seed {seed}")
    list(simulate(Simulation(toml, "study", root, N, seed)))
    estimates = analyse(root).tables["thresholds"].set_index("participant")
    experiment = wire(parse(toml, "study"), "study")
    truth = {code: true_threshold(experiment, code, seed) for code in estimates.index}
    return estimates.assign(truth=truth)


@pytest.mark.slow
def test_most_cells_have_a_threshold(recovered):
    assert recovered["threshold"].notna().sum() >= binom.ppf(1e-4, len(recovered), 0.9)


@pytest.mark.slow
def test_mean_bias_is_small(recovered):
    kept = recovered.dropna(subset=["threshold"])
    errors = kept["threshold"] - kept["truth"]
    bound = 0.15 * kept["truth"].std()
    assert abs(errors.mean()) <= bound + AT_1E_4 * errors.std() / np.sqrt(len(errors))


@pytest.mark.slow
def test_intervals_contain_ground_truth(recovered):
    inside = (recovered["interval_low"].fillna(-np.inf) <= recovered["truth"]) & (
        recovered["truth"] <= recovered["interval_high"].fillna(np.inf)
    )
    assert inside.mean() >= 0.935 - AT_1E_4 * np.sqrt(0.065 * 0.935 / len(inside))


def test_resting_finger_is_at_chance(tmp_path):
    study = parse(ONE_CELL, "study")
    experiment = wire(replace(study, touch={**study.touch, "speed_m_per_s": 1e-20}), "study")
    sensation, condition = experiment.sensation(), experiment.conditions[0]
    signal = experiment.bank[condition.stimulus].at(46.0)
    observer = experiment.people.middle
    assert sensation.sensation_db(signal, Contact(1.5, 0.0)) == -np.inf
    assert observer.d_prime(-np.inf) == 0


def statuses(seed, n_participants):
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
