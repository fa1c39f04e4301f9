"""What an interaction consists of: the effect of one factor at each value of another."""

from collections.abc import Callable, Sequence
from itertools import permutations

import pandas as pd

from .design import UndefinedStatistic
from .post_hoc import adjusted_p

Analysis = Callable[[pd.DataFrame, Sequence[str]], pd.DataFrame]
"""From a table and its factors within participants to effects, in the columns of `repeated_measures`."""
ALPHA = 0.05
KEPT = ("F", "ddof1", "ddof2", "eps_CM", "p_CM_corr", "np2", "np2_low", "np2_high", "ng2")


def simple_effects(
    analysis: Analysis, table: pd.DataFrame, factors: Sequence[str], factor: str, by: str
) -> pd.DataFrame:
    """The effect of `factor` at each value of `by`, averaged over the other `factors`: each an analysis of the values
    there alone, so that no error is shared (Keppel and Wickens 2004, Design and Analysis, chapter 18). `p_corr` is
    Holm's over the values of `by`; where there is no answer `note` says why.

    >>> from tactometry.analysis.anova.within_subjects import repeated_measures
    >>> values = [3.0, 4, 5, 9, 2, 5, 4, 9, 4, 4, 6, 9, 1, 3, 2, 8]
    >>> keys = [(who, force, hz) for who in "abcd" for force in (1, 2) for hz in (60, 240)]
    >>> table = pd.DataFrame(keys, columns=["who", "force_n", "hz"]).assign(y=values)
    >>> def analysis(part, within):
    ...     return repeated_measures(part, dependent="y", within=within, subject="who")
    >>> simple_effects(analysis, table, ["force_n", "hz"], "hz", "force_n")[["force_n", "F"]].round(1).values.tolist()
    [[1.0, 5.4], [2.0, 48.6]]
    """
    rows = [_row(analysis, there, factors, factor, by) | {by: value} for value, there in table.groupby(by, sort=True)]
    effects = pd.DataFrame(rows, columns=[by, "Source", *KEPT, "note"])
    return effects.assign(p_corr=adjusted_p(effects["p_CM_corr"], "holm"))


def _row(analysis: Analysis, there: pd.DataFrame, factors: Sequence[str], factor: str, by: str) -> dict[str, object]:
    try:
        effects = analysis(there, [name for name in factors if name != by])
    except UndefinedStatistic as refusal:
        return {"Source": factor, "note": str(refusal)}
    effect = effects[effects["Source"] == factor].iloc[0]
    return {"Source": factor, "note": ""} | {name: effect[name] for name in KEPT}


def interaction_orders(effects: pd.DataFrame, factors: Sequence[str]) -> list[tuple[str, str]]:
    """The pairs of factors whose interaction is told at 5 %, each in both orders.

    >>> effects = pd.DataFrame({"Source": ["a", "b", "a * b"], "p_CM_corr": [0.5, 0.2, 0.01]})
    >>> interaction_orders(effects, ["a", "b"])
    [('a', 'b'), ('b', 'a')]
    """
    significant = set(effects.loc[effects["p_CM_corr"] < ALPHA, "Source"])
    # An interaction is named once, in the order of the factors; which order the pair has does not matter.
    return [pair for pair in permutations(factors, 2) if {" * ".join(pair), " * ".join(pair[::-1])} & significant]
