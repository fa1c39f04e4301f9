"""The result as plain values for JSON."""

import numpy as np
import pandas as pd

from ..outcomes.findings import Outcome
from ..outcomes.hierarchical_outcome import HierarchicalOutcome
from ..result import Analysis
from .sentences import form_sentences, hierarchical_sentences, outcome_sentences, primary_sentences


def summary(found: Analysis) -> dict[str, object]:
    """The result as plain values for JSON."""
    return {
        "path": str(found.trials.path),
        "n_trials": len(found.trials.rows),
        "n_participants": int(found.trials.rows["participant"].nunique()),
        "factors": list(found.trials.factors),
        "level_unit": found.unit,
        "simulated": found.origin.is_simulated,
        "seeds": list(found.origin.seeds),
        "warnings": list(found.warnings),
        "thresholds": plain_rows(found.tables.get("thresholds", pd.DataFrame())),
        "goodness": plain_rows(found.tables.get("goodness", pd.DataFrame())),
        "outcomes": [_plain_outcome(outcome, found.unit) for outcome in found.outcomes],
        "hierarchical": [_plain_together(each, found.unit) for each in found.together],
        "questionnaires": {form.name: plain_rows(form.summary) for form in found.forms},
        "questionnaire_statistics": {form.name: form_sentences(form) for form in found.forms},
        "loss": plain_rows(found.tables.get("loss", pd.DataFrame())),
        "force": plain_rows(found.tables.get("force", pd.DataFrame())),
        "same_different": plain_rows(found.tables.get("same_different", pd.DataFrame())),
        "preference": plain_rows(found.tables.get("preference", pd.DataFrame())),
        "adjustment": plain_rows(found.tables.get("adjustment", pd.DataFrame())),
        "magnitude": plain_rows(found.tables.get("magnitude", pd.DataFrame())),
        "excluded": plain_rows(found.tables.get("excluded", pd.DataFrame())),
        "report": None if found.report is None else str(found.report),
        "tables": None if found.tables_folder is None else str(found.tables_folder),
        "figures": None if found.figures_folder is None else str(found.figures_folder),
    }


def _plain_outcome(outcome: Outcome, unit: str) -> dict[str, object]:
    return {
        "task": outcome.task,
        "dependent": outcome.dependent,
        "group": plain_rows(outcome.group),
        "primary": _plain_primary(outcome),
        "checks": [outcome.title(name) for name in outcome.analyses() if name is not outcome.primary],
        "anova": None if outcome.anova is None else plain_rows(outcome.anova),
        "status": None if outcome.status is None else outcome.status.value,
        "sentences": primary_sentences(outcome),
        "statistics": outcome_sentences(outcome, unit),
        "notes": list(outcome.notes),
    }


def _plain_primary(outcome: Outcome) -> dict[str, object] | None:
    if outcome.primary is None or outcome.effects is None:
        return None
    return {
        "analysis": outcome.primary.value,
        "title": outcome.title(outcome.primary),
        "reason": outcome.reason,
        "effects": plain_rows(outcome.effects),
    }


def _plain_together(each: HierarchicalOutcome, unit: str) -> dict[str, object]:
    return {
        "task": each.task,
        "status": None if each.fit is None else each.fit.status.value,
        "conditions": plain_rows(each.conditions),
        "participants": plain_rows(each.participants),
        "components": {} if each.fit is None else dict(each.fit.components),
        "sentences": hierarchical_sentences(each, unit),
    }


def plain_rows(table: pd.DataFrame) -> list[dict[str, object]]:
    """Rows as plain values: None for what is missing."""
    return [{str(name): _plain(value) for name, value in row.items()} for row in table.to_dict("records")]


def _plain(value: object) -> object:
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not np.isfinite(value) else value
