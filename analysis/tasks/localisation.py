"""Localisation: correct answers by distance, confusions, resolution.

The rate correct among m places rises with their distance from 1/m to 1. At the resolution it is halfway, for example 75
% for two places, as in any forced choice (Green and Swets 1966).
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from ..means import MEAN, POSITIVE, by_condition, mean_row, parts as split, rate_interval
from ..reading.rows import correctness, numbers_of
from ..threshold.estimates import ThresholdFit
from ..threshold.fitting import fit_many
from .cell import Cell, Estimate, counted_cells, stacked_counts
from .goodness import SEED, goodness_columns
from .task_analysis import Results, TaskAnalysis

TASK, RESOLUTION, CONFUSIONS, ERRORS = "localisation", "resolution", "confusions", "localisation_errors"
OF_PARTICIPANTS, RATES = "resolution_participants", "localisation_participants"
DISTANCE, ERROR, RATE = "separation_m", "error_m", "rate_correct"
SHAPE = "weibull"
"""Shape of the rate correct as a function of distance, which is above 0."""
FEW_LEVELS = 8
"""Largest number of levels that count as conditions; more levels come from an adaptive procedure."""


def conditions_of(rows: pd.DataFrame, factors: Sequence[str]) -> list[str]:
    """Return the factors except place and distance, plus few levels."""
    places = {place_factor(rows, [name]) for name in factors}
    kept = [name for name in factors if name not in places and not _is_distance(rows, name)]
    n_levels = rows["level"].nunique() if "level" in rows.columns else 0
    return [*kept, "level"] if 1 < n_levels <= FEW_LEVELS else kept


def place_factor(rows: pd.DataFrame, factors: Sequence[str]) -> str | None:
    """Return the factor whose levels are the alternatives."""
    for name in factors:
        is_varied = rows[name].nunique() > 1
        if is_varied and _follows(rows, "target", name) and _follows(rows, name, "target"):
            return name
    return None


def n_alternatives(rows: pd.DataFrame) -> int:
    """Return the number of alternatives, at least 2."""
    stated = rows["n_alternatives"].max() if "n_alternatives" in rows.columns else np.nan
    return int(np.fmax(max(2, rows["target"].max(), numbers_of(rows["response"]).max()), stated))


def _is_distance(rows: pd.DataFrame, name: str) -> bool:
    return DISTANCE in rows.columns and rows[DISTANCE].nunique() > 1 and _follows(rows, DISTANCE, name)


def _follows(rows: pd.DataFrame, value: str, name: str) -> bool:
    """Return True if each level of a factor has a single value."""
    return bool((rows.groupby(name, observed=True)[value].nunique() <= 1).all())


def right_answers(rows: pd.DataFrame, factors: Sequence[str]) -> pd.DataFrame:
    """Return rates correct by distance, pooled over participants."""
    judged = _judged(rows)
    counts = _counts(judged, [*conditions_of(judged, factors), *_distance(judged)])
    if counts.empty:
        return counts
    low, high = rate_interval(counts["n_correct"], counts["n_trials"])
    return counts.assign(rate=counts["n_correct"] / counts["n_trials"], rate_low=low, rate_high=high)


def rates_of_participants(rows: pd.DataFrame, factors: Sequence[str]) -> pd.DataFrame:
    """Return rates correct by participant, condition and distance."""
    judged = _judged(rows)
    counts = _counts(judged, ["participant", *conditions_of(judged, factors), *_distance(judged)])
    return counts if counts.empty else counts.assign(task=TASK, **{RATE: counts["n_correct"] / counts["n_trials"]})


def resolutions(rows: pd.DataFrame, factors: Sequence[str]) -> pd.DataFrame:
    """Return the resolution (m) by participant and condition.

    It is the threshold of a forced choice as a function of distance.
    """
    judged = _judged(rows)
    if not _distance(judged) or judged[DISTANCE].nunique() < 2:
        return pd.DataFrame()
    conditions = conditions_of(judged, factors)
    # constant stimuli, as the distance does not depend on the answers
    answers = judged.assign(task=TASK, procedure="constant_stimuli", is_catch=False, n_choices=0)
    answers = answers.assign(x=judged[DISTANCE], yes=judged["is_right"].astype(int))
    for _, there in split(answers, conditions):
        answers.loc[there.index, "n_choices"] = n_alternatives(there)
    tables = [_resolutions_among(among, int(m), conditions) for (m,), among in split(answers, ["n_choices"])]
    return pd.concat(tables, ignore_index=True)


def conditions_of_fits(each: pd.DataFrame) -> list[str]:
    """Return the columns of conditions in a table of `resolutions`."""
    return list(each.columns[1 : each.columns.get_loc("resolution_m")])


def _resolutions_among(answers: pd.DataFrame, m: int, conditions: Sequence[str]) -> pd.DataFrame:
    """Return the resolutions for m alternatives, with goodness of fit."""
    options: dict[str, Any] = {"shape": SHAPE, "guess_rate": 1 / m, "scale_free_width": True}
    cells = counted_cells(answers, conditions)
    fits = fit_many(*stacked_counts(cells), **options)
    result = pd.DataFrame([_row(cell, fit, conditions) for cell, fit in zip(cells, fits, strict=True)])
    estimates = list(map(Estimate, cells, fits))
    rng = np.random.default_rng(SEED)
    return result.join(goodness_columns(answers, conditions, estimates, {(TASK, m): options}, rng))


def _row(cell: Cell, fit: ThresholdFit, conditions: Sequence[str]) -> dict[str, object]:
    return {
        "participant": cell.participant,
        **dict(zip(conditions, cell.condition, strict=True)),
        "resolution_m": fit.threshold,
        "resolution_m_low": fit.interval_low,
        "resolution_m_high": fit.interval_high,
        "guess_rate": 1 / cell.n_choices,
        "lapse_rate": fit.lapse_rate,
        "status": fit.status.value,
        "note": fit.note,
        "n_trials": fit.n_trials,
        "deviance": fit.deviance,
    }


def mean_resolutions(rows: pd.DataFrame, factors: Sequence[str]) -> pd.DataFrame:
    """Return the mean resolution (m) and its interval by condition.

    With a single participant, the interval is that of the fit.
    """
    each = resolutions(rows, factors)
    keys = [name for name in (*factors, "level") if name in each.columns]
    return by_condition(each, keys, _mean)


def _mean(each: pd.DataFrame) -> Mapping[str, Any]:
    known = each[each["resolution_m"].notna()]
    row = mean_row(known["resolution_m"].to_numpy(float), possible=POSITIVE) if len(known) else dict.fromkeys(MEAN)
    if len(known) == 1:
        row |= {f"mean_{end}": known[f"resolution_m_{end}"].iloc[0] for end in ("low", "high")}
    return row | {"n": len(known), "n_missing": len(each) - len(known)}


def confusions(rows: pd.DataFrame, factors: Sequence[str]) -> pd.DataFrame:
    """Return shares of answers by condition, correct and chosen place."""
    judged = _judged(rows)
    if judged.empty:
        return pd.DataFrame()
    names = {n: f"{n}" for n in range(1, n_alternatives(judged) + 1)}
    if (factor := place_factor(judged, factors)) is not None:
        names |= {int(n): str(level) for n, level in zip(judged["target"], judged[factor], strict=True)}
    keys = [*conditions_of(judged, factors), *_distance(judged)]
    answers = judged.assign(target=judged["target"].astype(int), answer=numbers_of(judged["response"]).astype(int))
    counts = answers.groupby([*keys, "target", "answer"], observed=True).size().rename("n").reset_index()
    total = counts.groupby([*keys, "target"], observed=True)["n"].transform("sum")
    places = {"right_place": counts["target"].map(names), "answered_place": counts["answer"].map(names)}
    counts = counts.assign(**places, share_of_answers=counts["n"] / total)
    return counts[[*keys, *places, "n", "share_of_answers"]]


def errors(rows: pd.DataFrame, factors: Sequence[str]) -> pd.DataFrame:
    """Return shares of answers by condition, distance and error (m)."""
    judged = _judged(rows)
    if not _distance(judged):
        return pd.DataFrame()
    keys = [*conditions_of(judged, factors), DISTANCE]
    counts = judged.groupby([*keys, ERROR], observed=True).size().rename("n").reset_index()
    return counts.assign(share_of_answers=counts["n"] / counts.groupby(keys, observed=True)["n"].transform("sum"))


def _judged(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the rows with a correct place and an answer."""
    if "target" not in rows.columns:
        return rows.iloc[:0].assign(target=np.nan, is_right=np.nan)
    rows = rows.assign(is_right=correctness(rows))
    return rows[rows["is_right"].notna() & rows["target"].notna()]


def _distance(judged: pd.DataFrame) -> list[str]:
    """Return the column of the distance between places, if all rows have one."""
    has_distances = DISTANCE in judged.columns and len(judged) > 0 and bool(judged[DISTANCE].notna().all())
    return [DISTANCE] if has_distances else []


def _counts(judged: pd.DataFrame, keys: Sequence[str]) -> pd.DataFrame:
    return by_condition(judged, keys, lambda rows: {"n_correct": int(rows["is_right"].sum()), "n_trials": len(rows)})


ANALYSIS = TaskAnalysis(
    "Participants reported which of the alternatives was presented",
    'lme4::glmer(correct ~ {plus} + (1 | participant), {data}, binomial("probit"))',
    results=Results(
        {
            TASK: right_answers,
            RATES: rates_of_participants,
            RESOLUTION: mean_resolutions,
            OF_PARTICIPANTS: resolutions,
            CONFUSIONS: confusions,
            ERRORS: errors,
        },
        "Correct localisations were counted by the distance between the nearest two places. The resolution is the "
        "distance at which a Weibull function is halfway between the guess rate (one over the number of alternatives) "
        "and the upper asymptote (without lapses 75 % for two alternatives). The distance of the upper asymptote from "
        "1 is free, for lapses and for foci that are not felt (prior Beta(1, 10)). Estimates are posterior modes with "
        "central 95 % intervals of the marginal posterior. Intervals of mean resolutions are symmetric on the "
        "logarithm. Rates of participants were compared between distances and conditions without transformation: near "
        "0 and 1 they vary less than the analysis of variance assumes.",
        dependent=RATE,
        in_levels=False,
        compared=RATES,
        further=("level", DISTANCE),
    ),
)
