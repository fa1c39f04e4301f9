"""Tests of hierarchical fits: truths, real data, edge cases, effects and the posterior."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from group_study import LAPSE_RATE, LEVELS, RARE, SD, WIDTH, fitted, simulated
from hard_cases import exact_case
from places import SHARED
from scipy.linalg import helmert
from scipy.special import ndtr, ndtri
from scipy.stats import binom, f as fisher
from soak import SOAK

from tactometry.analysis.anova.design import epsilons
from tactometry.analysis.hierarchical.fitting import GroupStatus, fit_hierarchical
from tactometry.analysis.hierarchical.model import GroupModel, StudyCounts, rate_of
from tactometry.analysis.hierarchical.posterior import Laplace, integrate, quantiles
from tactometry.analysis.hierarchical.tables import draw_cells
from tactometry.analysis.threshold.fitting import fit
from tactometry.errors import InvalidParameter
from tactometry.experiments.bias_study.groups import outcome
from tactometry.psychometric import SHAPES, PsychometricFunction


@pytest.fixture(scope="module")
def study():
    return simulated(np.random.default_rng())


def test_one_participant_agrees_with_a_single_fit() -> None:
    k = [10, 11, 11, 15, 18, 20, 20]
    rows = pd.DataFrame({"participant": "A", "force_n": 1.0, "level": LEVELS, "k": k, "n": 20})
    found = fitted(rows)
    single = fit(LEVELS, k, 20, shape="normal", guess_rate=0.5)
    assert found.status == GroupStatus.ONE_PARTICIPANT
    assert found.components == {}
    assert found.conditions["threshold"][0] == pytest.approx(single.threshold_median, abs=0.5)
    assert found.conditions["width"][0] == pytest.approx(single.width, rel=0.25)


N_STUDIES = 100 if SOAK else 10


@pytest.mark.slow
def test_intervals_cover_means_contrasts_and_participants() -> None:
    """The participants of a study share its means, so each study counts once, by one participant."""
    rng = np.random.default_rng()
    covered = {"mean": 0, "contrast": 0, "participant": 0}
    squared, alone = [], []
    for _ in range(N_STUDIES):
        rows, truth = simulated(rng)
        found = fitted(rows)
        first, contrast = found.conditions.iloc[0], found.contrast({(1.0,): 1.0, (0.5,): -1.0})
        covered["mean"] += first["interval_low"] <= 18.0 <= first["interval_high"]
        covered["contrast"] += contrast.interval_low <= 1.0 <= contrast.interval_high
        one = found.participants.iloc[rng.integers(len(found.participants))]
        true = truth[one["participant"], one["force_n"]]
        covered["participant"] += one["interval_low"] <= true <= one["interval_high"]
        cells = rows[rows["participant"] == one["participant"]]
        single = cells[cells["force_n"] == one["force_n"]]
        own = fit(single["level"], single["k"], 20, shape="normal", guess_rate=0.5).threshold
        if own is not None:
            squared.append((one["threshold"] - true) ** 2)
            alone.append((own - true) ** 2)
    assert {name: n for name, n in covered.items() if n < binom.ppf(RARE, N_STUDIES, 0.935)} == {}
    if SOAK:
        assert np.mean(squared) < 0.9 * np.mean(alone)


def test_variances_are_recovered() -> None:
    """With 24 participants sd is within a factor of 1.8 either way at 1e-4 (chi with 23 df)."""
    found = fitted(simulated(np.random.default_rng(), n=24)[0])
    assert SD / 1.8 < found.components["threshold"] < 1.8 * SD
    assert found.lapse_rate < 0.08


def expected_counts(thresholds, n_trials) -> pd.DataFrame:
    """Return answers as often as they are expected."""
    parts = [
        pd.DataFrame({"participant": f"P{p}", "force_n": 1.0, "level": LEVELS, "k": np.round(n * curve(m)), "n": n})
        for p, (m, n) in enumerate(zip(thresholds, n_trials, strict=True))
    ]
    return pd.concat(parts, ignore_index=True)


def curve(threshold):
    return PsychometricFunction("normal", threshold, WIDTH, 0.5, LAPSE_RATE).probability(LEVELS)


def test_shrinkage_grows_as_trials_decrease() -> None:
    thresholds, distances = [24.0, 16.0, 17.0, 18.0, 19.0, 20.0], []
    for n in (1000, 60, 12):
        found = fitted(expected_counts(thresholds, [n, *[100] * 5]))
        distances.append(found.participants["threshold"][0] - 18.0)
    assert pytest.approx(distances[0], abs=0.3) == 6.0
    assert distances[0] > distances[1] > distances[2] > 0


# Real data
def test_the_published_conclusion_on_real_data() -> None:
    """Dallmann et al. 2015; lme4's probit model: 8.56 (0.142) and 8.41 (0.163), 2.94 and 3.58."""
    path = SHARED / "data" / "dallmann2015_counts.csv"
    if not path.exists():
        pytest.skip("the shared folder with the data of Dallmann 2015 is absent")
    rows = pd.read_csv(path)
    answers = rows["speed_cm_per_s"], rows["n_faster"], rows["n_faster"] + rows["n_slower"], rows["participant"]
    options = {"shape": "normal", "guess_rate": 0.0, "lapse_rate": 0.0, "width_by": ("vibration_hz",)}
    found = fit_hierarchical(*answers, {"vibration_hz": rows["vibration_hz"]}, **options)
    assert found.conditions["threshold"].tolist() == pytest.approx([8.56, 8.41], abs=0.02)
    # A posterior standard deviation holds what nine participants leave open of the variances: a seventh more.
    assert found.conditions["standard_error"].tolist() == pytest.approx([0.165, 0.180], rel=0.05)
    jnd = found.conditions["width"].to_numpy(float) / SHAPES["normal"].z_width * ndtri(0.75)
    assert jnd.tolist() == pytest.approx([2.94, 3.58], rel=0.04)  # these are exponentials of a mean logarithm
    masked, equality = (found.contrast({(32,): 1.0, (0,): -1.0}, of=of) for of in ("log_width", "threshold"))
    assert masked.interval_low > 0
    assert masked.p < 0.01
    assert equality.interval_low < 0 < equality.interval_high


# Hard cases
def test_all_correct_participant_has_only_an_upper_bound(study) -> None:
    rows = study[0].copy()
    rows.loc[rows["participant"] == "P0", "k"] = 20
    found = fitted(rows)
    own = found.participants[found.participants["participant"] == "P0"]
    assert (own["status"] == "threshold_below_range").all()
    assert own["threshold"].isna().all()
    assert (own["interval_high"] < 15).all()
    assert own["interval_low"].isna().all()
    assert found.conditions["threshold"].notna().all()


def test_a_missing_cell_stays_empty(study) -> None:
    rows = study[0]
    kept = rows[~((rows["participant"] == "P1") & (rows["force_n"] == 0.5))]
    found = fitted(kept)
    cell = found.participants.query("participant == 'P1' and force_n == 0.5").iloc[0]
    assert (cell["status"], cell["n_trials"]) == ("no_data", 0)
    assert pd.isna(cell["threshold"])
    assert len(found.participants) == 16
    assert found.conditions["threshold"].notna().all()


def test_condition_without_threshold_has_no_mean(study) -> None:
    rows = study[0].copy()
    rows.loc[rows["force_n"] == 0.5, "k"] = 20
    found = fitted(rows)
    assert found.conditions["status"].tolist() == ["threshold_below_range", "ok"]
    assert pd.isna(found.conditions["threshold"][0])
    assert found.conditions.loc[0, ["interval_low", "interval_high"]].isna().all()
    assert (found.participants.query("force_n == 0.5")["interval_high"] < 6).all()
    with pytest.raises(InvalidParameter, match="conditions: found no mean threshold for .*threshold_below_range"):
        found.contrast({(1.0,): 1.0, (0.5,): -1.0})


@pytest.mark.parametrize(
    ("k", "status"),
    [
        ([20] * 7, "threshold_below_range"),
        ([10] * 7, "threshold_above_range"),
        ([15] * 7, "flat"),
        ([20, 19, 18, 15, 12, 11, 10], "non_monotone"),
    ],
    ids=["all correct", "all chance", "flat", "falling"],
)
def test_uninformative_answers_have_status_without_numbers(study, k, status) -> None:
    rows = study[0].assign(k=np.tile(k, 16))
    found = fitted(rows)
    assert found.status == GroupStatus.NO_THRESHOLD
    assert found.note
    assert (found.conditions["status"] == status).all()
    assert found.conditions["threshold"].isna().all()
    assert found.participants["threshold"].isna().all()


def test_steps_bound_the_width_of_all_participants(study) -> None:
    rows = study[0].assign(k=np.tile([10, 10, 10, 20, 20, 20, 20], 16))
    found = fitted(rows)
    assert (found.conditions["threshold"] > LEVELS[2]).all()
    assert (found.conditions["threshold"] < LEVELS[3]).all()
    assert found.conditions["width"].isna().all()
    assert (found.conditions["width_high"] < 28).all()


def test_widths_of_steps_stay_finite(study) -> None:
    """The likelihood of a varying width has no maximum for step answers."""
    k = [10, 7, 10, 10, 17, 19, 20, 10, 10, 10, 9, 10, 20, 20]
    one = study[0][study[0]["participant"] == "P0"].assign(k=k)
    found = fitted(pd.concat([one.assign(participant=f"Q{i}") for i in range(5)]))
    assert found.status == GroupStatus.OK
    assert 0 < found.components["log_width"] < 1.5


def test_interval_widens_when_lapse_rate_is_free() -> None:
    """Four of five answers are correct at every level: thresholds were 10 dB too low."""
    names = [f"P{person}" for person in range(6) for _ in range(5)]
    levels = [18.0 + person + step for person in range(6) for step in (0.0, 2.0, 4.0, 6.0, 8.0)]
    k = [31, 37, 41, 40, 41, 30, 38, 40, 42, 41, 32, 36, 41, 40, 40] * 2
    conditions = {"force_n": [0.5] * len(names)}
    free, known = (
        fit_hierarchical(levels, k, 50, names, conditions, shape="gumbel", guess_rate=0.5, lapse_rate=rate).conditions
        for rate in (None, 0.02)
    )
    lengths = [float((one["interval_high"] - one["interval_low"])[0]) for one in (free, known)]
    assert lengths[0] > lengths[1]


def test_single_level_and_no_trials_have_statuses(study) -> None:
    rows = study[0]
    one_level = fitted(rows[rows["level"] == LEVELS[3]])
    assert (one_level.conditions["status"] == "too_few_levels").all()
    assert fitted(rows.assign(k=0, n=0)).status == GroupStatus.NO_DATA
    exact_case("a hierarchy of one level, and of none", against="statuses")


@pytest.mark.parametrize(("scale", "shift"), [(1e-9, 0.0), (1.0, 1e4)])
def test_hierarchical_fit_scales_and_shifts_with_levels(study, scale, shift) -> None:
    one, other = fitted(study[0]), fitted(study[0].assign(level=scale * (study[0]["level"] + shift)))
    for name in ("threshold", "interval_low", "interval_high"):
        moved = (one.conditions[name].to_numpy(float) + shift) * scale
        assert other.conditions[name].to_numpy(float) == pytest.approx(moved, rel=1e-5)
    assert other.components["threshold"] == pytest.approx(scale * one.components["threshold"], rel=1e-3)


def test_neither_the_order_of_rows_nor_names_matter(study) -> None:
    rows = study[0]
    one, other = fitted(rows), fitted(rows.sample(frac=1.0, random_state=1).assign())
    renamed = fitted(rows.assign(participant="Z" + rows["participant"]))
    expected = pytest.approx(one.conditions["threshold"].to_numpy(), rel=1e-6)
    for found in (other, renamed):
        assert found.conditions["threshold"].to_numpy() == expected


def test_a_weibull_is_a_gumbel_of_the_logarithm(study) -> None:
    rows = study[0]
    one = fitted(rows, shape="weibull").conditions
    other = fitted(rows.assign(level=np.log(rows["level"])), shape="gumbel").conditions
    for name in ("threshold", "interval_low", "interval_high"):
        assert np.log(one[name].to_numpy(float)) == pytest.approx(other[name].to_numpy(float), rel=1e-9)
    assert one["standard_error"].to_numpy() == pytest.approx(other["standard_error"].to_numpy(), rel=1e-9)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"width_by": ("hz",)}, "width_by: found 'hz', expected factors of force_n"),
        ({"interval": 95}, "fit_hierarchical.interval: found 95, expected a number above 0 and below 1"),
        ({"guess_rate": 1.0}, "fit_hierarchical.guess_rate: found 1.0, expected a number from 0 to below 1"),
        ({"shape": "norml"}, "shape: found 'norml'"),
        ({"rows": {"k": 21}}, "n_correct, row 0: found 21"),
    ],
)
def test_invalid_arguments_are_rejected(study, change, message) -> None:
    options = {"rows": {}} | change
    with pytest.raises(InvalidParameter, match=f"^{message}"):
        fitted(study[0].assign(**options.pop("rows")), **options)


def test_points_of_the_integral_hardly_move_intervals(study) -> None:
    few, many = (fitted(study[0], n_points=n).conditions for n in (256, 1024))
    length = (many["interval_high"] - many["interval_low"]).mean()
    for end in ("interval_low", "interval_high"):
        assert few[end].to_numpy(float) == pytest.approx(many[end].to_numpy(float), abs=0.05 * length)


def test_lapse_rates_of_participants_follow_their_answers(study) -> None:
    """One of eight participants misses a quarter of the easiest trials."""
    rows = study[0].copy()
    is_easy = (rows["participant"] == "P0") & (rows["level"] == LEVELS[-1])
    rows.loc[~is_easy & (rows["level"] == LEVELS[-1]), "k"] = 20
    rows.loc[is_easy, "k"] = 15
    rates = fitted(rows).participants.groupby("participant")["lapse_rate"].first()
    assert rates["P0"] > 2 * rates.drop("P0").mean()


def test_effects_of_a_factorial() -> None:
    rng, parts = np.random.default_rng(), []
    for frequency_hz, base in ((60.0, 22.0), (240.0, 14.0)):
        rows, _ = simulated(rng, means={0.5: base, 1.0: base}, n_trials=30)
        parts.append(rows.assign(frequency_hz=frequency_hz))
    rows = pd.concat(parts)
    conditions = {"frequency_hz": rows["frequency_hz"], "force_n": rows["force_n"]}
    found = fit_hierarchical(
        rows["level"], rows["k"], rows["n"], rows["participant"], conditions, shape="normal", guess_rate=0.5
    )
    frequency, both = found.effect("frequency_hz"), found.effect("frequency_hz", "force_n")
    assert (frequency.df, both.df) == (1, 1)
    assert frequency.df_error == 7
    assert frequency.p < 1e-3
    assert both.p > RARE
    weights = {(60.0, 0.5): 0.5, (60.0, 1.0): 0.5, (240.0, 0.5): -0.5, (240.0, 1.0): -0.5}
    contrast = found.contrast(weights)
    assert contrast.interval_low > 0
    assert contrast.p < 1e-3


def test_uneven_deviations_cost_degrees_of_freedom() -> None:
    rows, _ = simulated(np.random.default_rng(), n=6, means={0.5: 18.0, 1.0: 19.0, 2.0: 19.0}, n_trials=30)
    found = fitted(rows)
    noise = np.random.default_rng().normal(0, 30, 6)
    table = found.participants
    uneven = replace(
        found,
        components={**found.components, "threshold_cell": 1.0},
        participants=table.assign(threshold=table["threshold"] + np.outer(noise, [0, 0, 1]).ravel()),
    )
    one, other = (each.effect("force_n") for each in (found, uneven))
    values = uneven.participants.pivot(index="participant", columns="force_n", values="threshold").to_numpy()
    expected = epsilons(np.cov(values @ helmert(3).T, rowvar=False), 5)[2]
    assert other.epsilon == pytest.approx(expected, rel=1e-9)
    assert other.epsilon < 0.9
    assert other.f == one.f
    assert other.p == pytest.approx(float(fisher.sf(other.f, 2 * expected, 10 * expected)), rel=1e-9)


@pytest.mark.soak
def test_false_positive_rate_is_nominal_with_noisy_condition() -> None:
    rng, n_studies = np.random.default_rng(), 400
    found = [fitted(noisy(rng), guess_rate=0.02).effect("force_n").p < 0.05 for _ in range(n_studies)]
    assert abs(np.mean(found) - 0.05) < 0.015 + 3.9 * np.sqrt(0.05 * 0.95 / n_studies)


def noisy(rng) -> pd.DataFrame:
    """Simulate ten participants in four conditions, the first with threefold deviations."""
    rows = []
    for p in range(10):
        own = 18.0 + 2.0 * rng.normal()
        for condition, sd in enumerate((3.0, 1.0, 1.0, 1.0)):
            curve = PsychometricFunction("normal", own + sd * rng.normal(), WIDTH, 0.02, LAPSE_RATE)
            k = rng.binomial(20, curve.probability(LEVELS))
            rows += [(f"P{p}", condition, x, each, 20) for x, each in zip(LEVELS, k, strict=True)]
    return pd.DataFrame(rows, columns=["participant", "force_n", "level", "k", "n"])


WIDTHS = "of: found 'log_width' over force_n, expected conditions with separate widths"


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda found: found.effect("frequency_hz"), "factors: found frequency_hz over 2 conditions"),
        (lambda found: found.effect("force_n", of="log_width"), WIDTHS),
        (lambda found: found.contrast({(3.0,): 1.0}), r"weights: found \(3.0,\), expected conditions, such as \(0.5,"),
        (lambda found: found.contrast({(0.5,): 1.0}, of="width"), "of: found 'width', expected 'threshold'"),
    ],
)
def test_contrasts_of_unknown_conditions_are_rejected(study, call, message) -> None:
    with pytest.raises(InvalidParameter, match=f"^{message}"):
        call(fitted(study[0]))


FIVE_LEVELS, N_TRIALS = np.array([-6.0, -3.0, 0.0, 3.0, 6.0]), 8
N_YES = np.array([[0, 4, 8, 8, 8], [0, 2, 6, 7, 8], [0, 1, 5, 8, 8], [0, 1, 4, 6, 7], [0, 0, 2, 7, 8], [0, 0, 1, 4, 7]])


def model_of(n_yes, lapse_rate=0.02) -> GroupModel:
    n, n_levels = n_yes.shape
    names = np.repeat([f"P{place}" for place in range(n)], n_levels)
    answers = np.tile(FIVE_LEVELS, n), n_yes.ravel().astype(float), np.full(n_yes.size, float(N_TRIALS))
    known = {"shape": SHAPES["logistic"], "guess_rate": 0.0, "lapse_rate": lapse_rate}
    return GroupModel(StudyCounts.of(names, {"condition": np.zeros(n_yes.size)}, (), answers, **known))


def test_quantiles_of_a_mixture_reach_their_share() -> None:
    weights, means, sds = np.array([0.2, 0.5, 0.3]), np.array([-3.0, 0.0, 4.0]), np.array([1.0, 0.5, 0.0])
    low = quantiles(weights, means, sds, 0.1)
    assert weights @ ndtr((low - means) / np.array([1.0, 0.5, 1e-9])) == pytest.approx(0.1, abs=1e-9)
    assert quantiles(weights, means, sds, 0.9) == pytest.approx(4.0, abs=1e-6)


def test_draws_of_participants_stay_near_laplace() -> None:
    model = model_of(N_YES[:2])
    hyper = np.array([np.log(0.2), np.log(0.3), 0.0, np.log(0.5)])
    found = integrate(Laplace(model, hyper, np.zeros(1)), hyper, 64)
    draws = draw_cells(model, found, 2**14)
    mean = (draws.weights[..., None] * draws.points[:, :, 0]).sum(axis=0)
    normal = found.mean(found.at.cells[:, :, 0])
    sds = np.sqrt(found.mean(found.at.variances[:, :, 0] + np.square(found.at.cells[:, :, 0] - normal)))
    assert (np.abs(mean - normal) < 0.4 * sds).all()
    assert (draws.n_effective > 2**12).all()


def test_log_likelihood_slopes_are_derivatives() -> None:
    model = model_of(N_YES[:2], lapse_rate=None)
    hyper = np.zeros((1, len(model.hyper)))
    at = np.array([0.05, -0.7, -3.0]) + np.zeros((1, 2, 1, 3))
    found = model.log_likelihood(at, hyper)
    for axis in range(3):
        step = 1e-5 * np.eye(3)[axis]
        ahead, behind = (model.log_likelihood(at + side * step, hyper) for side in (1, -1))
        assert found.gradient[..., axis] == pytest.approx((ahead.value - behind.value) / 2e-5, rel=1e-5, abs=1e-6)
        assert found.hessian[..., axis] == pytest.approx((ahead.gradient - behind.gradient) / 2e-5, rel=1e-4, abs=1e-5)


def test_information_is_the_curvature_at_expected_counts() -> None:
    """The log-likelihood is linear in the counts."""
    model = model_of(N_YES[:2], lapse_rate=None)
    hyper, at = np.zeros((1, len(model.hyper))), np.array([0.05, -0.7, -3.0]) + np.zeros((1, 2, 1, 3))
    lapse_rate = float(rate_of(np.array(-3.0))[0])
    curve = PsychometricFunction("logistic", 0.05, np.exp(-0.7), 0.0, lapse_rate)
    expected = N_TRIALS * curve.probability(model.study.u)
    at_expected = GroupModel(replace(model.study, n_yes=expected))
    curvature = -at_expected.log_likelihood(at, hyper).hessian
    assert model.information(at, hyper) == pytest.approx(curvature, rel=1e-9, abs=1e-9)


def test_bias_study_of_groups_is_repeatable() -> None:
    one, other = (outcome("1 up 3 down", "2 of 10 at 15 %", 3, 1) for _ in range(2))
    assert one == other
    assert 0.5 < one["participants"] <= 1
    assert abs(one["mean_db"]) < 10
