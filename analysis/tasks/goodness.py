"""Goodness of fit by participant and condition, and warnings about it."""

from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from scipy.special import bdtrc

from ..arrays import Array, Indices
from ..reading.rows import COUNTED
from ..threshold.counts import POOLED_BELOW, Counts
from ..threshold.fitting import log_posterior
from ..threshold.goodness import STATISTICS, Goodness, Sequences, goodness
from ..threshold.mode import climb
from ..wording import named_cells
from .cell import Estimate, catch_counts, cell_keys, stacked_counts
from .rule_estimate import FIXED

SEED = 20010601
"""Seed of the draws, so that equal data yield equal results."""
STRETCH = 10
"""Number of trials in a stretch; a cell has 2 to `MOST_STRETCHES` stretches."""
MOST_STRETCHES = 20
MOST_PLACES = 20_000
"""Largest number of stretches times levels of a cell, as the draws of more take too long for a report."""
FLAGGED_P = 0.01
SURPRISING = 0.01
"""Probability of as many flagged functions by chance, at or below which a warning is issued."""
TESTS = {
    "deviance": "the answers deviate from the function by more than chance",
    "level": "the residuals are curved over the level, as if the true function had another form",
    "order": "the residuals rise or fall with time, as with learning, fatigue or a changed criterion",
    "overdispersion": "answers close in time are alike, as with runs of lapses, so intervals are too narrow",
}
"""The tests in the order of `STATISTICS`, with the meaning of a small p."""
OF_ORDER = slice(2, None)
"""The tests that use the order of the answers."""
P_COLUMNS = dict(zip(TESTS, ("deviance_p", "residual_level_p", "residual_order_p", "dispersion_p"), strict=True))
MISFIT = "misfit"


def goodness_columns(
    answers: pd.DataFrame,
    factors: Sequence[str],
    estimates: Sequence[Estimate],
    options: Mapping[tuple[str, int], Mapping[str, Any]],
    rng: np.random.Generator,
    counting: Container[str] = (),
) -> pd.DataFrame:
    """Return statistics, p and `misfit` of each estimate.

    `misfit` lists the tests with a small p. `options` are the options of the fits, by task and number of alternatives.
    Tasks in `counting` use catch trials.
    """
    rows = _in_order(answers, factors)
    values, p = (np.full((len(estimates), len(TESTS)), np.nan) for _ in range(2))
    for alike, of_fits in options.items():
        of_task = [n for n, one in enumerate(estimates) if (one.cell.task, one.cell.n_choices) == alike]
        fitted = [n for n in of_task if estimates[n].fit.function is not None]
        for numbers in _of_like_size(estimates, fitted):
            tested = _goodness_of(rows, [estimates[n] for n in numbers], numbers, of_fits, rng, counting)
            values[numbers], p[numbers] = tested.statistics, tested.p
    if "procedure" in rows.columns:  # the order of answers is unknown in tables of counts
        unordered = rows.loc[rows["procedure"] == COUNTED, "cell"].unique()
        values[unordered, OF_ORDER] = p[unordered, OF_ORDER] = np.nan
    columns: dict[str, Any] = {"deviance_p": p[:, 0]}
    for n, (value, name) in enumerate(zip(STATISTICS, P_COLUMNS.values(), strict=True)):
        columns |= {} if n == 0 else {value: values[:, n], name: p[:, n]}  # the estimates already contain the deviance
    flags = [[name for name, value in zip(TESTS, p_of_tests, strict=True) if value <= FLAGGED_P] for p_of_tests in p]
    return pd.DataFrame(columns | {MISFIT: list(map(", ".join, flags))})


def _in_order(answers: pd.DataFrame, factors: Sequence[str]) -> pd.DataFrame:
    """Return the answers without catch trials, in the order of the trials.

    Added columns are the index of the `cell`, the `stretch` of trials within it, and `follows`, which is True if the
    levels depend on the answers.
    """
    # Number cells before removing catch trials, so that indices match the estimates.
    rows = answers.assign(cell=answers.groupby(cell_keys(factors), sort=True, observed=True).ngroup())
    rows = rows[~rows["is_catch"]]
    if "session" in rows.columns:
        rows = rows.sort_values("session", kind="stable")
    cell = rows.groupby("cell")
    n_trials, place = cell["yes"].transform("size").to_numpy(), cell.cumcount().to_numpy()
    # at least two stretches, as a trend needs two
    n_stretches = np.clip(n_trials // STRETCH, 2, MOST_STRETCHES)
    follows = ~rows["procedure"].isin(FIXED) if "procedure" in rows.columns else True
    return rows.assign(stretch=place * n_stretches // n_trials, follows=follows)


def _of_like_size(estimates: Sequence[Estimate], chosen: Sequence[int]) -> list[Indices]:
    """Group cells with similar numbers of levels, to need little padding."""
    n_levels = np.array([len(estimates[n].cell.levels) for n in chosen])
    size = np.ceil(np.log2(n_levels)) if len(n_levels) else n_levels
    places = n_levels * MOST_STRETCHES
    is_small = places <= MOST_PLACES
    return [np.array(chosen)[(size == value) & is_small] for value in np.unique(size)]


def _goodness_of(
    rows: pd.DataFrame,
    estimates: Sequence[Estimate],
    cells: Indices,
    options: Mapping[str, Any],
    rng: np.random.Generator,
    counting: Container[str],
) -> Goodness:
    fitted_cells = [estimate.cell for estimate in estimates]
    levels, n_yes, n_trials = stacked_counts(fitted_cells)
    alarms, catch = catch_counts(fitted_cells, counting)
    posterior = log_posterior(levels, n_yes, n_trials, n_false_alarms=alarms, n_catch=catch, **options)
    counts, on_axis = posterior.counts, _logarithm if posterior.shape.on_log_levels else np.asarray
    # Climb to the mode, as estimates may be medians and the draws are evaluated at the mode.
    theta = climb(posterior, _parameters(estimates, counts, on_axis)).theta
    answers = rows[rows["cell"].isin(cells)]
    number = np.searchsorted(cells, answers["cell"])
    follows = np.bincount(number, answers["follows"], len(cells)) > 0
    return goodness(posterior, theta, _sequences(answers, number, on_axis(levels), counts), follows, rng)


def _logarithm(levels: Array) -> Array:
    return np.asarray(np.log(np.where(levels > 0, levels, 1.0)))  # unused slots stay 0


def _parameters(estimates: Sequence[Estimate], counts: Counts, on_axis: Callable[[Array], Array]) -> Array:
    """Return the parameters (n_sets, 4) on the scale of the counts."""
    fits = [estimate.fit for estimate in estimates]
    rows = [(f.threshold, f.width, f.lapse_rate, f.guess_rate) for f in (fit.function for fit in fits) if f]
    threshold, width, lapse, guess = np.array(rows, dtype=np.float64).T
    m = (on_axis(threshold) - counts.centre) / counts.spread
    v = np.log(width / counts.spread)
    return np.stack([m, v, lapse, guess], axis=1)


def _sequences(rows: pd.DataFrame, number: Indices, levels: Array, counts: Counts) -> Sequences:
    """Arrange the answers by set, stretch and level of `counts`."""
    u = (levels - counts.centre[:, None]) / counts.spread[:, None]
    is_apart = np.diff(u, axis=1) > POOLED_BELOW
    first = np.zeros((len(levels), 1), dtype=np.int64)
    places = np.concatenate([first, np.cumsum(is_apart, axis=1)], axis=1)
    rank = rows.groupby("cell")["x"].rank("dense").to_numpy().astype(np.int64) - 1
    where = (number, rows["stretch"].to_numpy(), places[number, rank])
    n_stretches = int(rows["stretch"].max()) + 1
    n_yes, n_trials = (np.zeros((len(levels), n_stretches, levels.shape[1])) for _ in range(2))
    np.add.at(n_yes, where, rows["yes"].to_numpy())
    np.add.at(n_trials, where, 1.0)
    return Sequences(n_yes, n_trials)


def goodness_table(estimates: pd.DataFrame) -> pd.DataFrame:
    """Return numbers of functions tested, flagged and flagged by chance."""
    tested = {name: estimates[column].dropna() for name, column in P_COLUMNS.items()}
    counts = {name: (len(p), int((p <= FLAGGED_P).sum()), FLAGGED_P * len(p)) for name, p in tested.items() if len(p)}
    rows = [(name, *numbers, TESTS[name]) for name, numbers in counts.items()]
    return pd.DataFrame(rows, columns=["test", "n_tested", "n_flagged", "n_by_chance", "meaning"])


def goodness_warnings(estimates: pd.DataFrame, factors: Sequence[str]) -> Iterator[str]:
    """Warn about each test that flags more functions than expected by chance."""
    for name, column in P_COLUMNS.items():
        p = estimates[column].dropna()
        if _is_surprising(p):
            flagged = estimates.loc[p.index[p <= FLAGGED_P]]
            yield (
                f"{len(flagged)} of {len(p)} fitted functions have p <= {FLAGGED_P:g} in the test of {name} (by chance "
                f"about {FLAGGED_P * len(p):.1f} of {len(p)} tests): {TESTS[name]} ({named_cells(flagged, factors)})"
            )


def _is_surprising(p: "pd.Series[float]") -> bool:
    """Return True if more p are small than expected by chance.

    >>> _is_surprising(pd.Series([0.001] + 9 * [0.5])), _is_surprising(pd.Series([0.009] + 9 * [0.5]))
    (True, False)
    """
    bounds = np.array([FLAGGED_P, FLAGGED_P / 10])
    n_small = (p.to_numpy()[:, None] <= bounds).sum(axis=0)
    chance_of_as_many = bdtrc(n_small - 1, len(p), bounds)
    return bool(((n_small > 0) & (chance_of_as_many <= SURPRISING)).any())
