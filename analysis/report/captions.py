"""What a table or a figure of means says of its numbers: what is there, no more."""

import pandas as pd

from ..anova.group_means import MODEL, is_of_fit

BETWEEN = "95 % interval between participants"

ONE = "values of one participant"
NONE = "no mean is known"


def _has(means: pd.DataFrame, name: str) -> bool:
    return name in means.columns and bool(means[name].notna().any())


def means_text(means: pd.DataFrame) -> str:
    """What the cells of a table of means are.

    >>> means_text(pd.DataFrame({"mean": [1.0], "mean_low": [0.5]})), means_text(pd.DataFrame({"mean": [1.0]}))
    ('mean, 95 % interval between participants', 'mean, no interval')
    """
    if not _has(means, "mean"):
        return NONE
    if is_of_fit(means):
        return "value, 95 % interval of its fit"
    return f"mean, {BETWEEN if _has(means, 'mean_low') else 'no interval'}"


def means_sentence(means: pd.DataFrame) -> str:
    """The same as a sentence.

    >>> means_sentence(pd.DataFrame({"mean": [1.0], "n": [1]}))
    'Values of one participant; there is no interval between participants.'
    """
    if is_of_fit(means):
        return f"{ONE.capitalize()}, each with the 95 % interval of its fit."
    if _has(means, "mean_low"):
        model = "; where a value is a bound, of the censored model" if is_modelled(means) else ""
        return f"Mean over participants with {BETWEEN}{model}."
    if means_of(means) == NONE:
        return "No mean is known; the cells say of how many participants there are bounds."
    if means_of(means) == ONE:
        return f"{ONE.capitalize()}; there is no interval between participants."
    return "Mean over participants; there is no interval between participants."


def is_modelled(means: pd.DataFrame) -> bool:
    """Whether some mean is that of the censored model."""
    return "method" in means.columns and bool((means["method"] == MODEL).any())


def figure_text(means: pd.DataFrame, dots: str = "") -> str:
    """What a figure of means shows; `dots` is said of more participants than one.

    >>> figure_text(pd.DataFrame({"mean": [1.0], "mean_low": [0.5], "n": [2]}), "dots are participants")
    'means over participants; bars are 95 % t-intervals between participants; dots are participants'
    >>> figure_text(pd.DataFrame({"mean": [1.0], "n": [1]}), "dots are participants")
    'values of one participant'
    """
    if means_of(means) == ONE:
        return ONE + "; bars are 95 % intervals of the fits" * is_of_fit(means)
    return f"{means_of(means)}{bars_text(means)}{'; ' if dots else ''}{dots}"


def means_of(means: pd.DataFrame) -> str:
    """
    >>> means = pd.DataFrame({"mean": [1.0, 2.0], "n": [1, 2]})
    >>> means_of(means), means_of(means[:1]), means_of(means.assign(mean=None))
    ('means over participants', 'values of one participant', 'no mean is known')
    """
    if not _has(means, "mean"):
        return NONE
    return ONE if means["n"].max() == 1 else "means over participants"


def bars_text(means: pd.DataFrame) -> str:
    """What the bars of a figure of means are.

    >>> bars_text(pd.DataFrame({"mean": [1.0], "mean_low": [0.5]})), bars_text(pd.DataFrame({"mean": [1.0]}))
    ('; bars are 95 % t-intervals between participants', '')
    """
    within, between = (_has(means, name) for name in ("within_low", "mean_low"))
    kinds = ["bars are 95 % intervals within participants (Cousineau-Morey)"] * within
    kinds += [f"{'thin lines' if within else 'bars'} are 95 % t-intervals between participants"] * between
    text = "; ".join(["", *kinds])
    return text + (", of the censored model where a value is a bound" if is_modelled(means) and kinds else "")
