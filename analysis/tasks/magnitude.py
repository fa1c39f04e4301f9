"""Magnitude estimation: exponent of the power law psi = k A^n.

The exponent is the slope of a straight line in logarithms, which does not depend on the participant's unit.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

from ..arrays import Array
from ..distributions import Student
from ..means import by_condition
from ..reading.rows import bad_cell, delivered_level, numbers_of
from .task_analysis import Results, TaskAnalysis

TASK = "magnitude"
DEPENDENT = "exponent"
GROWTH = "magnitude_levels"
"""Name of the table of `growth_table`."""
FEW_LEVELS = "no exponent: fewer than two levels with a number above 0"


def exponent(levels: Array, numbers: Array, interval: float = 0.95) -> dict[str, float | None]:
    """Return the slope of log geometric means over log amplitudes.

    With three or more levels a t-interval is included.

    >>> x = np.log([1.0, 2.0, 4.0, 1.0])
    >>> {name: round(v, 3) for name, v in exponent(x, np.array([2.0, 4.0, 16.0, 8.0])).items()}
    {'exponent': 1.0, 'exponent_low': -6.336, 'exponent_high': 8.336}
    """
    from scipy.stats import linregress  # slow to load

    means = pd.Series(np.log(numbers)).groupby(levels).mean()
    unknown: dict[str, float | None] = {"exponent": None, "exponent_low": None, "exponent_high": None}
    if len(means) < 2:
        return unknown
    line, df = linregress(means.index.to_numpy(float), means.to_numpy()), len(means) - 2
    slope = float(line.slope)
    if not df:
        return unknown | {"exponent": slope}
    half = float(Student.ppf((1 + interval) / 2, df) * line.stderr)
    return {"exponent": slope, "exponent_low": slope - half, "exponent_high": slope + half}


def magnitude_table(rows: pd.DataFrame, factors: Sequence[str]) -> pd.DataFrame:
    """Return the exponent by participant and condition.

    Numbers of 0 (not felt) are omitted and counted.

    Raises `InvalidFile` for a level not above 0 in a unit other than decibels.
    """
    return by_condition(_ratings(rows), ["participant", *factors], _row)


def growth_table(rows: pd.DataFrame, factors: Sequence[str]) -> pd.DataFrame:
    """Return geometric means by level, after modulus equalisation.

    Lane, Catania and Stevens 1961, Journal of the Acoustical Society of America 33(2), 160-167.
    """
    felt = _ratings(rows)
    felt = felt[felt["number"] > 0]
    if felt.empty:
        return pd.DataFrame()
    keys = [*factors, "x"]
    logs = felt.assign(log=np.log(felt["number"])).groupby(["participant", *keys], observed=True)["log"].mean()
    of_participants = logs.groupby("participant")
    # A participant's unit is an additive constant in logarithms; replace it by the mean constant.
    logs = logs - of_participants.transform("mean") + of_participants.mean().mean()
    growth = logs.groupby(keys, observed=True).agg(geometric_mean="mean", n="size").reset_index()
    return growth.assign(geometric_mean=np.exp(growth["geometric_mean"])).rename(columns={"x": "level"})


def _ratings(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the ratings with numbers, levels and log levels."""
    rows = rows[rows["level"].notna()]
    x = delivered_level(rows)
    in_db = rows["level_unit"].str.startswith("dB") if "level_unit" in rows.columns else pd.Series(False, rows.index)
    bad = rows[~in_db & (x <= 0)]
    if len(bad):
        expected = "an amplitude above 0 or a level_unit in decibels (dB ...)"
        raise bad_cell(bad.iloc[0], "level", f"{x[bad.index[0]]:g}", expected)
    # Decibels are already logarithms of amplitude (20 per factor of ten).
    log_level = np.where(in_db, x * np.log(10) / 20, np.log(x.where(~in_db, 1.0)))
    return rows.assign(number=numbers_of(rows["response"]), x=x, log_level=log_level)


def _row(ratings: pd.DataFrame) -> dict[str, Any]:
    felt = ratings[ratings["number"] > 0]
    slope = exponent(felt["log_level"].to_numpy(float), felt["number"].to_numpy(float))
    counts = {"n_ratings": len(ratings), "n_zero": len(ratings) - len(felt), "n_levels": felt["x"].nunique()}
    return {"task": TASK, **slope, **counts, "note": FEW_LEVELS if slope["exponent"] is None else ""}


ANALYSIS = TaskAnalysis(
    "Participants rated the strength of the stimulus with a number",
    "lme4::lmer(log(as.numeric(response)) ~ level{times} + (1 + level | participant), "
    "subset({data}, as.numeric(response) > 0))",
    results=Results(
        {TASK: magnitude_table, GROWTH: growth_table},
        "Exponents of the power law are slopes of the logarithm of each participant's geometric mean number over the "
        "logarithm of the amplitude, with equal weight of levels (Stevens 1957); numbers of 0 were omitted. Geometric "
        "means over participants were computed after modulus equalisation (Lane, Catania & Stevens 1961).",
        works=(
            "Stevens, S. S. (1957). On the psychophysical law. Psychological Review, 64, 153-181.",
            "Lane, H. L., Catania, A. C., & Stevens, S. S. (1961). Voice level: Autophonic scale, perceived loudness, "
            "and effects of sidetone. Journal of the Acoustical Society of America, 33, 160-167.",
        ),
        dependent=DEPENDENT,
        in_levels=False,
    ),
)
