"""Kinds of outcomes: estimates with intervals, tests with a p, ranks of truths; what a table says of many of them."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import pandas as pd
from scipy.stats import kstest

from ..census.shares import departure, share_interval

ALPHA: Final = 1e-4
"""What chance does more seldom is told as a departure."""
COVERAGE, LEVEL = 0.95, 0.05
N_BINS: Final = 20
WORDS: Final = {-1: "too few", 0: "", 1: "too many"}
FEWEST: Final = 20
"""Of fewer outcomes nothing is said."""
Estimate = tuple[float, float, float]
"""With the ends of its interval."""
NO_ANSWER: Final[Estimate] = (math.nan, math.nan, math.nan)


@dataclass(frozen=True)
class Kind:
    """What an outcome is.

    `columns` are those of an outcome; `row` makes the numbers of many outcomes, of which `judged` is the share that is
    held against what is stated; `heads` are the columns that a page shows, with their words.
    """

    name: str
    columns: tuple[str, ...]
    row: Callable[[pd.DataFrame], dict[str, Any]]
    heads: Mapping[str, str]


def summary(kind: Kind, outcomes: pd.DataFrame, keys: tuple[str, ...]) -> pd.DataFrame:
    """A row for each setting and method, in the order in which they come."""
    rows = [
        dict(zip(keys, key, strict=True)) | kind.row(each) for key, each in outcomes.groupby(list(keys), sort=False)
    ]
    return pd.DataFrame(rows)


def _share(holds: "pd.Series[bool]", stated: float) -> dict[str, Any]:
    """A share with its exact 95 % interval, what is stated, and whether chance explains the difference."""
    n, n_yes = len(holds), int(holds.sum())
    if not n:
        return {"n": 0, "share": math.nan, "low": math.nan, "high": math.nan, "stated": stated, "verdict": ""}
    low, high = share_interval(n_yes, n)
    off = 0 if math.isnan(stated) or n < FEWEST else departure(n_yes, n, stated, ALPHA)
    return {"n": n, "share": n_yes / n, "low": low, "high": high, "stated": stated, "verdict": WORDS[off]}


def _estimates(outcomes: pd.DataFrame) -> dict[str, Any]:
    """Of those that told a value: bias with its standard error, how often the interval holds the truth, its median
    width. Of those that told none: how many, and how often the bound that is told holds."""
    told = outcomes["estimate"].notna()
    low, high = outcomes["low"].fillna(-np.inf), outcomes["high"].fillna(np.inf)
    holds = (low <= outcomes["truth"]) & (outcomes["truth"] <= high)
    with_interval = told & outcomes[["low", "high"]].notna().any(axis=1)
    error = (outcomes["estimate"] - outcomes["truth"])[told]
    n_told = int(told.sum())
    return _share(holds[with_interval], COVERAGE) | {
        "sets": len(outcomes),
        "none": 1 - n_told / len(outcomes),
        "bounds": float(holds[~told].mean()) if n_told < len(outcomes) else math.nan,
        "bias": float(error.mean()) if n_told else math.nan,
        "bias_se": float(error.std() / math.sqrt(n_told)) if n_told > 1 else math.nan,
        "error_sd": float(error.std()) if n_told > 1 else math.nan,
        "width": float((high - low)[with_interval].median()) if with_interval.any() else math.nan,
    }


def _tests(outcomes: pd.DataFrame) -> dict[str, Any]:
    """The share of p below 5 %, and of studies without an answer."""
    tested = outcomes["p"].notna()
    stated = LEVEL if not outcomes["effect"].any() else math.nan
    of_tested = _share(outcomes["p"][tested] < LEVEL, stated)
    return of_tested | {"sets": len(outcomes), "none": float((~tested).mean())}


def _ranks(outcomes: pd.DataFrame) -> dict[str, Any]:
    """The exact test of Kolmogorov and Smirnov of ranks that ought to be uniform, the share of truths in the middle
    95 %, and how many ranks there are in each twentieth."""
    ranks = outcomes["rank"].to_numpy()
    p = float(kstest(ranks, "uniform", method="exact").pvalue)
    middle = pd.Series((ranks > (1 - COVERAGE) / 2) & (ranks < (1 + COVERAGE) / 2))
    counts = np.histogram(ranks, N_BINS, (0.0, 1.0))[0]
    bins = {f"bin_{place:02d}": int(n) for place, n in enumerate(counts, 1)}
    found = _share(middle, COVERAGE)
    verdict = "not uniform" if p < ALPHA else found["verdict"]
    return found | {"verdict": verdict, "sets": len(ranks), "p": p} | bins


ESTIMATES = Kind(
    "estimates",
    ("truth", "estimate", "low", "high"),
    _estimates,
    {
        "sets": "sets",
        "none": "no value / %",
        "bias": "bias",
        "error_sd": "SD of error",
        "share": "95 % interval holds / %",
        "verdict": "",
        "width": "its width",
        "bounds": "bound holds / %",
    },
)
TESTS = Kind(
    "tests",
    ("effect", "p"),
    _tests,
    {"sets": "studies", "none": "no answer / %", "share": "p < 5 % / %", "verdict": ""},
)
RANKS = Kind(
    "ranks",
    ("rank",),
    _ranks,
    {"sets": "sets", "p": "p of uniform ranks", "share": "in the middle 95 % / %", "verdict": ""},
)
