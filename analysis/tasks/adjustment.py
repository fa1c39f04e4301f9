"""Method of adjustment: mean and SD of settings (Gescheider 1997)."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from ..means import by_condition, mean_row
from ..reading.rows import numbers_of
from .task_analysis import Results, TaskAnalysis

TASK = "adjustment"
DEPENDENT = "setting"


def adjustment_table(rows: pd.DataFrame, factors: Sequence[str]) -> pd.DataFrame:
    """Return mean `setting`, t-interval and SD by participant and condition."""
    return by_condition(rows, ["participant", *factors], _row)


def _row(rows: pd.DataFrame) -> dict[str, object]:
    settings = np.asarray(numbers_of(rows["response"]), dtype=np.float64)
    return {"task": TASK, **mean_row(settings, name=DEPENDENT), "n_settings": len(settings)}


ANALYSIS = TaskAnalysis(
    "Participants set the level",
    "lme4::lmer(as.numeric(response) ~ {plus} + (1 | participant), {data})",
    results=Results(
        {TASK: adjustment_table},
        "Settings by the method of adjustment were averaged for each participant and condition (Gescheider 1997).",
        works=("Gescheider, G. A. (1997). Psychophysics: The fundamentals (3rd ed.). Erlbaum.",),
        dependent=DEPENDENT,
    ),
)
