"""Captions and introductions of tables and figures."""

import pandas as pd

from ..anova.group_means import MODEL, is_of_fit
from .texts import environment


def caption(macro: str, *values: object, **named: object) -> str:
    """Return the text of a macro in `captions.j2` as one line."""
    template = environment().get_template("captions.j2").module
    return " ".join(str(getattr(template, macro)(*values, **named)).split())


def facts_of(means: pd.DataFrame) -> dict[str, object]:
    """Return the properties of a table of means that the templates use."""
    return {
        "known": [name for name in means.columns if means[name].notna().any()],
        "is_one": "n" in means.columns and means["n"].max() == 1,
        "is_of_fit": is_of_fit(means),
        "is_modelled": "method" in means.columns and bool((means["method"] == MODEL).any()),
    }


def means_text(form: str, means: pd.DataFrame, *dots: str) -> str:
    """Describe means: ``whose``, ``cells``, ``sentence`` or ``figure``.

    >>> means = pd.DataFrame({"mean": [1.0], "mean_low": [0.5], "n": [2]})
    >>> means_text("whose", means), means_text("cells", means)
    ('means over participants', 'mean, 95 % interval between participants')
    >>> means_text("figure", means, "dots are participants")
    'means over participants; bars are 95 % t-intervals between participants; dots are participants'
    >>> means_text("sentence", pd.DataFrame({"mean": [1.0], "n": [1]}))
    'Values of one participant; there is no interval between participants.'
    """
    return caption(form, facts_of(means), *dots)
