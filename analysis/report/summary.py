"""Return the result as plain values for JSON."""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from ..reading.quality import tally_of
from ..result import Analysis
from .kinds import KINDS

ORDER = (
    *("thresholds", "goodness", "outcomes", "hierarchical", "questionnaires", "questionnaire_statistics", "loss"),
    *("force", "same_different", "preference", "adjustment", "magnitude", "excluded"),
)
"""Keys in a fixed order; new keys are appended."""


def summary(analysis: Analysis) -> dict[str, object]:
    """Return the result as plain values for JSON."""
    of_kinds = {name: plain(value) for kind in KINDS for name, value in kind.values(analysis)}
    places = {"report": analysis.report, "tables": analysis.tables_folder, "figures": analysis.figures_folder}
    places |= {"pdf": analysis.pdf}
    return {
        "path": str(analysis.trials.path),
        "n_trials": tally_of(analysis.trials).n_trials,
        "n_rows": len(analysis.trials.rows),
        "n_participants": analysis.n_participants,
        "factors": list(analysis.factors),
        "level_unit": analysis.unit,
        "simulated": analysis.origin.is_simulated,
        "seeds": list(analysis.origin.seeds),
        "warnings": list(analysis.warnings),
        **{name: of_kinds[name] for name in ORDER},
        **of_kinds,
        **{name: None if place is None else str(place) for name, place in places.items()},
    }


def plain(value: object) -> object:
    """Convert nested tables to lists of rows, and missing values to None."""
    if isinstance(value, pd.DataFrame):
        return plain(value.to_dict("records"))
    if isinstance(value, Mapping):
        return {str(name): plain(one) for name, one in value.items()}
    if isinstance(value, list):
        return [plain(one) for one in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value
