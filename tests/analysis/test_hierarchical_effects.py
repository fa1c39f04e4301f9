"""Tests of effects and contrasts of a hierarchical fit."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from group_study import LAPSE_RATE, LEVELS, RARE, WIDTH, fitted, simulated
from scipy.linalg import helmert
from scipy.stats import f as fisher

from tactometry.analysis.anova.contrasts import epsilons
from tactometry.analysis.hierarchical.fitting import fit_hierarchical
from tactometry.errors import InvalidParameter
from tactometry.psychometric import PsychometricFunction


@pytest.fixture(scope="module")
def study():
    return simulated(np.random.default_rng())


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
    """The correction follows the covariance of the participants' thresholds."""
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


def test_shared_widths_have_no_test(study) -> None:
    with pytest.raises(
        InvalidParameter, match="of: found 'log_width' over force_n, expected conditions with separate widths"
    ):
        fitted(study[0]).effect("force_n", of="log_width")


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


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda found: found.effect("frequency_hz"), "factors: found frequency_hz over 2 conditions"),
        (
            lambda found: found.contrast({(3.0,): 1.0}),
            r"weights: found \(3.0,\), expected conditions, such as \(0.5,\)",
        ),
        (lambda found: found.contrast({(0.5,): 1.0}, of="width"), "of: found 'width', expected 'threshold'"),
    ],
)
def test_contrasts_of_unknown_conditions_are_rejected(study, call, message) -> None:
    with pytest.raises(InvalidParameter, match=f"^{message}"):
        call(fitted(study[0]))
