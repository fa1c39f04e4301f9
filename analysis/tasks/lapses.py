"""Likelihood-ratio test of lapse rates between conditions."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pandas as pd
from scipy.special import chdtrc, chdtri

from tactometry.psychometric import shape_named

from ..arrays import Array
from ..wording import condition_name, p_text
from .cell import Estimate
from .kinds import CURVES

TASKS = tuple(name for name, curve in CURVES.items() if not curve.has_difference)
LAPSES = "lapse_rates"
"""Name of the table."""
ALPHA, WARNED_P = 0.05, 0.02
"""Significance levels of the intervals and of the warning. With ten participants, 9 % of null studies had p < .05 (11
of 120, QUEST+)."""
RATES = np.linspace(0.0, 0.3, 31)
N_THRESHOLDS, N_WIDTHS, NARROWEST, WIDEST = 61, 15, 20.0, 3.0
"""Grid of the maximisation: widths from range / `NARROWEST` to `WIDEST` times the range of the levels."""
LEAST = 1e-9


def lapse_table(estimates: Sequence[Estimate], factors: Sequence[str]) -> pd.DataFrame:
    """Estimate the lapse rate of each condition, and test for equality.

    There is one row per condition, with an interval of the profile likelihood (maximised over the participants'
    thresholds and widths).
    """
    keys = [*factors, "task"]
    known = [one for one in estimates if one.cell.task in TASKS and one.fit.threshold is not None]
    rows = [(*one.cell.condition, one.cell.task, profile(one)) for one in known if len(one.cell.levels) > 1]
    if not rows:
        return pd.DataFrame()
    table = pd.DataFrame(rows, columns=[*keys, "profile"])
    found = table.groupby(keys, observed=True)["profile"].agg(n="size", profile="sum").reset_index()
    return pd.concat([_tested(of_task) for _, of_task in found.groupby("task", sort=False)]).drop(columns="profile")


def _tested(conditions: pd.DataFrame) -> pd.DataFrame:
    profiles = np.stack(conditions["profile"].tolist())
    highest = profiles.max(axis=1)
    likely = profiles >= highest[:, None] - chdtri(1, ALPHA) / 2
    chi_square = 2 * (highest.sum() - profiles.sum(axis=0).max())
    df = len(conditions) - 1
    return conditions.assign(
        lapse_rate=RATES[profiles.argmax(axis=1)],
        lapse_rate_low=RATES[likely.argmax(axis=1)],
        lapse_rate_high=RATES[len(RATES) - 1 - likely[:, ::-1].argmax(axis=1)],
        chi_square=chi_square,
        df=df,
        p=chdtrc(df, chi_square) if df else np.nan,
    )


def profile(estimate: Estimate) -> Array:
    """Return the profile log-likelihood of `RATES` at the fitted guess rate."""
    cell, fit = estimate.cell, estimate.fit
    shape = shape_named(fit.shape)
    levels, threshold = np.array(cell.levels), float(fit.threshold or 0.0)
    x, middle = (np.log(levels), np.log(threshold)) if shape.on_log_levels else (levels, threshold)
    span = np.ptp(x)
    thresholds = np.linspace(middle - span / 2, middle + span / 2, N_THRESHOLDS)
    widths = np.geomspace(span / NARROWEST, WIDEST * span, N_WIDTHS)
    z = shape.z50 + (x[:, None, None] - thresholds[:, None]) / widths * shape.z_width
    felt = np.exp(shape.log_cdf(z)).reshape(len(x), -1)
    guess_rate = fit.guess_rate or 0.0
    yes = np.clip(guess_rate + (1 - guess_rate - RATES[:, None, None]) * felt, LEAST, 1 - LEAST)
    n_yes, n_no = np.array(cell.n_yes), np.subtract(cell.n_trials, cell.n_yes)
    return np.asarray((n_yes @ np.log(yes) + n_no @ np.log1p(-yes)).max(axis=1))


def lapse_warnings(table: pd.DataFrame, factors: Sequence[str]) -> Iterator[str]:
    """Warn about tasks whose conditions differ in lapse rate."""
    different = table[table["p"] < WARNED_P] if len(table) else table
    for task, conditions in different.groupby("task", sort=False) if len(different) else ():
        ordered = conditions.sort_values("lapse_rate", kind="stable")
        least, most = (_rate_text(ordered.iloc[place], factors) for place in (0, -1))
        test = f"chi-square({ordered['df'].iloc[0]}) = {ordered['chi_square'].iloc[0]:.1f}"
        yield (
            f"lapse rates of {task} differ between conditions, from {least} to {most} (likelihood-ratio test: {test}, "
            f"{p_text(ordered['p'].iloc[0])}): thresholds may differ for this reason alone. Add easy trials to measure "
            "the lapse rate (easy_share of [procedure])"
        )


def _rate_text(row: "pd.Series[Any]", factors: Sequence[str]) -> str:
    rate, low, high = (100 * row[f"lapse_rate{end}"] for end in ("", "_low", "_high"))
    return f"{rate:.1f} [{low:.1f}, {high:.1f}] % at {condition_name(factors, [row[name] for name in factors])}"
