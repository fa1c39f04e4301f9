"""How often statistics of a group are wrong, simulated: false alarms of F, coverage of intervals.

Reduced in `make test`; in full in the soak. A tolerance is the standard error of the share at 1e-4.
"""

import os
from collections.abc import Mapping

import numpy as np
import pytest
from scipy.stats import norm

from tactometry.analysis.contrasts import Effect, contrasts

SOAK = os.environ.get("TACTOMETRY_SOAK") == "1"
N = 10
SCENARIOS = ("spherical", "AR(1)", "noisy", "no interaction")
DESIGNS: Mapping[str, tuple[tuple[int, ...], tuple[int, ...]]] = {"4": ((4,), (0,)), "3 x 4": ((3, 4), (0, 1))}


def reach(share: float, n: int) -> float:
    """Of a share of `n` studies, two-sided at 1e-4."""
    return float(norm.isf(0.5e-4) * np.sqrt(share * (1 - share) / n))


def drawn(scenario: str, n_cells: int, shape: tuple[int, int], rng: np.random.Generator) -> np.ndarray:
    """Studies of `shape` (study, participant) without effects: participants of twice the standard deviation; errors
    that are independent, correlated by 0.7 a step, three times as large in one condition, or nearly none."""
    places = np.arange(n_cells)
    covariance = {
        "spherical": np.eye(n_cells),
        "AR(1)": 0.7 ** np.abs(np.subtract.outer(places, places)),
        "noisy": np.diag(np.where(places == 0, 9.0, 1.0)),
        "no interaction": 1e-4 * np.eye(n_cells),
    }[scenario]
    return rng.normal(size=(*shape, n_cells)) @ np.linalg.cholesky(covariance + 4.0).T


@pytest.mark.parametrize("design", DESIGNS)
@pytest.mark.parametrize("scenario", SCENARIOS)
def test_false_alarms_of_the_analysis_of_variance_are_4_to_6_percent(design, scenario) -> None:
    """At ten participants; of Chi and Muller's p, for the highest effect of the design."""
    n_levels, part = DESIGNS[design]
    n_studies = 60_000 if SOAK else 2_000
    values = drawn(scenario, int(np.prod(n_levels)), (n_studies, N), np.random.default_rng())
    scores = values @ contrasts(n_levels, part).T
    effects = [Effect(("x",), each, values.shape[-1]).tested for each in scores]
    rate = np.mean([effect.p(effect.sphericity.chi_muller) < 0.05 for effect in effects])
    assert abs(rate - 0.05) < 0.01 + reach(0.06, n_studies)
