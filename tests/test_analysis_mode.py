"""The mode of a density with several summits."""

import numpy as np
import pytest

from tactometry.analysis.counts import checked, normalised
from tactometry.analysis.mode import find_mode, log_density
from tactometry.analysis.prior import Prior
from tactometry.psychometric import SHAPES

LEVELS = np.linspace(-3, 3, 7)
STEEP_WITH_LAPSES = np.array(np.meshgrid(np.linspace(-0.5, 0.5, 41), [-1.3, -1.15, -1.0], np.linspace(0.02, 0.48, 24)))


@pytest.mark.parametrize(
    ("k", "guess_rate"),
    [
        ([20, 23, 38, 34, 33, 32, 40], 0.5),
        ([0, 2, 18, 19, 19, 20, 16], 0.0),
        ([1, 0, 18, 29, 18, 22, 35], None),
        ([0, 17, 22, 24, 20, 25, 30], None),
    ],
    ids=str,
)
def test_the_mode_is_the_higher_of_a_shallow_and_a_steep_summit(k, guess_rate) -> None:
    """The best node of the coarse grid is shallow, by up to 16 in the logarithm, and leads to the lower summit."""
    counts, none = normalised(*checked(LEVELS, [k], 40, positive=False)), np.zeros(1)
    prior = Prior(counts.gap, None, guess_rate, none, none)
    m, v, lapse = (part.ravel() for part in STEEP_WITH_LAPSES)
    nodes = np.stack([m, v, lapse, np.full_like(m, guess_rate or 0.0)], axis=1)
    found = find_mode(SHAPES["normal"], counts, prior)
    steep = max(log_density(SHAPES["normal"], counts, prior, node[None])[0] for node in nodes)
    assert found.log_density[0] >= steep
    shallow = find_mode(SHAPES["normal"], counts, prior, np.array([[0.0, 0.3, 0.01, guess_rate or 0.01]]))
    assert found.log_density[0] > shallow.log_density[0] + 1


def test_each_of_a_stack_has_the_summit_that_it_has_alone() -> None:
    """Steep and shallow summits, in turn."""
    k = np.array([[0, 2, 18, 19, 19, 20, 16], [0, 3, 9, 21, 30, 37, 40], [0, 0, 2, 14, 18, 24, 18]])
    counts, none = normalised(*checked(LEVELS, k, 40, positive=False)), np.zeros(3)
    prior = Prior(counts.gap, None, 0.0, none, none)
    together = find_mode(SHAPES["normal"], counts, prior)
    for i in range(3):
        alone = find_mode(SHAPES["normal"], counts[i : i + 1], prior[i : i + 1])
        assert together.theta[i] == pytest.approx(alone.theta[0], abs=1e-9)
        assert together.log_density[i] == pytest.approx(alone.log_density[0], abs=1e-9)
