"""What the thesis asks of its patterns (figures 5.9 to 5.13): frequency by envelope, and each against the single focus.

P0 has neither repetition frequency nor envelope: a crossed analysis leaves it out, and it is the reference of another.
"""

from collections.abc import Iterable, Mapping

import pandas as pd

from tactometry.errors import InvalidParameter

from ..anova.design import UndefinedStatistic
from ..anova.post_hoc import pairs
from ..anova.within_subjects import repeated_measures
from ..reading.refusals import no_column
from .scoring import dimensions_of

THESIS: Mapping[str, tuple[str, str]] = {
    "P1": ("low", "rectangular"),
    "P2": ("low", "exponential"),
    "P3": ("low", "sinc"),
    "P4": ("high", "rectangular"),
    "P5": ("high", "exponential"),
    "P6": ("high", "sinc"),
}
"""Repetition frequency and envelope of each pattern; an unverified inference from the names of figures."""


def grouped_profile(
    profile: pd.DataFrame, *, design: Mapping[str, tuple[str, str]] = THESIS, reference: str = "P0"
) -> pd.DataFrame:
    """Mean of each word pair over the patterns of one repetition frequency, and of one envelope, beside the reference's
    own: rows as in `word_pairs`, `of` is ``frequency`` or ``envelope``.

    `profile` has the columns `condition, item, dimension, negative, positive, mean`.
    """
    words = ["item", "dimension", "negative", "positive"]
    found = []
    for place, of in enumerate(("frequency", "envelope")):
        names = {code: parts[place] for code, parts in design.items()} | {reference: reference}
        kept = profile[profile["condition"].isin(names)]
        kept = kept.assign(condition=kept["condition"].map(names))
        means = kept.groupby([*words, "condition"], sort=False)["mean"].mean().reset_index()
        found.append(means.assign(of=of))
    return pd.concat(found, ignore_index=True)


def frequency_by_envelope(
    scored: pd.DataFrame, *, design: Mapping[str, tuple[object, object]] = THESIS, pattern: str = "pattern"
) -> pd.DataFrame:
    """Repeated-measures analysis of variance, frequency by envelope, of each dimension; patterns outside of `design`
    (the single focus) are left out.

    `scored` is what `attrakdiff.scores` gives. Participants without a score in one of the patterns are left out of that
    dimension; `left_out` names them. A dimension that has no answer has a row with the reason in `note`.

    Raises
    ------
    InvalidParameter
        If a pattern of the design is not in the table.
    """
    _expect(scored, pattern, design)
    kept = scored[scored[pattern].isin(design)]
    for place, name in enumerate(("frequency", "envelope")):
        kept = kept.assign(**{name: kept[pattern].map({code: parts[place] for code, parts in design.items()})})
    parts = [_crossed(kept, dimension, pattern) for dimension in dimensions_of(scored)]
    return pd.concat(parts, ignore_index=True)


def _crossed(kept: pd.DataFrame, dimension: str, pattern: str) -> pd.DataFrame:
    whole, left_out = complete_participants(kept, dimension, pattern)
    try:
        found = repeated_measures(whole, dependent=dimension, within=["frequency", "envelope"], subject="participant")
        found["note"] = "; ".join(found.attrs["notes"])
    except UndefinedStatistic as refusal:
        found = pd.DataFrame([{"Source": "frequency * envelope", "note": str(refusal)}])
    found.insert(0, "dimension", dimension)
    return found.assign(left_out=", ".join(left_out))


def complete_participants(table: pd.DataFrame, dependent: str, condition: str) -> tuple[pd.DataFrame, list[str]]:
    """The rows of participants with a value in every condition, and the names of the others (listwise deletion)."""
    known = table[table[dependent].notna()]
    n_conditions = known.groupby("participant")[condition].nunique()
    whole = n_conditions.index[n_conditions == table[condition].nunique()]
    left_out = sorted(set(table["participant"]) - set(whole))
    return known[known["participant"].isin(whole)], [str(code) for code in left_out]


def against_reference(scored: pd.DataFrame, *, reference: str = "P0", pattern: str = "pattern") -> pd.DataFrame:
    """Paired t-tests of every pattern against the reference, Holm-corrected within each dimension; columns as those of
    `pairs`, and `dimension`, `left_out` and `note` as in `frequency_by_envelope`.

    Raises
    ------
    InvalidParameter
        If the reference is not in the table.
    """
    _expect(scored, pattern, [reference])
    parts = [_against(scored, dimension, reference, pattern) for dimension in dimensions_of(scored)]
    return pd.concat(parts, ignore_index=True)


def _against(scored: pd.DataFrame, dimension: str, reference: str, pattern: str) -> pd.DataFrame:
    whole, left_out = complete_participants(scored, dimension, pattern)
    try:
        found = pairs(whole, dependent=dimension, factor=pattern, subject="participant", reference=reference)
        found["note"] = ""
    except UndefinedStatistic as refusal:
        found = pd.DataFrame([{"a": reference, "note": str(refusal)}])
    found.insert(0, "dimension", dimension)
    return found.assign(left_out=", ".join(left_out))


def _expect(scored: pd.DataFrame, pattern: str, wanted: Iterable[str]) -> None:
    if pattern not in scored.columns:
        raise InvalidParameter(f"pattern: {no_column(pattern, scored)}")
    there = sorted(set(scored[pattern]))
    for name in wanted:
        if name not in there:
            raise InvalidParameter(f"{pattern}: found no {name} among {', '.join(map(str, there))}, expected it")
