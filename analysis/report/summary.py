"""The result as plain values for JSON."""

from collections.abc import Iterator

from ..result import Analysis
from .kinds import KINDS

ORDER = (
    *("thresholds", "goodness", "outcomes", "hierarchical", "questionnaires", "questionnaire_statistics", "loss"),
    *("force", "same_different", "preference", "adjustment", "magnitude", "excluded"),
)
"""As earlier versions wrote them; what is new comes after them."""


def summary(found: Analysis) -> dict[str, object]:
    """The result as plain values for JSON."""
    of_kinds = {name: value for kind in KINDS for name, value in kind.values(found)}
    return {
        "path": str(found.trials.path),
        "n_trials": len(found.trials.rows),
        "n_participants": int(found.trials.rows["participant"].nunique()),
        "factors": list(found.trials.factors),
        "level_unit": found.unit,
        "simulated": found.origin.is_simulated,
        "seeds": list(found.origin.seeds),
        "warnings": list(found.warnings),
        **{name: of_kinds.pop(name) for name in ORDER},
        **of_kinds,
        **dict(_written(found)),
    }


def _written(found: Analysis) -> Iterator[tuple[str, str | None]]:
    places = {"report": found.report, "tables": found.tables_folder, "figures": found.figures_folder}
    return ((name, None if place is None else str(place)) for name, place in places.items())
