"""QUEST+: the posterior mean of the threshold by the size of the grid."""

from functools import partial

import numpy as np

from tactometry.protocols import ParameterGrid, QuestPlus
from tactometry.psychometric import PsychometricFunction

from ..problem import Problem, Reference, Setting

LOW, HIGH, NARROW, WIDE = 0.0, 40.0, 4.0, 12.0
ANSWERS = ((30.0, 1), (20.0, 1), (14.0, 0), (18.0, 1), (16.0, 0), (18.0, 1), (17.0, 1), (15.0, 0), (19.0, 1), (16.0, 1))
N_THRESHOLDS = (6, 11, 21, 41, 81, 161)
N_FINEST, N_NODES = 641, 60


def problem() -> Problem:
    """Score ten answers of a two-alternative task; the grid has half as many widths as thresholds."""
    finest = _mean(N_FINEST)
    return Problem(
        "error of the posterior mean of the threshold after ten answers, over the range of 40 dB",
        reference=Reference("a far finer grid", lambda: finest, abs(finest - _mean(N_FINEST // 2 + 1)) / (HIGH - LOW)),
        independent=Reference("Gauss and Legendre, function by function", _integral, 1e-5),
        error=lambda found, reference: abs(found - reference) / (HIGH - LOW),
        settings=tuple(Setting(f"{n} x {n_widths(n)}", partial(_mean, n)) for n in N_THRESHOLDS),
    )


def n_widths(n_thresholds: int) -> int:
    return min(n_thresholds // 2, 160)


def _mean(n_thresholds: int) -> float:
    thresholds = middles(LOW, HIGH, n_thresholds)
    widths = middles(NARROW, WIDE, n_widths(n_thresholds))
    grid = ParameterGrid(thresholds, widths, shape="normal")
    procedure = QuestPlus((15.0, 20.0), grid, n_trials=len(ANSWERS) + 1).begin()
    for level, response in ANSWERS:
        procedure = procedure.after(response, delivered=level)
    return procedure.mean("threshold")


def middles(low: float, high: float, n: int) -> tuple[float, ...]:
    """Return the middles of n equal parts."""
    return tuple((low + (high - low) * (np.arange(n) + 0.5) / n).tolist())


def _integral() -> float:
    """Integrate by Gauss and Legendre, function by function."""
    node, weight = np.polynomial.legendre.leggauss(N_NODES)
    width_node, width_weight = np.polynomial.legendre.leggauss(12)
    thresholds = LOW + (HIGH - LOW) * (node + 1) / 2
    widths = NARROW + (WIDE - NARROW) * (width_node + 1) / 2
    like = np.array([[_likelihood(t, w) for w in widths] for t in thresholds]) @ width_weight * weight
    return float(like @ thresholds / like.sum())


def _likelihood(threshold: float, width: float) -> float:
    function = PsychometricFunction("normal", float(threshold), float(width), 0.5, 0.02)
    return float(np.exp(sum(float(function.log_probability(level, response)) for level, response in ANSWERS)))
