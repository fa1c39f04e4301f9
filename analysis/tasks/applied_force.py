"""Whether the finger pressed as it was told: applied force per condition, time in band, and rules of exclusion.

Rules are stated before the data are seen, in a file or as arguments; without any, nothing is left out.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
import pandas as pd

from tactometry.errors import InvalidParameter, nearest

from ..outcomes.group_means import mean_with_interval, quality
from ..reading.trials import Trials, used_rows
from ..wording.labels import percent_text
from ..wording.numbers import decimals_of

TARGET = "force_n"
MEASURED = ("force_mean_n", "force_sd_n", "force_in_band")


@dataclass(frozen=True)
class Exclusion:
    """Which trials and participants are left out; None: no such rule.

    Parameters
    ----------
    force_in_band_share_min : float, optional
        A trial with a smaller share of its stimulus in the target band is left out.
    force_deviation_ratio_max : float, optional
        A trial whose mean force deviates from the target (the factor `force_n`) by more than this part of it.
    latency_min_s, latency_max_s : float, optional
        A trial that was answered faster or slower.
    false_alarm_share_max : float, optional
        A participant with a larger rate of "yes" in catch trials.
    invalid_share_max : float, optional
        A participant with a larger part of invalid trials.

    Raises
    ------
    InvalidParameter
        If a bound is not a number from 0 (shares: to 1), or the bounds of the latency are crossed.
    """

    force_in_band_share_min: float | None = None
    force_deviation_ratio_max: float | None = None
    latency_min_s: float | None = None
    latency_max_s: float | None = None
    false_alarm_share_max: float | None = None
    invalid_share_max: float | None = None

    def __post_init__(self) -> None:
        shares = ("force_in_band_share_min", "false_alarm_share_max", "invalid_share_max")
        for name, value in self.stated().items():
            top = 1.0 if name in shares else np.inf
            if not 0 <= value <= top or not np.isfinite(value):
                raise InvalidParameter(f"{name}: found {value}, expected a number from 0{' to 1' if top == 1 else ''}")
        if (self.latency_min_s or 0.0) >= (self.latency_max_s or np.inf):
            raise InvalidParameter(
                f"latency_max_s: found {self.latency_max_s}, expected more than latency_min_s, {self.latency_min_s}"
            )

    def stated(self) -> dict[str, float]:
        """The rules that there are.

        >>> Exclusion(force_in_band_share_min=0.8).stated()
        {'force_in_band_share_min': 0.8}
        """
        values = {each.name: getattr(self, each.name) for each in fields(self)}
        return {name: value for name, value in values.items() if value is not None}


def applied(trials: Trials, rules: Exclusion) -> tuple[Trials, pd.DataFrame]:
    """The trials that the rules leave, and a table of what they left out: `participant, rule, bound, n_trials`.

    Raises
    ------
    InvalidParameter
        If a rule needs a column that the table does not have.
    """
    broken = {name: _broken(trials, name, bound) for name, bound in rules.stated().items()}
    rows = trials.rows
    lost = [
        {"participant": code, "rule": name, "bound": rules.stated()[name], "n_trials": int(part.sum())}
        for name, bad in broken.items()
        for code, part in bad.groupby(rows["participant"], sort=True)
        if part.any()
    ]
    out = np.logical_or.reduce([bad.to_numpy() for bad in broken.values()]) if broken else np.zeros(len(rows), bool)
    kept = replace(trials, rows=rows[~out].reset_index(drop=True))
    return kept, pd.DataFrame(lost, columns=["participant", "rule", "bound", "n_trials"])


def _broken(trials: Trials, name: str, bound: float) -> "pd.Series[bool]":
    """Rows that break a rule; what was not measured breaks none."""
    rows = trials.rows
    if name == "force_in_band_share_min":
        return _column(rows, "force_in_band", name) < bound
    if name == "force_deviation_ratio_max":
        target = pd.to_numeric(_column(rows, TARGET, name), errors="coerce")
        return (_column(rows, "force_mean_n", name) - target).abs() > bound * target
    if name == "latency_min_s":
        return _column(rows, "latency_s", name) < bound
    if name == "latency_max_s":
        return _column(rows, "latency_s", name) > bound
    found = quality(trials).set_index("participant")
    share = found["false_alarm_rate"] if name == "false_alarm_share_max" else found["n_invalid"] / found["n_rows"]
    return rows["participant"].map(share > bound).astype(bool)


def _column(rows: pd.DataFrame, name: str, rule: str) -> "pd.Series[float]":
    if name not in rows.columns:
        hint = nearest(name, [str(column) for column in rows.columns])
        raise InvalidParameter(f"{rule}: found no column {name!r}{hint}, which this rule needs")
    return rows[name]


def has_force(trials: Trials) -> bool:
    """Whether the applied force was measured."""
    return "force_mean_n" in trials.rows.columns and bool(trials.rows["force_mean_n"].notna().any())


def force_of_participants(trials: Trials) -> pd.DataFrame:
    """Per participant and condition, over the trials that are used: mean applied force, mean of the standard deviations
    within trials, share of time in band, number of trials with a measured force; and the deviation from the target
    where the force is a factor."""
    rows = used_rows(trials)
    rows = rows[rows["force_mean_n"].notna()]
    keys = ["participant", *trials.factors]
    known = [name for name in MEASURED if name in rows.columns]
    grouped = rows.groupby(keys, sort=True, observed=True)
    found = grouped[known].mean().join(grouped.size().rename("n_trials")).reset_index()
    if TARGET in trials.factors:
        found["force_deviation_n"] = found["force_mean_n"] - found[TARGET].astype(float)
    return found


def force_table(own: pd.DataFrame, factors: Sequence[str], interval: float = 0.95) -> pd.DataFrame:
    """Per condition the mean applied force over participants with its t-interval (the thesis's table 6.2), the mean
    time in band, and `text` for a table of text."""
    grouped = [((), own)] if not factors else own.groupby(list(factors), sort=True, observed=True)
    rows = [dict(zip(factors, key, strict=True)) | _force_row(part, interval) for key, part in grouped]
    return pd.DataFrame(rows)


def _force_row(part: pd.DataFrame, interval: float) -> dict[str, object]:
    values = np.array(part["force_mean_n"], dtype=np.float64)
    row: dict[str, object] = dict.fromkeys(("mean", "mean_low", "mean_high", "sd"))
    row |= mean_with_interval(values, interval) | {"n": len(values), "n_trials": int(part["n_trials"].sum())}
    band = ""
    if "force_in_band" in part.columns and part["force_in_band"].notna().any():
        in_band = float(part["force_in_band"].mean())
        row["in_band"], band = in_band, f", {percent_text(in_band)} in band"
    mean = float(values.mean())
    sd = "" if row["sd"] is None else f" ± {row['sd']:.{decimals_of(mean)}f}"
    return row | {"text": f"{mean:.{decimals_of(mean)}f}{sd} N{band}"}
