"""Tests of comparisons: PSE against the standard, and lowest level."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pandas as pd
from scipy.special import bdtrc

from ..anova.group_means import COUNTS, MEANS
from ..distributions import Student
from ..means import POSITIVE, mean_row
from ..reading.level_scale import is_logarithm
from ..reading.rows import numbers_of
from ..threshold.status import Status
from ..wording import condition_name, in_unit, interval_text, p_text, percent_text
from .cell import Cell
from .kinds import CURVES

TASKS = tuple(name for name, curve in CURVES.items() if curve.has_difference)
STANDARD, UNIT = "standard_level", "level_unit"
TESTS, FLOORS = "standard", "lowest_levels"
"""Names of the tables."""
JND = ("jnd", "jnd_low", "jnd_high")
FEWEST = 3
"""Smallest number of participants for a t-test; fewer are tested individually by posterior interval."""
HIGHEST_FLOOR = 0.05
"""Largest rate of "more" at the lowest level that lapses explain: half of 10 % lapses (unverified default)."""
FLOOR_P = 0.01


def standard_tests(
    estimates: pd.DataFrame, used: pd.DataFrame, factors: Sequence[str], jnds: pd.DataFrame | None = None
) -> pd.DataFrame:
    """Test whether points of subjective equality differ from the standard.

    A t-test needs `FEWEST` participants. With fewer, `differs` is True if the standard lies outside the 95 % posterior
    interval, and missing without an interval. Mean JNDs are those of the group table `jnds`, which accounts for bounds.
    `weber_fraction` is the JND divided by the standard, both as amplitudes if levels are logarithms. The result is
    empty without a standard.
    """
    compared = estimates[estimates["task"].isin(TASKS)] if len(estimates) else estimates
    if compared.empty or STANDARD not in used.columns:
        return pd.DataFrame()
    keys = ["participant", *factors]
    rows = used[used["task"].isin(TASKS)]
    standards = rows.assign(**{STANDARD: numbers_of(rows[STANDARD])}).dropna(subset=[STANDARD])
    in_cell = standards.groupby(keys, observed=True)[STANDARD].agg(["first", "nunique"])
    one = in_cell.loc[in_cell["nunique"] == 1, "first"].rename(STANDARD).reset_index()
    compared = compared.merge(one, on=keys)
    # For flat cells the interval assumes that a point of equality exists, so it is not used.
    is_told = compared["pse"].notna() | compared["status"].isin((Status.BELOW, Status.ABOVE))
    for name, of in (("difference", "pse"), ("low", "interval_low"), ("high", "interval_high")):
        compared[name] = (compared[of].astype(float) - compared[STANDARD]).where(is_told)
    by = [*factors, STANDARD]
    tested = [row for key, cells in compared.groupby(by, observed=True) for row in _tests(cells, by, key, jnds)]
    return pd.DataFrame([{**row, "weber_fraction": _weber_fraction(row, compared[UNIT].iloc[0])} for row in tested])


def _weber_fraction(row: dict[str, Any], unit: str) -> float | None:
    """Return the just noticeable difference divided by the standard, or None.

    >>> round(_weber_fraction({"jnd": 1.5836, "standard_level": 40.0}, "dB re 1 V"), 4)
    0.2
    """
    jnd, standard = row["jnd"], row[STANDARD]
    if pd.isna(jnd):
        return None
    if is_logarithm(unit):
        return float(10 ** (jnd / (20 if unit.startswith("dB") else 1)) - 1)
    return float(jnd / standard) if standard > 0 else None


def _tests(
    cells: pd.DataFrame, by: Sequence[str], key: tuple[object, ...], jnds: pd.DataFrame | None
) -> Iterator[dict[str, object]]:
    condition = dict(zip(by, key, strict=True))
    known = cells["difference"].dropna()
    if len(known) >= FEWEST:
        counts = {"n": len(known), "n_without": len(cells) - len(known)}
        yield {"participant": "", **condition, **counts, **_t_test(known), **_mean_jnd(cells, by[:-1], key, jnds)}
        return
    for row in cells.to_dict("records"):
        low, high = (np.nan_to_num(row[end], nan=side * np.inf) for end, side in (("low", -1), ("high", 1)))
        differs = bool(low > 0 or high < 0) if np.isfinite([low, high]).any() else None
        n = int(pd.notna(row["difference"]))
        interval = {"difference": row["difference"], "difference_low": row["low"], "difference_high": row["high"]}
        jnd = {name: row[name] for name in JND}
        counts = {"n": n, "n_without": 1 - n}
        yield {"participant": row["participant"], **condition, **counts, **interval, "differs": differs, **jnd}


def _mean_jnd(
    cells: pd.DataFrame, factors: Sequence[str], key: tuple[object, ...], jnds: pd.DataFrame | None
) -> dict[str, object]:
    """Return the mean JND of a condition."""
    if jnds is not None and len(row := jnds[(jnds[list(factors)] == list(key[:-1])).all(axis=1)]) == 1:
        group = row.iloc[0]
        if group[list(COUNTS)].sum() == len(cells):
            return {**dict(zip(JND, group[list(MEANS[:3])], strict=True)), "n_jnd": int(group["n"])}
    known = cells["jnd"].dropna().to_numpy(dtype=float)
    mean = mean_row(known, name="jnd", possible=POSITIVE)
    return {**{name: mean[name] for name in JND}, "n_jnd": len(known)}


def _t_test(differences: "pd.Series[float]") -> dict[str, object]:
    """Return the mean difference with interval and t-test, if defined."""
    row = mean_row(np.asarray(differences, dtype=np.float64), name="difference")
    sd, n = row.pop("sd"), len(differences)
    if not sd:
        return row
    statistic = float(differences.mean()) / (float(differences.std(ddof=1)) / np.sqrt(n))
    p = float(2 * Student.sf(abs(statistic), n - 1))
    return {**row, "t": statistic, "df": n - 1, "p": p, "differs": p < 0.05}


def lowest_levels(cells: Sequence[Cell], factors: Sequence[str]) -> pd.DataFrame:
    """Test if "more" is too frequent at the lowest level (binomial)."""
    keys = [*factors, "task"]
    compared = [cell for cell in cells if cell.task in TASKS and cell.levels]
    rows = [(*cell.condition, cell.task, cell.n_yes[0], cell.n_trials[0]) for cell in compared]
    if not rows:
        return pd.DataFrame()
    counts = pd.DataFrame(rows, columns=[*keys, "n_more", "n_trials"])
    table = counts.groupby(keys, observed=True).sum().reset_index()
    p = bdtrc(table["n_more"] - 1, table["n_trials"], HIGHEST_FLOOR)
    return table.assign(rate=table["n_more"] / table["n_trials"], p=p)


def floor_warnings(table: pd.DataFrame, factors: Sequence[str]) -> Iterator[str]:
    """Warn about too many "more" answers at the lowest level."""
    for row in table.to_dict("records"):
        if row["p"] <= FLOOR_P:
            where = condition_name(factors, [row[name] for name in factors])
            yield (
                f'at the lowest level {percent_text(row["rate"])} of {row["n_trials"]} answers were "more" ({where}; '
                f"exact binomial test against {percent_text(HIGHEST_FLOOR)}: {p_text(row['p'])}): the standard may "
                "be near the detection threshold, or the lowest level may be too high. The hierarchical model, whose "
                "lower asymptote is 0, is then biased. The JND is the one above the PSE"
            )


def standard_sentences(table: pd.DataFrame, factors: Sequence[str], unit: str) -> list[str]:
    """Return a sentence for each test against the standard."""
    return [_sentence(row, factors, f" {unit}" if unit else "") for row in table.to_dict("records")]


def _sentence(row: dict[Any, Any], factors: Sequence[str], unit: str) -> str:
    where = condition_name(factors, [row[name] for name in factors])
    who = f"{row['participant']}, {where}" if row["participant"] else where
    ends = row.get("difference_low"), row.get("difference_high")
    text = f"{who}: no PSE to compare with the standard of {row[STANDARD]:g}{unit}"
    if pd.notna(row["difference"]):
        result = in_unit(interval_text(row["difference"], *ends), unit.partition(" re ")[0].strip())
        text = f"{who}: PSE minus the standard of {row[STANDARD]:g}{unit} = {result}"
    if pd.notna(row.get("p")):
        text += f", t({row['df']:.0f}) = {row['t']:.2f}, {p_text(row['p'])}"
    elif row["participant"] and pd.notna(row["differs"]):
        text += f", the 95 % interval {'excludes' if row['differs'] else 'contains'} 0"
    if pd.notna(row["jnd"]):
        jnd = in_unit(interval_text(*(row[name] for name in JND)), unit.partition(" re ")[0].strip())
        text += f"; JND = {jnd}" + (f" (n = {row['n_jnd']})" if row.get("n_jnd", row["n"]) != row["n"] else "")
    if pd.notna(row["weber_fraction"]):
        text += f", Weber fraction {percent_text(row['weber_fraction'])}"
    lost = f" ({row['n_without']} without a PSE left out)" if row["n_without"] and not row["participant"] else ""
    return f"{text}{lost}"
