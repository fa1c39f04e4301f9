"""Scores, consistency, word pairs and portfolio of questionnaires."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from tactometry.arguments.require import expect
from tactometry.errors import InvalidParameter, nearest
from tactometry.questionnaire import Questionnaire, load, shipped_names
from tactometry.trials.columns import RESERVED, stated_factors

from ..anova.design import UndefinedStatistic
from ..anova.group_means import MEANS, group_table
from ..anova.post_hoc import pairs
from ..anova.within_subjects import repeated_measures
from ..means import MEAN, Range, by_condition, mean_row, parts
from ..reading.rows import no_column

NAME = "attrakdiff"
HERE = (*RESERVED, "row", "source")
REGIONS = (
    ("superfluous", "self-oriented", "too self-oriented"),
    ("task-oriented", "neutral", "self-oriented"),
    ("too task-oriented", "task-oriented", "desired"),
)
"""Regions of the portfolio by pragmatic quality (row) and hedonic quality (column), with limits at -1 and +1."""


def scores(
    table: pd.DataFrame, *, questionnaire: str | Questionnaire = "", within: Sequence[str] | None = None
) -> pd.DataFrame:
    """Return the scores of each participant in each condition.

    Parameters
    ----------
    table : DataFrame
        One row per answer: `participant`, `item` and `response` (empty if unanswered). Several answers to an item in a
        condition are averaged.
    questionnaire : str or Questionnaire
        By default the questionnaire named in the column `procedure`, or AttrakDiff.
    within : sequence of str
        Columns of conditions. By default the columns between `trial` and `procedure`, or else all other columns.

    Returns
    -------
    DataFrame
        `participant`, the conditions, a column per dimension (AttrakDiff: PQ, HQI, HQS, ATT, HQ; -3 to +3, + is good;
        missing with too few answers) and `n_answered`; `attrs` has `questionnaire` and `within`.

    Raises
    ------
    InvalidParameter
        For a missing column, an item of another questionnaire, or an answer outside of the scale (with its row).

    >>> items = [item.id for item in load("attrakdiff").items]
    >>> table = pd.DataFrame({"participant": "P01", "pattern": "P0", "item": items, "response": 7})
    >>> scores(table)[["PQ", "HQI", "HQS", "ATT", "HQ"]].round(4).values.tolist()
    [[-0.4286, 0.4286, -0.4286, -0.4286, 0.0]]
    """
    answers, form, factors = _answers(table, questionnaire, within)
    keys = ["participant", *factors]
    # The n-th answer to an item in a condition belongs to round n.
    number = answers.groupby([*keys, "item"], observed=True, dropna=False).cumcount()
    answers = answers.assign(round=number, raw=answers["raw"].astype(object).where(answers["raw"].notna(), None))
    # Answers given outside the conditions have no level and are sorted last.
    groups = answers.groupby(keys, sort=True, observed=True, dropna=False)
    rows = [dict(zip(keys, key, strict=True)) | _mean_scores(given, form) for key, given in groups]
    return _with_origin(pd.DataFrame(rows), form, factors)


def item_scores(
    table: pd.DataFrame, *, questionnaire: str | Questionnaire = "", within: Sequence[str] | None = None
) -> pd.DataFrame:
    """Return the score and `dimension` of each answered item."""
    answers, form, factors = _answers(table, questionnaire, within)
    given = answers.dropna(subset="raw")
    scored = [form.score(item, raw) for item, raw in zip(given["item"], given["raw"], strict=True)]
    dimensions = [form.item(item).dimension for item in given["item"]]
    rows = given[["participant", *factors, "item"]].assign(score=scored, dimension=dimensions)
    means = rows.groupby(["participant", *factors, "dimension", "item"], observed=True)["score"].mean()
    return _with_origin(means.reset_index(), form, factors)


def _with_origin(scored: pd.DataFrame, form: Questionnaire, factors: list[str]) -> pd.DataFrame:
    scored.attrs |= {"questionnaire": form, "within": factors}
    return scored


def _answers(
    table: pd.DataFrame, questionnaire: str | Questionnaire, within: Sequence[str] | None
) -> tuple[pd.DataFrame, Questionnaire, list[str]]:
    for name in ("participant", "item", "response", *(within or ())):
        if name not in table.columns:
            raise InvalidParameter(f"scores: {no_column(name, table)}")
    expect(len(table) > 0, "scores", "no row", "answers to a questionnaire")
    form = _form(table, questionnaire)
    factors = list(_conditions(list(map(str, table.columns))) if within is None else within)
    raw = _raw_values(table.reset_index(drop=True), form)
    return table.reset_index(drop=True).assign(raw=raw), form, factors


def _form(table: pd.DataFrame, questionnaire: str | Questionnaire) -> Questionnaire:
    if isinstance(questionnaire, Questionnaire):
        return questionnaire
    if questionnaire:
        return load(questionnaire)
    named = sorted(set(table["procedure"]) & set(shipped_names())) if "procedure" in table.columns else []
    expect(len(named) <= 1, "procedure", ", ".join(named), "one questionnaire; score each separately")
    return load(named[0] if named else NAME)


def _conditions(names: Sequence[str]) -> list[str]:
    if "trial" in names and "procedure" in names:
        return stated_factors(names)
    return [name for name in names if name not in HERE]


def _raw_values(table: pd.DataFrame, form: Questionnaire) -> "pd.Series[float]":
    known = {item.id for item in form.items}
    text = table["response"].astype(object).where(table["response"].notna(), "")
    raw = pd.to_numeric(text.where(text != "", np.nan), errors="coerce")
    is_off_scale = raw.notna() & ~raw.map(form.takes)
    is_word = raw.isna() & (text != "")
    # the error names the first one
    for place in np.flatnonzero(~table["item"].isin(known) | is_word | is_off_scale):
        item = table["item"][place]
        row = table["row"][place] if "row" in table.columns else place
        if item not in known:
            unknown = f"found {item!r}, no item of {form.name}{nearest(str(item), known)}"
            raise InvalidParameter(f"item, row {row}: {unknown}")
        expected = f"{form.low:g} to {form.high:g} or nothing"
        raise InvalidParameter(f"response, row {row}: found {text[place]!r} for {item}, expected {expected}")
    return raw


def _mean_scores(answers: pd.DataFrame, form: Questionnaire) -> dict[str, float | None]:
    """Return the scores averaged over all rounds of answers."""
    rounds: list[dict[str, float | None]] = [{} for _ in range(answers["round"].max() + 1)]
    for number, item, raw in zip(answers["round"], answers["item"], answers["raw"], strict=True):
        rounds[number][item] = raw
    means = pd.DataFrame(map(form.scores, rounds), dtype=np.float64).mean()
    named: dict[str, float | None] = {str(name): None if np.isnan(x) else float(x) for name, x in means.items()}
    return named | {"n_answered": float(answers["raw"].notna().sum())}


def summary(scored: pd.DataFrame, interval: float = 0.95) -> pd.DataFrame:
    """Summarise `scores` by condition and dimension."""
    factors = list(scored.attrs["within"])
    names = sorted(dimensions_of(scored))
    of_dimensions = [
        group_table(scored, factors, name, interval, possible=_possible(scored)).assign(dimension=name)
        for name in names
    ]
    columns = [*factors, "dimension", *MEANS, "n", "n_missing"]
    return _by_factors(pd.concat(of_dimensions, ignore_index=True)[columns], factors)


def _by_factors(table: pd.DataFrame, factors: list[str]) -> pd.DataFrame:
    """Sort rows by condition, keeping their order within each condition."""
    return table.sort_values(factors, kind="stable").reset_index(drop=True) if factors else table


def dimensions_of(scored: pd.DataFrame) -> list[str]:
    return list(scored.attrs["questionnaire"].dimensions)


def _possible(scored: pd.DataFrame) -> Range:
    """Return the possible range of scores and items of a questionnaire."""
    form = scored.attrs["questionnaire"]
    return Range(*sorted((form.score_low, form.score_high)))


def _mean(values: "pd.Series[float]", interval: float, possible: Range) -> dict[str, Any]:
    known = np.array(values.dropna(), dtype=np.float64)
    row = mean_row(known, interval, possible=possible) if len(known) else dict.fromkeys(MEAN)
    return row | {"n": len(known), "n_missing": len(values) - len(known)}


def word_pairs(scored_items: pd.DataFrame, language: str = "en", interval: float = 0.95) -> pd.DataFrame:
    """Return the profile: the mean of each item, with its word pair.

    Each row is one item in one condition: the mean over participants, its t-interval, and the negative and positive
    word. Items are in the order of the dimensions. `scored_items` is the result of `item_scores`.
    """
    form, factors = scored_items.attrs["questionnaire"], list(scored_items.attrs["within"])
    simple = [name for name, dimension in form.dimensions.items() if not dimension.parts]
    order = {item: place for place, item in enumerate(i for name in simple for i in form.items_of(name))}

    def row_of(answers: pd.DataFrame) -> dict[str, object]:
        item = form.item(answers["item"].iloc[0])
        negative, positive = item.poles.get(language, ("", ""))
        words = {"dimension": item.dimension, "negative": negative, "positive": positive}
        return words | _mean(answers["score"], interval, _possible(scored_items))

    profile = by_condition(scored_items, [*factors, "item"], row_of)
    # Two stable sorts: first by the questionnaire's order, then by condition.
    return _by_factors(profile.sort_values("item", key=lambda ids: ids.map(order), kind="stable"), factors)


def portfolio(scored: pd.DataFrame, interval: float = 0.95) -> pd.DataFrame:
    """Return the means of PQ and HQ by condition, and the portfolio `region`.

    Raises `InvalidParameter` if the questionnaire has no dimensions PQ and HQ.
    """
    has_both = {"PQ", "HQ"} <= set(dimensions_of(scored))
    expect(has_both, "portfolio", scored.attrs["questionnaire"].name, "dimensions PQ and HQ")

    def row_of(scores: pd.DataFrame) -> dict[str, Any]:
        means = {name: _mean(scores[name], interval, _possible(scored)) for name in ("PQ", "HQ")}
        ends = {f"{name}{end.removeprefix('mean')}": x for name, mean in means.items() for end, x in mean.items()}
        return ends | {"region": region(means["PQ"]["mean"], means["HQ"]["mean"])}

    return by_condition(scored, scored.attrs["within"], row_of)


def region(pq: float | None, hq: float | None) -> str | None:
    """Return the portfolio region of a pair of means.

    >>> region(2.0, 2.0), region(0.0, 0.0), region(2.0, -2.0), region(-2.0, 2.0), region(-2.0, -2.0)
    ('desired', 'neutral', 'too task-oriented', 'too self-oriented', 'superfluous')
    """
    if pq is None or hq is None:
        return None
    along, up = (int(x >= -1) + int(x > 1) for x in (pq, hq))
    return REGIONS[along][up]


def consistency(scored_items: pd.DataFrame, interval: float = 0.95) -> pd.DataFrame:
    """Return Cronbach's alpha by dimension and condition, with intervals.

    pingouin computes alpha from participants who answered all items. With fewer than three of them or without variance,
    alpha is empty and `note` gives the reason.
    """
    form, factors = scored_items.attrs["questionnaire"], list(scored_items.attrs["within"])
    rows = []
    for key, answers in parts(scored_items, factors):
        wide = answers.pivot(index="participant", columns="item", values="score")
        for name in form.dimensions:
            items = [item for item in form.items_of(name) if item in wide.columns]
            rows.append(dict(zip(factors, key, strict=True)) | {"dimension": name} | _alpha(wide[items], interval))
    return pd.DataFrame(rows)


def _alpha(wide: pd.DataFrame, interval: float) -> dict[str, object]:
    import pingouin  # slow to load

    values = wide.dropna().astype(float)
    alpha, low, high, note = None, None, None, ""
    if wide.shape[1] < 2 or len(values) < 3:
        note = "fewer than two items, or fewer than three participants who answered all items"
    elif values.sum(axis=1).var() <= 1e-12:  # rounding error
        note = "participants do not differ in this score"
    else:
        alpha, (low, high) = pingouin.cronbach_alpha(values, ci=interval)
    ends = {"alpha": alpha, "alpha_low": low, "alpha_high": high}
    return {**ends, "n_items": wide.shape[1], "n": len(values), "note": note}


THESIS: Mapping[str, tuple[str, str]] = {
    "P1": ("low", "rectangular"),
    "P2": ("low", "exponential"),
    "P3": ("low", "sinc"),
    "P4": ("high", "rectangular"),
    "P5": ("high", "exponential"),
    "P6": ("high", "sinc"),
}
"""Repetition frequency and envelope of each pattern (unverified, inferred from figure names)."""

BY = ("frequency", "envelope")


def grouped_profile(
    profile: pd.DataFrame, *, design: Mapping[str, tuple[str, str]] = THESIS, reference: str = "P0"
) -> pd.DataFrame:
    """Return word-pair means by frequency, by envelope and of the reference.

    The columns are those of `word_pairs`, plus `of`: ``frequency`` or ``envelope``.
    """
    words = ["item", "dimension", "negative", "positive"]
    grouped = []
    for place, of in enumerate(BY):
        names = {code: values[place] for code, values in design.items()} | {reference: reference}
        kept = profile[profile["condition"].isin(names)]
        kept = kept.assign(condition=kept["condition"].map(names))
        means = kept.groupby([*words, "condition"], sort=False)["mean"].mean().reset_index()
        grouped.append(means.assign(of=of))
    return pd.concat(grouped, ignore_index=True)


def frequency_by_envelope(
    scored: pd.DataFrame, *, design: Mapping[str, tuple[object, object]] = THESIS, pattern: str = "pattern"
) -> pd.DataFrame:
    """Compute a frequency by envelope ANOVA of each dimension of `scores`.

    Patterns that are not in `design` and participants without a score (`left_out`) are omitted. A dimension without a
    result has one row, with the reason in `note`.

    Raises `InvalidParameter` if a pattern of the design is not in the table.
    """
    _expect(scored, pattern, design)
    kept = scored[scored[pattern].isin(design)]
    for place, name in enumerate(BY):
        value_of = {code: values[place] for code, values in design.items()}
        kept = kept.assign(**{name: kept[pattern].map(value_of)})

    def crossed(whole: pd.DataFrame, dimension: str) -> pd.DataFrame:
        effects = repeated_measures(whole, dependent=dimension, within=list(BY), subject="participant")
        return effects.assign(note="; ".join(effects.attrs["notes"]))

    return _of_dimensions(kept, dimensions_of(scored), pattern, crossed, {"Source": " * ".join(BY)})


def _of_dimensions(
    scored: pd.DataFrame,
    dimensions: Iterable[str],
    pattern: str,
    test: Callable[[pd.DataFrame, str], pd.DataFrame],
    untested: Mapping[str, str],
) -> pd.DataFrame:
    """Test each dimension with the participants who rated every pattern."""
    tables = []
    for dimension in dimensions:
        whole, left_out = complete_participants(scored, dimension, pattern)
        try:
            table = test(whole, dimension)
        except UndefinedStatistic as refusal:  # the other dimensions can still be tested
            table = pd.DataFrame([{**untested, "note": str(refusal)}])
        table.insert(0, "dimension", dimension)
        tables.append(table.assign(left_out=", ".join(left_out)))
    return pd.concat(tables, ignore_index=True)


def complete_participants(table: pd.DataFrame, dependent: str, condition: str) -> tuple[pd.DataFrame, list[str]]:
    """Return participants with all values, and the codes of the others."""
    known = table[table[dependent].notna()]
    n_conditions = known.groupby("participant")[condition].nunique()
    # Conditions without any known value count too.
    whole = n_conditions.index[n_conditions == table[condition].nunique()]
    left_out = sorted(set(table["participant"]) - set(whole))
    return known[known["participant"].isin(whole)], [str(code) for code in left_out]


def against_reference(scored: pd.DataFrame, *, reference: str = "P0", pattern: str = "pattern") -> pd.DataFrame:
    """Compare each pattern with the reference by Holm-corrected t-tests.

    The columns are those of `pairs`, plus `dimension`, `left_out` and `note`.

    Raises `InvalidParameter` if the reference is not in the table.
    """
    _expect(scored, pattern, [reference])

    def against(whole: pd.DataFrame, dimension: str) -> pd.DataFrame:
        compared = pairs(whole, dependent=dimension, factor=pattern, subject="participant", reference=reference)
        return compared.assign(note="")

    return _of_dimensions(scored, dimensions_of(scored), pattern, against, {"a": reference})


def _expect(scored: pd.DataFrame, pattern: str, wanted: Iterable[str]) -> None:
    if pattern not in scored.columns:
        raise InvalidParameter(f"pattern: {no_column(pattern, scored)}")
    there = sorted(set(scored[pattern]))
    for name in wanted:
        expect(name in there, pattern, f"no {name} among {', '.join(map(str, there))}", "it")
