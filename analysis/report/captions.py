"""Captions of tables and figures of means: whose means and intervals they show."""

import pandas as pd

from ..anova.group_means import MODEL, is_of_fit

BETWEEN = "95 % interval between participants"
ONE = "values of one participant"
NONE = "no mean is known"


def _has(means: pd.DataFrame, name: str) -> bool:
    return name in means.columns and bool(means[name].notna().any())


def _is_modelled(means: pd.DataFrame) -> bool:
    return "method" in means.columns and bool((means["method"] == MODEL).any())


def means_of(means: pd.DataFrame) -> str:
    """Describe what the intervals of means are.

    >>> means = pd.DataFrame({"mean": [1.0, 2.0], "n": [1, 2]})
    >>> means_of(means), means_of(means[:1]), means_of(means.assign(mean=None))
    ('means over participants', 'values of one participant', 'no mean is known')
    """
    if not _has(means, "mean"):
        return NONE
    return ONE if means["n"].max() == 1 else "means over participants"


def means_text(means: pd.DataFrame) -> str:
    """Describe the cells of a table of means.

    >>> means_text(pd.DataFrame({"mean": [1.0], "mean_low": [0.5]})), means_text(pd.DataFrame({"mean": [1.0]}))
    ('mean, 95 % interval between participants', 'mean, no interval')
    """
    if not _has(means, "mean"):
        return NONE
    if is_of_fit(means):
        return "value, 95 % interval of its fit"
    return f"mean, {BETWEEN if _has(means, 'mean_low') else 'no interval'}"


def means_sentence(means: pd.DataFrame) -> str:
    """Describe the cells of a table of means in a sentence.

    >>> means_sentence(pd.DataFrame({"mean": [1.0], "n": [1]}))
    'Values of one participant; there is no interval between participants.'
    """
    if is_of_fit(means):
        return f"{ONE.capitalize()}, each with the 95 % interval of its fit."
    if _has(means, "mean_low"):
        model = "; where a value is a bound, of the censored model" if _is_modelled(means) else ""
        return f"Mean over participants with {BETWEEN}{model}."
    if means_of(means) == NONE:
        return "No mean is known; the cells say of how many participants there are bounds."
    whose = ONE.capitalize() if means_of(means) == ONE else "Mean over participants"
    return f"{whose}; there is no interval between participants."


def figure_text(means: pd.DataFrame, dots: str = "") -> str:
    """Describe a figure of means, and its `dots` if there are several participants.

    >>> figure_text(pd.DataFrame({"mean": [1.0], "mean_low": [0.5], "n": [2]}), "dots are participants")
    'means over participants; bars are 95 % t-intervals between participants; dots are participants'
    >>> figure_text(pd.DataFrame({"mean": [1.0], "n": [1]}), "dots are participants")
    'values of one participant'
    """
    if means_of(means) == ONE:
        return ONE + "; bars are 95 % intervals of the fits" * is_of_fit(means)
    parts = [means_of(means)]
    bars = "bars"
    if _has(means, "within_low"):
        parts.append("bars are 95 % intervals within participants (Cousineau-Morey)")
        bars = "thin lines"
    if _has(means, "mean_low"):
        parts.append(f"{bars} are 95 % t-intervals between participants")
    if _is_modelled(means) and len(parts) > 1:
        parts[-1] += ", of the censored model where a value is a bound"
    return "; ".join(filter(None, [*parts, dots]))
