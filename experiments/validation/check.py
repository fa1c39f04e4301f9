"""Checks of methods against known ground truth."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
import pandas as pd
from scipy.stats import kstest

from ..harness import departure, share_interval

ALPHA: Final = 1e-4
"""Significance level for the difference of a share from its stated value."""
COVERAGE, LEVEL = 0.95, 0.05
N_BINS: Final = 20
VERDICTS: Final = {-1: "too few", 0: "", 1: "too many"}
FEWEST: Final = 20
"""Smallest number of outcomes that get a verdict."""
Estimate = tuple[float, float, float]
"""Estimate, and the lower and upper end of its interval."""
NO_ANSWER: Final[Estimate] = (math.nan, math.nan, math.nan)
Simulate = Callable[[int, np.random.Generator], pd.DataFrame]
"""Function that simulates a number of sets. It returns a table with the columns of the check's keys and kind."""


@dataclass(frozen=True)
class Kind:
    """Kind of outcomes, with their columns and summary.

    `columns` are the columns of an outcome. `row` summarises many outcomes. `heads` are the column heads on the page.
    """

    name: str
    columns: tuple[str, ...]
    row: Callable[[pd.DataFrame], dict[str, Any]]
    heads: Mapping[str, str]


@dataclass(frozen=True)
class Check:
    """Check of one or more methods.

    - `words`: Description of the simulation and of the expected result.
    - `keys`: Columns that identify a row of the table. The last one names the method.
    - `settings`: Simulation functions by name.
    - `n_sets`: Number of sets, groups or studies in a chunk of a setting.
    - `reasons`: Reasons why a method may differ from its stated value, by method.
    - `figure`: Name of the figure, or an empty text.
    - `method`: Column of `keys` with the methods, by default the last one.
    """

    title: str
    words: str
    kind: Kind
    keys: tuple[str, ...]
    settings: Mapping[str, Simulate]
    n_sets: int
    reasons: Mapping[str, str] = field(default_factory=dict)
    figure: str = ""
    method: str = ""
    name: str = ""

    @property
    def reason_key(self) -> str:
        return self.method or self.keys[-1]


def summary(kind: Kind, outcomes: pd.DataFrame, keys: tuple[str, ...]) -> pd.DataFrame:
    """Return a row for each setting and method, in order of appearance."""
    groups = outcomes.groupby(list(keys), sort=False)
    return pd.DataFrame([dict(zip(keys, key, strict=True)) | kind.row(each) for key, each in groups])


def _share(holds: "pd.Series[bool]", stated: float) -> dict[str, Any]:
    """Return a share with its exact 95 % interval and its verdict."""
    n, n_yes = len(holds), int(holds.sum())
    if not n:
        return {"n": 0, "share": math.nan, "low": math.nan, "high": math.nan, "stated": stated, "verdict": ""}
    low, high = share_interval(n_yes, n)
    off = 0 if math.isnan(stated) or n < FEWEST else departure(n_yes, n, stated, ALPHA)
    return {"n": n, "share": n_yes / n, "low": low, "high": high, "stated": stated, "verdict": VERDICTS[off]}


def _estimates(outcomes: pd.DataFrame) -> dict[str, Any]:
    """Return bias, coverage and median width of estimates."""
    has_value = outcomes["estimate"].notna()
    low, high = outcomes["low"].fillna(-np.inf), outcomes["high"].fillna(np.inf)
    covers = (low <= outcomes["truth"]) & (outcomes["truth"] <= high)
    has_interval = has_value & outcomes[["low", "high"]].notna().any(axis=1)
    error, n = (outcomes["estimate"] - outcomes["truth"])[has_value], int(has_value.sum())
    error_sd = float(error.std()) if n > 1 else math.nan
    return _share(covers[has_interval], COVERAGE) | {
        "sets": len(outcomes),
        "none": 1 - n / len(outcomes),
        "bounds": float(covers[~has_value].mean()) if n < len(outcomes) else math.nan,
        "bias": float(error.mean()) if n else math.nan,
        "bias_se": error_sd / math.sqrt(max(n, 1)),
        "error_sd": error_sd,
        "width": float((high - low)[has_interval].median()) if has_interval.any() else math.nan,
    }


def _tests(outcomes: pd.DataFrame) -> dict[str, Any]:
    """Return the share of studies with p below 5 %, and without a result."""
    tested = outcomes["p"].notna()
    stated = LEVEL if not outcomes["effect"].any() else math.nan
    of_tested = _share(outcomes["p"][tested] < LEVEL, stated)
    return of_tested | {"sets": len(outcomes), "none": float((~tested).mean())}


def _ranks(outcomes: pd.DataFrame) -> dict[str, Any]:
    """Test ranks for uniformity (exact Kolmogorov-Smirnov), with a histogram."""
    ranks = outcomes["rank"].to_numpy()
    p = float(kstest(ranks, "uniform", method="exact").pvalue)
    middle = pd.Series((ranks > (1 - COVERAGE) / 2) & (ranks < (1 + COVERAGE) / 2))
    counts = np.histogram(ranks, N_BINS, (0.0, 1.0))[0]
    bins = {f"bin_{place:02d}": int(n) for place, n in enumerate(counts, 1)}
    result = _share(middle, COVERAGE)
    verdict = "not uniform" if p < ALPHA else result["verdict"]
    return result | {"verdict": verdict, "sets": len(ranks), "p": p} | bins


ESTIMATES = Kind(
    "estimates",
    ("truth", "estimate", "low", "high"),
    _estimates,
    {
        "sets": "sets",
        "none": "no value / %",
        "bias": "bias",
        "error_sd": "SD of error",
        "share": "95 % interval covers truth / %",
        "verdict": "",
        "width": "its width",
        "bounds": "bound covers truth / %",
    },
)
TESTS = Kind(
    "tests",
    ("effect", "p"),
    _tests,
    {"sets": "studies", "none": "no result / %", "share": "p < 5 % / %", "verdict": ""},
)
RANKS = Kind(
    "ranks",
    ("rank",),
    _ranks,
    {"sets": "sets", "p": "p of uniform ranks", "share": "in the middle 95 % / %", "verdict": ""},
)
