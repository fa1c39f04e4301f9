"""Simulated answers to the AttrakDiff questionnaire."""

import numpy as np
import pandas as pd

from tactometry.analysis.attrakdiff.scoring import THESIS
from tactometry.questionnaire import load

FORM = load("attrakdiff")

ITEMS = [item.id for item in FORM.items]


def study(rng, n=12, effect=None) -> pd.DataFrame:
    """Answers of whole steps; `effect` maps a pattern to what it adds to every score."""
    rows = []
    for person in range(n):
        own = rng.normal(0, 0.7)
        for pattern in PATTERNS:
            for item in ITEMS:
                score = np.clip(round(own + (effect or {}).get(pattern, 0.0) + rng.normal(0, 1.0)), -3, 3)
                rows.append((f"P{person:02d}", pattern, "attrakdiff", "rating", item, raw_of(item, score)))
    return pd.DataFrame(rows, columns=["participant", "pattern", "procedure", "task", "item", "response"])


PATTERNS = ("P0", *THESIS)


def raw_of(item: str, score: float) -> float:
    return 4 - score if FORM.item(item).reversed else 4 + score


def write(path, table):
    """Write answers as a trials table, and return its path."""
    table = table.assign(session=1, study="patterns", block=1, trial=range(1, len(table) + 1), level="", valid=1)
    first = ["participant", "session", "study", "block", "trial", "pattern", "procedure", "level"]
    table[[*first, "task", "item", "response", "valid"]].to_csv(path, index=False)
    return path
