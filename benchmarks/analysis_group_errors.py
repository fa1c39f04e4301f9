"""How often statistics of a group are wrong, simulated: `python benchmarks/analysis_group_errors.py [STUDIES]`.

Ten participants, four conditions or 3 x 4 (then the interaction). Prints in per cent: false alarms and power of the
analysis of variance under each correction, false alarms and coverage where values are bounds, coverage of simultaneous
intervals and of intervals within participants. 10 000 studies (a tenth with bounds) take five minutes.
"""

import sys
from collections.abc import Iterator
from contextlib import suppress
from itertools import combinations
from typing import Any

import numpy as np
import pandas as pd
from measured import tell
from scipy.special import fdtrc
from scipy.stats import t as student

from tactometry.analysis.anova.censored import censored_anova
from tactometry.analysis.anova.contrasts import ContrastEffect, contrasts, epsilons, permutation_p
from tactometry.analysis.anova.design import UndefinedStatistic
from tactometry.analysis.anova.group_means import DIFFERENCE, within_variances
from tactometry.analysis.anova.post_hoc import all_together

N, SEED = 10, 1
DESIGNS = {"4": ((4,), (0,)), "3 x 4": ((3, 4), (0, 1))}
ERRORS = ("spherical", "AR(1), 0.7", "noisy")
EFFECT = 1.1
"""Of the last condition, in standard deviations of the errors: about 80 % power of a spherical study."""
CUTS = (0.15, 0.3)
GIVEN: dict[str, Any] = {"dependent": "y", "low": "low", "high": "high", "within": "x", "subject": "who"}


def covariance(errors: str, n_cells: int) -> np.ndarray:
    """Of errors of variance 1, with participants of variance 4; "noisy": one condition of variance 9."""
    places = np.arange(n_cells)
    return (
        4.0
        + {
            "spherical": np.eye(n_cells),
            "AR(1), 0.7": 0.7 ** np.abs(np.subtract.outer(places, places)),
            "noisy": np.diag(np.where(places == 0, 9.0, 1.0)),
        }[errors]
    )


def studies(errors: str, n_cells: int, n: int, rng: np.random.Generator) -> np.ndarray:
    return rng.normal(size=(n, N, n_cells)) @ np.linalg.cholesky(covariance(errors, n_cells)).T


def detected(values: np.ndarray, design: str) -> dict[str, float]:
    """The share of studies with p < 5 % by each test."""
    n_levels, part = DESIGNS[design]
    scores = values @ contrasts(n_levels, part).T
    effects = [ContrastEffect(("x",), each) for each in scores]
    shapes = np.array([(1.0, *epsilons(effect.covariance, N - 1)) for effect in effects])
    df1, df2 = effects[0].df
    fs = np.array([N * np.sum(each.mean(axis=0) ** 2) for each in scores]) * df2 / df1
    fs /= [effect.ss_error for effect in effects]
    tests = ("uncorrected", "Greenhouse-Geisser", "Huynh-Feldt", "Chi-Muller")
    found = {
        name: np.mean(fdtrc(epsilon * df1, epsilon * df2, fs) < 0.05)
        for name, epsilon in zip(tests, shapes.T, strict=True)
    }
    return found | {"permutation": np.mean([permutation_p(effect) < 0.05 for effect in effects[:2000]])}


def of_variance(n: int, rng: np.random.Generator) -> Iterator[dict[str, object]]:
    for design, (n_levels, _) in DESIGNS.items():
        for errors in ERRORS:
            values = studies(errors, int(np.prod(n_levels)), n, rng)
            effect = EFFECT * (np.arange(values.shape[-1]) == values.shape[-1] - 1)
            for kind, moved in (("false alarms", values), ("power", values + effect)):
                yield {"design": design, "errors": errors, "share": kind} | detected(moved, design)


def of_bounds(n: int, rng: np.random.Generator) -> Iterator[dict[str, object]]:
    """Values below a cut are bounds; `answered` studies have two known values in each condition and a maximum; `mean`
    and `noisy mean`: coverage of the intervals of conditions."""
    keys = pd.MultiIndex.from_product([range(N), range(4)], names=["who", "x"]).to_frame(index=False)
    for errors in ERRORS:
        for share in CUTS:
            values = studies(errors, 4, n, rng)
            at = float(np.quantile(values[..., 1:], share))
            found = []
            for each in values.reshape(n, -1):
                table = keys.assign(y=np.where(each < at, np.nan, each), low=np.nan, high=at)
                with suppress(UndefinedStatistic):
                    found.append(censored_anova(table, **GIVEN))
            means = [each.means() for each in found]
            held = np.mean([(each["mean_low"] < 0) & (each["mean_high"] > 0) for each in means], axis=0)
            alarms = np.mean([each.table["p_CM_corr"][0] < 0.05 for each in found])
            of_means = {"noisy mean": held[0], "mean": held[1:].mean()}
            told = {"errors": errors, "bounds": share, "answered": len(found) / n, "false alarms": alarms}
            yield told | of_means


def of_intervals(n: int, rng: np.random.Generator) -> Iterator[dict[str, object]]:
    """Simultaneous intervals of the six pairs of four conditions, and two intervals within participants that meet."""
    places = list(combinations(range(4), 2))
    for errors in ERRORS:
        values = studies(errors, 4, n, rng)
        together, alone, contradicted = [], [], []
        for each in values:
            d = np.stack([each[:, b] - each[:, a] for a, b in places])
            mean, se = d.mean(axis=1), d.std(axis=1, ddof=1) / np.sqrt(N)
            half, p = student.isf(0.025, N - 1) * se, 2 * student.sf(np.abs(mean / se), N - 1)
            row = pd.DataFrame({"df": N - 1, "difference_low": mean - half, "difference_high": mean + half, "p_unc": p})
            found = all_together(row, "holm", 0.95)
            held = (found["simultaneous_low"] < 0) & (found["simultaneous_high"] > 0)
            together.append(held.all())
            alone.append(((found["difference_low"] < 0) & (found["difference_high"] > 0)).all())
            contradicted.append((~held & (found["p_corr"] >= 0.05)).any())
        halves = student.isf(0.025, N - 1) * np.sqrt([within_variances(np.cov(each.T)) / N for each in values])
        means = values.mean(axis=1)
        meet = [
            np.mean(np.abs(means[:, a] - means[:, b]) < DIFFERENCE * (halves[:, a] + halves[:, b])) for a, b in places
        ]
        yield {
            "errors": errors, "simultaneous": np.mean(together), "each alone": np.mean(alone),
            "against Holm": np.mean(contradicted), "within meet": np.mean(meet), "lowest pair": min(meet),
            "highest pair": max(meet),
        }  # fmt: skip


def main() -> None:
    n = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000
    rng = np.random.default_rng(SEED)
    tables = [
        pd.DataFrame(rows) for rows in (of_variance(n, rng), of_bounds(max(n // 10, 10), rng), of_intervals(n, rng))
    ]
    for table in tables:
        numbers = [name for name in table.columns if name != "bounds" and pd.api.types.is_numeric_dtype(table[name])]
        print((table.assign(**{name: 100 * table[name] for name in numbers})).round(1).to_string(index=False), "\n")
    variance, bounds, intervals = tables
    alarms = variance[variance["share"] == "false alarms"]
    for name in ("Chi-Muller", "Greenhouse-Geisser", "permutation"):
        tell(f"largest share of false alarms at 5 %, {name}", 100 * alarms[name].max(), "%", at_most=6)
    tell("the same where values are bounds", 100 * bounds["false alarms"].max(), "%")
    tell("least coverage of simultaneous intervals of 95 %", 100 * intervals["simultaneous"].min(), "%")


if __name__ == "__main__":
    main()
