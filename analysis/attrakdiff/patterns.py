"""Comparisons of the thesis's patterns (figures 5.9 to 5.13).

Patterns are compared by repetition frequency and envelope, and each with the single focus.

P0 has neither repetition frequency nor envelope, so the factorial analysis omits it.
"""

from collections.abc import Callable, Iterable, Mapping

import pandas as pd

from tactometry.arguments.require import expect
from tactometry.errors import InvalidParameter

from ..anova.design import UndefinedStatistic
from ..anova.post_hoc import pairs
from ..anova.within_subjects import repeated_measures
from ..reading.rows import no_column
from .scoring import dimensions_of

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
