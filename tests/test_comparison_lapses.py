"""Just noticeable differences of people who lapse: intervals hold the truth, without lapses and with some."""

import os

import numpy as np
import pytest
from scipy.special import ndtr
from scipy.stats import binom

from tactometry.analysis.cells import JND_PER_SD, Cell, estimate_table, estimates

N_SETS = 1000 if os.environ.get("TACTOMETRY_SOAK") == "1" else 120
LEVELS, N, PSE, SD = np.linspace(-6.0, 6.0, 7), 20, 0.7, 2.5


@pytest.mark.parametrize("lapse_rate", [0.0, 0.03, 0.05])
def test_intervals_hold_the_difference_and_the_point_of_equality(lapse_rate):
    rng = np.random.default_rng()
    chance = lapse_rate / 2 + (1 - lapse_rate) * ndtr((LEVELS - PSE) / SD)
    answers = rng.binomial(N, chance, (N_SETS, len(LEVELS)))
    cells = [
        Cell(f"P{n}", (), "comparison", tuple(LEVELS), tuple(map(int, k)), (N,) * len(LEVELS), 0, 0)
        for n, k in enumerate(answers)
    ]
    table = estimate_table(estimates(cells, 2, "N"), (), "N")
    truth, fewest = JND_PER_SD * SD, binom.ppf(1e-4, N_SETS, 0.935)
    assert ((table["jnd_low"] <= truth) & (truth <= table["jnd_high"])).sum() >= fewest
    assert ((table["interval_low"] <= PSE) & (table["interval_high"] >= PSE)).sum() >= fewest
    assert table["jnd"].median() == pytest.approx(truth, rel=0.2)
