"""Tests of localisation: rates by distance, confusions and resolution."""

from math import log, sqrt

import numpy as np
import pandas as pd
import pytest
from command_line import status
from scipy.stats import binom, norm
from soak import SOAK
from statsmodels.stats.anova import AnovaRM

from tactometry.analysis.pipeline import analyse
from tactometry.analysis.tasks.goodness import goodness_warnings
from tactometry.analysis.tasks.localisation import (
    conditions_of_fits,
    confusions,
    errors,
    mean_resolutions,
    rates_of_participants,
    resolutions,
    right_answers,
)
from tactometry.contact import Contact
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.study_file import parse

AT_1E_4 = 3.891
DISTANCES_M = (0.004, 0.008, 0.012, 0.016, 0.024, 0.032)


def answers(counts, m=2, participant="P01", force_n=1.0):
    """Return answers, this many correct by distance; targets take turns, the wrong answer is the next place."""
    rows = []
    for distance_m, (right, n) in counts.items():
        for k in range(n):
            target = k % m + 1
            answer = target if k < right else target % m + 1
            error_m = 0.0 if k < right else distance_m
            where = {"place": f"F{target}", "distance_m": distance_m, "separation_m": distance_m, "error_m": error_m}
            said = {"level": 20.0, "target": target, "response": str(answer)}
            rows.append({"participant": participant, "force_n": force_n, **where, **said})
    return pd.DataFrame(rows)


FACTORS = ("place", "distance_m", "force_n")


def test_right_answers_are_counted_by_distance():
    rows = answers({0.01: (6, 10), 0.02: (9, 10)})
    found = right_answers(rows, FACTORS)
    assert found["separation_m"].tolist() == [0.01, 0.02]
    assert found[["force_n", "n_correct", "n_trials"]].to_numpy().tolist() == [[1.0, 6, 10], [1.0, 9, 10]]
    # Wilson (1927), by hand: 6 of 10
    z = norm.ppf(0.975)
    centre, half = (0.6 + z * z / 20) / (1 + z * z / 10), z * sqrt(0.024 + z * z / 400) / (1 + z * z / 10)
    assert found[["rate_low", "rate_high"]].iloc[0].tolist() == pytest.approx([centre - half, centre + half])


def test_confusions_name_the_places():
    found = confusions(answers({0.01: (6, 10)}), FACTORS).set_index(["right_place", "answered_place"])
    assert found["n"].to_dict() == {("F1", "F1"): 3, ("F1", "F2"): 2, ("F2", "F1"): 2, ("F2", "F2"): 3}
    assert found["share_of_answers"].to_list() == [0.6, 0.4, 0.4, 0.6]


def test_localisation_errors_are_counted_by_distance():
    found = errors(answers({0.01: (6, 10)}), FACTORS)
    assert found[["error_m", "n", "share_of_answers"]].to_numpy().tolist() == [[0.0, 6, 0.6], [0.01, 4, 0.4]]


@pytest.mark.parametrize("m", [2, 3, 9])
def test_resolution_is_halfway_point_above_chance(m):
    n, alpha, beta = 9000, 0.014, 2.0
    rates = {x: 1 / m + (1 - 1 / m) * (1 - np.exp(-((x / alpha) ** beta))) for x in DISTANCES_M}
    found = resolutions(answers({x: (round(n * rate), n) for x, rate in rates.items()}, m), FACTORS)
    halfway_m = alpha * log(2) ** (1 / beta)
    assert found["resolution_m"].iloc[0] == pytest.approx(halfway_m, rel=0.01)
    assert found["resolution_m_low"].iloc[0] < halfway_m < found["resolution_m_high"].iloc[0]


LAPSES, ALPHA_M, BETA = 0.04, 0.014, 2.0


def drawn(n, rng, m=3, code="P01"):
    """Draw answers of a participant with this Weibull function."""
    rise = 1 - np.exp(-((np.array(DISTANCES_M) / ALPHA_M) ** BETA))
    right = rng.binomial(n, 1 / m + (1 - 1 / m - LAPSES) * rise)
    return answers({x: (int(k), n) for x, k in zip(DISTANCES_M, right, strict=True)}, m, code)


HALFWAY_M = ALPHA_M * log(2) ** (1 / BETA)


def test_resolution_intervals_have_nominal_coverage():
    rng, n = np.random.default_rng(), 400 if SOAK else 100
    each = resolutions(pd.concat([drawn(30, rng, code=f"P{k:03}") for k in range(n)], ignore_index=True), FACTORS)
    low, high = each["resolution_m_low"].fillna(0.0), each["resolution_m_high"].fillna(np.inf)
    n_held = int(((low <= HALFWAY_M) & (high >= HALFWAY_M)).sum())
    assert binom.ppf(1e-4, n, 0.93) <= n_held  # a Bayesian interval covers 95 % over its priors, not at each truth
    assert int((each["deviance_p"] <= 0.01).sum()) <= binom.ppf(1 - 1e-4, n, 0.01)


def test_guess_rate_follows_alternatives_of_condition():
    rng = np.random.default_rng(1)
    two, three = drawn(60, rng, 2), drawn(60, rng, 3).assign(force_n=3.0)
    both = resolutions(pd.concat([two, three], ignore_index=True), FACTORS).set_index("force_n")
    assert both["guess_rate"].to_dict() == pytest.approx({1.0: 1 / 2, 3.0: 1 / 3})
    for force_n, alone in ((1.0, two), (3.0, three)):
        assert resolutions(alone, FACTORS)["resolution_m"].tolist() == [both["resolution_m"][force_n]]


def test_misfit_of_resolution_has_warning():
    """A floor above the guess rate and a step occur if two places differ in strength."""
    rows = answers(dict(zip(DISTANCES_M, ((k, 300) for k in (186, 180, 189, 190, 288, 291)), strict=True)), 3)
    (found,) = resolutions(rows, FACTORS).to_dict("records")
    assert found["deviance_p"] <= 0.01
    assert "deviance" in found["misfit"]
    warnings = goodness_warnings(resolutions(rows, FACTORS), conditions_of_fits(resolutions(rows, FACTORS)))
    (text,) = [line for line in warnings if "test of deviance" in line]
    assert text.startswith("1 of 1 fitted functions have p <= 0.01 in the test of deviance")


def test_resolution_below_distances_is_missing_with_status():
    rows = answers(dict.fromkeys(DISTANCES_M, (60, 60)))
    found = resolutions(rows, FACTORS)
    assert found["resolution_m"].isna().all()
    assert found["status"].tolist() == ["threshold_below_range"]
    assert mean_resolutions(rows, FACTORS)[["n", "n_missing"]].to_numpy().tolist() == [[0, 1]]


def test_conditions_have_separate_resolutions():
    good = dict(zip(DISTANCES_M, [(k, 60) for k in (35, 50, 58, 60, 60, 60)], strict=True))
    bad = dict(zip(DISTANCES_M, [(k, 60) for k in (30, 32, 35, 45, 56, 60)], strict=True))
    people = [
        answers(counts, participant=code, force_n=force_n)
        for code in ("P01", "P02")
        for force_n, counts in ((0.5, good), (3.0, bad))
    ]
    found = mean_resolutions(pd.concat(people, ignore_index=True), FACTORS)
    assert found["force_n"].tolist() == [0.5, 3.0]
    assert found["mean"].iloc[0] < 0.01 < found["mean"].iloc[1]
    assert found["n"].tolist() == [2, 2]


def test_few_levels_are_conditions_many_are_pooled():
    rows = answers({0.01: (9, 18), 0.02: (18, 18)})
    few = right_answers(rows.assign(level=np.arange(36) % 2 + 20.0), FACTORS)
    assert few[["level", "separation_m"]].to_numpy().tolist() == [[20, 0.01], [20, 0.02], [21, 0.01], [21, 0.02]]
    many = right_answers(rows.assign(level=np.arange(36) + 20.0), FACTORS)
    assert many["n_trials"].tolist() == [18, 18]


def test_confusions_need_no_distances():
    rows = answers({0.01: (6, 10)}).drop(columns=["separation_m", "error_m"])
    assert right_answers(rows, FACTORS)[["n_correct", "n_trials"]].to_numpy().tolist() == [[6, 10]]
    assert len(confusions(rows, FACTORS)) == 4
    assert resolutions(rows, FACTORS).empty
    assert errors(rows, FACTORS).empty


STUDY = """
name = "one-finger"
title = "A"
description = "It."
factors = {{ place = ["under", "beside"], distance_m = [{levels}] }}
{variants}
touch = {{ kind = "press", force_n = 1.0, hold_s = 0.3, timeout_s = 10.0 }}
task = {{ kind = "localisation", over = "place" }}
plan.interleave = ["distance_m"]
procedure = {{ kind = "constant_stimuli", levels = [26.0], repeats = {repeats} }}
limits.voltage_peak_v = 1e3
sensation.fingers = ["under"]
observer = {{ exponent = 2.0, between_sd_db = 0.0, lapse_rate = 0.0 }}
[stimulus]
kind = "foci"
f_min_hz = 1e3
f_max_hz = 10e3
voltage_max_v = 1e3
setup = {{ n_transducers = 16, modes_to_hz = 11e3, rate_hz = 50e3 }}
places = {{ under = {{}}, beside = {{}} }}
"""


def study(repeats):
    distances_m = [mm / 1e3 for mm in (2, 3, 4, 5, 6.5, 8, 11)]
    variants = "\n".join(
        f'variants.distance_m."{x:g}".stimulus.places.beside = {{ x_m = {0.121 + x:.4f} }}' for x in distances_m
    )
    return STUDY.format(levels=", ".join(f"{x:g}" for x in distances_m), variants=variants, repeats=repeats)


def chances(text):
    """Return the rate of correct answers by distance, Phi(D / 2) from the field at the finger."""
    by_distance = {}
    for cell in wire(parse(text.encode(), "s.toml"), "s.toml").cells.values():
        levels = cell.sensation.fingers_db(cell.stimulus.at(26.0), Contact(1.0))
        by_distance.setdefault(cell.condition.factors["distance_m"], []).append(1.645 * 10 ** (np.array(levels) / 10))
    return {x: norm.cdf(np.linalg.norm(under - beside) / 2) for x, (under, beside) in by_distance.items()}


def test_resolution_of_simulated_participant_is_recovered(tmp_path):
    text = study(repeats=40)
    (tmp_path / "study.toml").write_text(text, encoding="utf-8")
    simulated = "simulate", tmp_path / "study.toml", "--participants", "1", "--out", tmp_path / "data"
    assert status(*simulated, "--seed", str(np.random.default_rng().integers(2**31))) == 0
    known = chances(text)
    assert min(known.values()) < 0.7
    assert max(known.values()) > 0.95
    known_m = np.interp(0.75, *(np.array(values) for values in (list(known.values()), list(known))))
    (found,) = analyse(tmp_path / "data").tables["resolution_participants"].to_dict("records")
    standard_error_m = (found["resolution_m_high"] - found["resolution_m_low"]) / (2 * norm.ppf(0.975))
    assert abs(found["resolution_m"] - known_m) <= AT_1E_4 * standard_error_m


def people(rng, **columns):
    """Return the trials of five participants, with their correct answers."""
    rows = pd.concat([drawn(12, rng, 2, f"P{k}").assign(**columns) for k in range(5)], ignore_index=True)
    correct = (rows["target"].astype(str) == rows["response"]).astype(int)
    return rows.assign(task="localisation", valid=1, correct=correct)


def numbered(path, rows):
    rows.assign(trial=rows.groupby("participant").cumcount() + 1).to_csv(path, index=False)
    return path


def test_rates_of_participants_are_compared_between_distances(tmp_path):
    rows = people(np.random.default_rng(4))
    path = numbered(tmp_path / "t.csv", rows.drop(columns="force_n"))
    (outcome,) = analyse(path, within=("place", "distance_m"), report=tmp_path / "t.html").outcomes
    page = (tmp_path / "t.html").read_text("utf-8")
    for text in ("Participants: localisation (30 rows)", "Goodness of fit was tested", "Wichmann"):
        assert text in page
    table = rates_of_participants(rows, FACTORS)
    reference = AnovaRM(table, "rate_correct", "participant", within=["separation_m"]).fit().anova_table
    found = outcome.anova.set_index("Source").loc["separation_m"]
    assert (outcome.dependent, outcome.factors) == ("rate_correct", ("separation_m",))
    assert found["F"] == pytest.approx(reference["F Value"].iloc[0])
    assert 0 < found["ng2"] <= 1


def test_rates_by_distance_have_no_force_model(tmp_path):
    rng = np.random.default_rng()
    rows = pd.concat([people(rng, force_n=force_n) for force_n in (0.5, 2.0)], ignore_index=True)
    rows = rows.assign(force_mean_n=rows["force_n"] * rng.uniform(0.9, 1.1, len(rows)))
    found = analyse(numbered(tmp_path / "t.csv", rows), within=FACTORS)
    (outcome,) = found.outcomes
    assert outcome.factors == ("force_n", "separation_m")
    assert "force" in found.tables
    assert outcome.model is None
