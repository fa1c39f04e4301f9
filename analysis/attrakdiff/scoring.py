"""AttrakDiff and other semantic differentials: scores, consistency, word pairs, portfolio.

A participant is the unit: answers to the items of one participant are never counted as independent (science 9.1).
"""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from tactometry.errors import InvalidParameter, nearest
from tactometry.questionnaire import Questionnaire, load, shipped
from tactometry.trials.columns import RESERVED, stated_factors

from ..anova.group_means import MEANS, group_table
from ..arrays import Array
from ..means import mean_with_interval
from ..reading.refusals import no_column

NAME = "attrakdiff"
HERE = (*RESERVED, "row", "source")
REGIONS = (
    ("superfluous", "self-oriented", "too self-oriented"),
    ("task-oriented", "neutral", "self-oriented"),
    ("too task-oriented", "task-oriented", "desired"),
)
"""Of the portfolio: pragmatic quality grows from row to row, hedonic quality within a row; split at -1 and +1."""


def scores(
    table: pd.DataFrame, *, questionnaire: str | Questionnaire = "", within: Sequence[str] | None = None
) -> pd.DataFrame:
    """Scores of each participant in each condition.

    Parameters
    ----------
    table : DataFrame
        A row per answer: `participant`, `item` and `response`, the raw value as presented (empty: left unanswered).
        Several answers to one item in one condition are averaged.
    questionnaire : str or Questionnaire
        By default the one that the column `procedure` names, or AttrakDiff.
    within : sequence of str
        The columns of conditions; by default those between `trial` and `procedure`, or all that are no column of a
        trials table.

    Returns
    -------
    DataFrame
        `participant`, the conditions, a column per dimension (AttrakDiff: PQ, HQI, HQS, ATT, HQ; from -3 to +3, + is
        good; missing if too few of its items are answered) and `n_answered`. `attrs["questionnaire"]` is it,
        `attrs["within"]` the conditions.

    Raises
    ------
    InvalidParameter
        For a column that is not there, an item of another questionnaire, or an answer beside the scale (with its row).

    >>> items = [item.id for item in load("attrakdiff").items]
    >>> table = pd.DataFrame({"participant": "P01", "pattern": "P0", "item": items, "response": 7})
    >>> scores(table)[["PQ", "HQI", "HQS", "ATT", "HQ"]].round(4).values.tolist()
    [[-0.4286, 0.4286, -0.4286, -0.4286, 0.0]]
    """
    answers, form, factors = _answers(table, questionnaire, within)
    keys = ["participant", *factors]
    rows = [dict(zip(keys, key, strict=True)) | _scored(part, form) for key, part in _rounds(answers, keys)]
    found = pd.DataFrame(rows)
    found.attrs |= {"questionnaire": form, "within": factors}
    return found


def item_scores(
    table: pd.DataFrame, *, questionnaire: str | Questionnaire = "", within: Sequence[str] | None = None
) -> pd.DataFrame:
    """The score of each answer, a row each, with its `dimension`; unanswered items are left out."""
    answers, form, factors = _answers(table, questionnaire, within)
    given = answers.dropna(subset="raw")
    scored = [form.score(item, raw) for item, raw in zip(given["item"], given["raw"], strict=True)]
    dimensions = [form.item(item).dimension for item in given["item"]]
    found = given[["participant", *factors, "item"]].assign(score=scored, dimension=dimensions)
    keys = ["participant", *factors, "dimension", "item"]
    found = found.groupby(keys, observed=True)["score"].mean().reset_index()
    found.attrs |= {"questionnaire": form, "within": factors}
    return found


def _answers(
    table: pd.DataFrame, questionnaire: str | Questionnaire, within: Sequence[str] | None
) -> tuple[pd.DataFrame, Questionnaire, list[str]]:
    for name in ("participant", "item", "response", *(within or ())):
        if name not in table.columns:
            raise InvalidParameter(f"scores: {no_column(name, table)}")
    if table.empty:
        raise InvalidParameter("scores: found no row, expected answers to a questionnaire")
    form = _form(table, questionnaire)
    factors = list(_conditions(list(map(str, table.columns))) if within is None else within)
    raw = _raw(table.reset_index(drop=True), form)
    return table.reset_index(drop=True).assign(raw=raw), form, factors


def _form(table: pd.DataFrame, questionnaire: str | Questionnaire) -> Questionnaire:
    if isinstance(questionnaire, Questionnaire):
        return questionnaire
    if questionnaire:
        return load(questionnaire)
    named = sorted(set(table["procedure"]) & set(shipped())) if "procedure" in table.columns else []
    if len(named) > 1:
        raise InvalidParameter(f"procedure: found {', '.join(named)}, expected one questionnaire; score them apart")
    return load(named[0] if named else NAME)


def _conditions(names: Sequence[str]) -> list[str]:
    if "trial" in names and "procedure" in names:
        return stated_factors(names)
    return [name for name in names if name not in HERE]


def _raw(table: pd.DataFrame, form: Questionnaire) -> "pd.Series[float]":
    known = {item.id for item in form.items}
    text = table["response"].astype(object).where(table["response"].notna(), "")
    raw = pd.to_numeric(text.where(text != "", np.nan), errors="coerce")
    beside = raw.notna() & ~raw.map(form.takes)
    for place in np.flatnonzero(~table["item"].isin(known) | (raw.isna() & (text != "")) | beside):
        item, row = table["item"][place], table["row"][place] if "row" in table.columns else place
        if item not in known:
            raise InvalidParameter(
                f"item, row {row}: found {item!r}, no item of {form.name}{nearest(str(item), known)}"
            )
        raise InvalidParameter(
            f"response, row {row}: found {text[place]!r} for {item}, expected {form.low:g} to {form.high:g} or nothing"
        )
    return raw


Round = dict[str, float | None]


def _rounds(answers: pd.DataFrame, keys: Sequence[str]) -> list[tuple[tuple[object, ...], list[Round]]]:
    """Per participant and condition, sorted, the rounds of answers by item: mostly one."""
    found: dict[tuple[object, ...], list[Round]] = {}
    columns = [answers[name].tolist() for name in keys]
    raw = [None if np.isnan(x) else x for x in answers["raw"].tolist()]
    for key, item, value in zip(zip(*columns, strict=True), answers["item"].tolist(), raw, strict=True):
        rounds = found.setdefault(key, [])
        free = next((each for each in rounds if item not in each), None)
        if free is None:
            rounds.append(free := {})
        free[item] = value
    return sorted(found.items(), key=lambda pair: pair[0])


def _scored(rounds: Sequence[Round], form: Questionnaire) -> dict[str, float | None]:
    """Scores of one participant in one condition: means over the rounds."""
    means = pd.DataFrame([form.scores(each) for each in rounds], dtype=np.float64).mean()
    named: dict[str, float | None] = {str(name): None if np.isnan(x) else float(x) for name, x in means.items()}
    return named | {"n_answered": float(sum(value is not None for each in rounds for value in each.values()))}


def summary(scored: pd.DataFrame, interval: float = 0.95) -> pd.DataFrame:
    """Per condition and dimension: mean over participants with its t-interval between them and (where no score is
    missing) its interval within them, SD, n and how many scores are missing.

    `scored` is what `scores` gives.
    """
    factors = list(scored.attrs["within"])
    parts = [
        group_table(scored, factors, name, interval).assign(dimension=name) for name in sorted(dimensions_of(scored))
    ]
    columns = [*factors, "dimension", *MEANS, "n", "n_missing"]
    found = pd.concat(parts, ignore_index=True)[columns]
    return found.sort_values(factors, kind="stable").reset_index(drop=True) if factors else found


def dimensions_of(scored: pd.DataFrame) -> list[str]:
    """The dimensions of the questionnaire whose scores these are."""
    return list(scored.attrs["questionnaire"].dimensions)


def _mean(values: "pd.Series[float]", interval: float) -> dict[str, object]:
    known = np.array(values.dropna(), dtype=np.float64)
    row: dict[str, object] = dict.fromkeys(("mean", "mean_low", "mean_high", "sd"))
    if len(known):
        row |= mean_with_interval(known, interval)
    return row | {"n": len(known), "n_missing": len(values) - len(known)}


def word_pairs(scored_items: pd.DataFrame, language: str = "en", interval: float = 0.95) -> pd.DataFrame:
    """The profile: per condition and item its mean over participants with t-interval, between its negative and its
    positive word, in the order of the dimensions. `scored_items` is what `item_scores` gives."""
    form, factors = scored_items.attrs["questionnaire"], list(scored_items.attrs["within"])
    simple = [name for name, dimension in form.dimensions.items() if not dimension.parts]
    order = {item: place for place, item in enumerate(i for name in simple for i in form.items_of(name))}
    rows = []
    for key, part in scored_items.groupby([*factors, "item"], sort=True, observed=True):
        names = dict(zip([*factors, "item"], key, strict=True))
        item = form.item(str(names["item"]))
        poles = dict(zip(("negative", "positive"), item.poles.get(language, ("", "")), strict=True))
        rows.append(names | {"dimension": item.dimension} | poles | _mean(part["score"], interval))
    found = pd.DataFrame(rows).sort_values("item", key=lambda ids: ids.map(order), kind="stable")
    return found.sort_values(factors, kind="stable").reset_index(drop=True) if factors else found


def portfolio(scored: pd.DataFrame, interval: float = 0.95) -> pd.DataFrame:
    """Per condition the means of PQ and HQ over participants with t-intervals (the confidence rectangle), and the
    `region` of the portfolio in which the mean lies, split at -1 and +1.

    Raises
    ------
    InvalidParameter
        If the questionnaire has no dimensions PQ and HQ.
    """
    if not {"PQ", "HQ"} <= set(dimensions_of(scored)):
        raise InvalidParameter(f"portfolio: found {scored.attrs['questionnaire'].name}, expected dimensions PQ and HQ")
    factors = list(scored.attrs["within"])
    grouped = [((), scored)] if not factors else scored.groupby(factors, sort=True, observed=True)
    rows = []
    for key, part in grouped:
        row = dict(zip(factors, key, strict=True))
        for name in ("PQ", "HQ"):
            row |= {f"{name}{end.removeprefix('mean')}": v for end, v in _mean(part[name], interval).items()}
        rows.append(row | {"region": region(row["PQ"], row["HQ"])})
    return pd.DataFrame(rows)


def region(pq: float | None, hq: float | None) -> str | None:
    """Where in the portfolio a point lies.

    >>> region(2.0, 2.0), region(0.0, 0.0), region(2.0, -2.0), region(-2.0, 2.0), region(-2.0, -2.0)
    ('desired', 'neutral', 'too task-oriented', 'too self-oriented', 'superfluous')
    """
    if pq is None or hq is None:
        return None
    along, up = (int(x >= -1) + int(x > 1) for x in (pq, hq))
    return REGIONS[along][up]


def consistency(scored_items: pd.DataFrame, interval: float = 0.95) -> pd.DataFrame:
    """Cronbach's alpha of each dimension in each condition, with its interval (Feldt 1965), over participants who
    answered all its items.

    alpha = k / (k - 1) (1 - sum of the items' variances / variance of their sum). Missing (`alpha` empty, with a
    `note`) with fewer than three such participants or without variance between them.
    """
    form, factors = scored_items.attrs["questionnaire"], list(scored_items.attrs["within"])
    grouped = [((), scored_items)] if not factors else scored_items.groupby(factors, sort=True, observed=True)
    rows = []
    for key, part in grouped:
        wide = part.pivot(index="participant", columns="item", values="score")
        for name in form.dimensions:
            items = [item for item in form.items_of(name) if item in wide.columns]
            rows.append(dict(zip(factors, key, strict=True)) | {"dimension": name} | _alpha(wide[items], interval))
    return pd.DataFrame(rows)


def _alpha(wide: pd.DataFrame, interval: float) -> dict[str, object]:
    values = wide.dropna().to_numpy(dtype=np.float64)
    row: dict[str, object] = {
        "alpha": None,
        "alpha_low": None,
        "alpha_high": None,
        "n_items": wide.shape[1],
        "n": len(values),
        "note": "",
    }
    if wide.shape[1] < 2 or len(values) < 3:
        return row | {"note": "fewer than two items or three participants who answered them all"}
    if values.sum(axis=1).var() <= 1e-12:
        return row | {"note": "participants do not differ in this score"}
    alpha = cronbach_alpha(values)
    return (
        row
        | {"alpha": alpha}
        | dict(zip(("alpha_low", "alpha_high"), _feldt(alpha, *values.shape, interval), strict=True))
    )


def cronbach_alpha(values: Array) -> float:
    """Of values of shape (participant, item).

    >>> round(cronbach_alpha(np.array([[1.0, 2, 1], [2, 2, 3], [3, 4, 3], [4, 4, 5]])), 4)
    0.9333
    """
    k = values.shape[1]
    return float(k / (k - 1) * (1 - values.var(axis=0, ddof=1).sum() / values.sum(axis=1).var(ddof=1)))


def _feldt(alpha: float, n: int, k: int, interval: float) -> tuple[float, float]:
    from scipy.stats import f as fisher

    df = (n - 1, (n - 1) * (k - 1))
    low, high = (fisher.ppf(chance, *df) for chance in ((1 + interval) / 2, (1 - interval) / 2))
    return 1 - (1 - alpha) * float(low), 1 - (1 - alpha) * float(high)
