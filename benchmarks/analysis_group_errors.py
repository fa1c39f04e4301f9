"""Simulate errors of group statistics: `python benchmarks/analysis_group_errors.py [STUDIES]`.

Studies have ten participants and four conditions, or 3 x 4 conditions (for the interaction). All results are in per
cent: false alarms and power of the analysis of variance with each correction, false alarms and coverage if some values
are bounds, and coverage of simultaneous intervals and of intervals within participants. 10 000 studies (a tenth with
bounds) take five minutes.
"""

import sys
from collections.abc import Iterator
from contextlib import suppress
from itertools import combinations, product
from typing import Any

import numpy as np
import pandas as pd
from scipy.special import fdtrc
from scipy.stats import t as student

from tactometry.analysis.anova.censored import censored_anova
from tactometry.analysis.anova.design import ContrastEffect, UndefinedStatistic, contrasts, epsilons, permutation_p
from tactometry.analysis.anova.group_means import DIFFERENCE, within_variances
from tactometry.analysis.anova.post_hoc import all_together
from tactometry.experiments.harness import tell
from tactometry.experiments.validation.checks.values import EFFECT, ERRORS, studies, with_effect

N, SEED, CUTS = 10, 1, (0.15, 0.3)
DESIGNS = {"4": ((4,), (0,)), "3 x 4": ((3, 4), (0, 1))}
GIVEN: dict[str, Any] = {"dependent": "y", "low": "low", "high": "high", "within": "x", "subject": "who"}


def detected(values: np.ndarray, design: str) -> dict[str, float]:
    """Return the share of studies with p < 5 % in each test."""
    scores = values @ contrasts(*DESIGNS[design]).T
    effects = [ContrastEffect(("x",), each) for each in scores]
    shapes = np.array([(1.0, *epsilons(effect.covariance, N - 1)) for effect in effects])
    df1, df2 = effects[0].df
    fs = np.array([N * np.sum(each.mean(axis=0) ** 2) for each in scores]) * df2 / df1
    fs /= [effect.ss_error for effect in effects]
    tests = zip(("uncorrected", "Greenhouse-Geisser", "Huynh-Feldt", "Chi-Muller"), shapes.T, strict=True)
    result = {name: np.mean(fdtrc(epsilon * df1, epsilon * df2, fs) < 0.05) for name, epsilon in tests}
    return result | {"permutation": np.mean([permutation_p(effect) < 0.05 for effect in effects[:2000]])}


def of_variance(n: int, rng: np.random.Generator) -> Iterator[dict[str, object]]:
    for design, errors in product(DESIGNS, ERRORS):
        values = studies(errors, N, n, rng, int(np.prod(DESIGNS[design][0])))
        for kind, effect in (("false alarms", 0.0), ("power", EFFECT)):
            result = detected(with_effect(values, effect), design)
            yield {"design": design, "errors": errors, "share": kind} | result


def of_bounds(n: int, rng: np.random.Generator) -> Iterator[dict[str, object]]:
    """Yield results for data in which values below a cut are bounds.

    `answered` is the share of studies with two known values in each condition and a maximum of the likelihood. `mean`
    and `noisy mean` are coverages.
    """
    keys = pd.MultiIndex.from_product([range(N), range(4)], names=["who", "x"]).to_frame(index=False)
    for errors, share in product(ERRORS, CUTS):
        values = studies(errors, N, n, rng)
        at, result = float(np.quantile(values[..., 1:], share)), []
        for each in values.reshape(n, -1):
            table = keys.assign(y=np.where(each < at, np.nan, each), low=np.nan, high=at)
            with suppress(UndefinedStatistic):
                result.append(censored_anova(table, **GIVEN))
        means = [each.means() for each in result]
        covered = np.mean([(each["mean_low"] < 0) & (each["mean_high"] > 0) for each in means], axis=0)
        alarms = np.mean([each.table["p_CM_corr"][0] < 0.05 for each in result])
        row = {"errors": errors, "bounds": share, "answered": len(result) / n, "false alarms": alarms}
        yield row | {"noisy mean": covered[0], "mean": covered[1:].mean()}


def of_intervals(n: int, rng: np.random.Generator) -> Iterator[dict[str, object]]:
    """Yield the coverage of simultaneous intervals for six pairs, and the overlap of intervals within participants."""
    places, t = list(combinations(range(4), 2)), student.isf(0.025, N - 1)
    for errors in ERRORS:
        values, rows = studies(errors, N, n, rng), []
        for each in values:
            d = np.stack([each[:, b] - each[:, a] for a, b in places])
            mean, se = d.mean(axis=1), d.std(axis=1, ddof=1) / np.sqrt(N)
            ends = {"difference_low": mean - t * se, "difference_high": mean + t * se}
            alone = pd.DataFrame({"df": N - 1, **ends, "p_unc": 2 * student.sf(np.abs(mean / se), N - 1)})
            result = all_together(alone, "holm", 0.95)
            covers = (result["simultaneous_low"] < 0) & (result["simultaneous_high"] > 0)
            own = (result["difference_low"] < 0) & (result["difference_high"] > 0)
            rows.append((covers.all(), own.all(), (~covers & (result["p_corr"] >= 0.05)).any()))
        together, each_alone, against_holm = np.mean(rows, axis=0)
        halves = t * np.sqrt([within_variances(np.cov(each.T)) / N for each in values])
        gaps = [np.abs(values[:, :, a].mean(axis=1) - values[:, :, b].mean(axis=1)) for a, b in places]
        reach = [DIFFERENCE * (halves[:, a] + halves[:, b]) for a, b in places]
        meet = np.mean(np.array(gaps) < reach, axis=1)
        row = {"errors": errors, "simultaneous": together, "each alone": each_alone, "against Holm": against_holm}
        yield row | {"within meet": meet.mean(), "lowest pair": meet.min(), "highest pair": meet.max()}


def main() -> None:
    n, rng = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000, np.random.default_rng(SEED)
    made = of_variance(n, rng), of_bounds(max(n // 10, 10), rng), of_intervals(n, rng)
    variance, bounds, intervals = tables = [pd.DataFrame(rows) for rows in made]
    for table in tables:
        numbers = [name for name in table.columns if name != "bounds" and pd.api.types.is_numeric_dtype(table[name])]
        print((table.assign(**{name: 100 * table[name] for name in numbers})).round(1).to_string(index=False), "\n")
    alarms = variance[variance["share"] == "false alarms"]
    for name in ("Chi-Muller", "Greenhouse-Geisser", "permutation"):
        tell(f"largest share of false alarms at 5 %, {name}", 100 * alarms[name].max(), "%", at_most=6)
    tell("the same where values are bounds", 100 * bounds["false alarms"].max(), "%")
    tell("least coverage of simultaneous intervals of 95 %", 100 * intervals["simultaneous"].min(), "%")


if __name__ == "__main__":
    main()
