"""What an analysis says of one factor."""

from typing import Final

import pandas as pd

from tactometry.analysis.outcomes.findings import FORCE, Outcome, Primary
from tactometry.analysis.outcomes.outcome import MEASURED

P_COLUMNS: Final = ("p_CM_corr", "p", "p_permutation")
"""What an analysis reports of an effect: the first that its table has."""


def p_of(tested: Outcome, factor: str) -> float | None:
    """What the primary analysis says of a factor; None where it has no answer."""
    effects = tested.effects
    if effects is None:
        return None
    name = MEASURED if tested.primary is Primary.MIXED_MODEL and factor == FORCE else factor
    of_factor = effects[effects.iloc[:, 0] == name]
    column = next((column for column in P_COLUMNS if column in effects.columns), None)
    if of_factor.empty or column is None or pd.isna(of_factor[column].iloc[0]):
        return None
    return float(of_factor[column].iloc[0])
