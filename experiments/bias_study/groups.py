"""Coverage of the hierarchical model by procedure and lapse rate."""

from collections.abc import Iterator, Sequence

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from tactometry.analysis.hierarchical.fitting import HierarchicalFit, fit_hierarchical
from tactometry.protocols.batch.answers import criteria
from tactometry.protocols.order import stream

from .participants import PROCEDURES, SHAPE, Array, answered

N_PEOPLE, N_CONDITIONS, N_TRIALS = 10, 2, 40
MEAN_DB, PEOPLE_SD_DB, CELL_SD_DB, WIDTH_DB, GUESS_RATE = 20.0, 3.0, 1.0, 10.0, 0.5
CHOSEN = ("QUEST", "QUEST+", "1 up 3 down", "constant stimuli")
LAPSES = {
    "0": (0.0, 0.0),
    "2 %": (0.02, 0.02),
    "5 %": (0.05, 0.05),
    "10 %": (0.1, 0.1),
    "2 of 10 at 15 %": (0.15, 0.01),
}
"""Lapse rates of the first two participants and of the others."""


def outcome(procedure: str, lapses: str, study: int, seed: int) -> dict[str, object]:
    """Simulate and fit a study, and return interval coverage and errors."""
    rng = stream(seed, CHOSEN.index(procedure), list(LAPSES).index(lapses), study)
    own, deviations = rng.standard_normal((N_PEOPLE, 1)), rng.standard_normal((N_PEOPLE, N_CONDITIONS))
    true_db = MEAN_DB + PEOPLE_SD_DB * own + CELL_SD_DB * deviations
    result = _fit(procedure, LAPSES[lapses], true_db, rng)
    people, means = result.participants, result.conditions
    is_given = people[["interval_low", "interval_high"]].notna().any(axis=1).to_numpy()
    covers, is_covered = np.nan, _covers(people, true_db.ravel())[is_given]
    if means["threshold"].notna().all():
        contrast = result.contrast({(1.0,): 1.0, (0.0,): -1.0})
        covers = float(contrast.interval_low <= 0 <= contrast.interval_high)
    return {
        "procedure": procedure,
        "lapses": lapses,
        "study": study,
        "participants": is_covered.mean(),
        "means": _covers(means, MEAN_DB).mean(),
        "contrast": covers,
        "error_db": np.nanmean(people["threshold"].to_numpy(float) - true_db.ravel()),
        "mean_db": means["threshold"].mean() - MEAN_DB,
    }


def _covers(table: pd.DataFrame, truth: Array | float) -> NDArray[np.bool_]:
    """Return which intervals contain the truth. A missing end is infinite."""
    low, high = table["interval_low"].fillna(-np.inf), table["interval_high"].fillna(np.inf)
    return np.asarray((low.to_numpy(float) <= truth) & (truth <= high.to_numpy(float)))


def _fit(procedure: str, lapses: tuple[float, float], true_db: Array, rng: np.random.Generator) -> HierarchicalFit:
    lapse_rates = np.repeat(np.where(np.arange(N_PEOPLE) < 2, *lapses), N_CONDITIONS)[:, None]
    uniform, truths_db = rng.random((true_db.size, N_TRIALS)), true_db.reshape(-1, 1)
    drawn = criteria(uniform, SHAPE, truths_db, WIDTH_DB, GUESS_RATE, lapse_rates)
    made = answered(PROCEDURES[procedure](GUESS_RATE), drawn, true_db.ravel(), np.full(true_db.size, WIDTH_DB), rng)
    names = [f"P{place:02d}" for place in range(N_PEOPLE) for _ in range(N_CONDITIONS * N_TRIALS)]
    condition = np.tile(np.repeat([0.0, 1.0], N_TRIALS), N_PEOPLE).tolist()
    levels, is_yes = made.levels_db.ravel(), made.answers.ravel()
    is_asked = np.isfinite(levels)
    counts = np.where(is_asked, levels, 0.0), np.where(is_asked, is_yes, 0).astype(int), is_asked.astype(int)
    return fit_hierarchical(*counts, names, {"condition": condition}, shape=SHAPE, guess_rate=GUESS_RATE)


def outcomes_of(studies: Sequence[int], seed: int) -> Iterator[pd.DataFrame]:
    """Yield a table of outcomes for each study number."""
    for study in studies:
        yield pd.DataFrame([outcome(procedure, lapses, study, seed) for procedure in CHOSEN for lapses in LAPSES])


def summary(outcomes: pd.DataFrame) -> pd.DataFrame:
    """Return coverage with its standard error, and the mean and worst error."""
    rows = []
    for (procedure, lapses), each in outcomes.groupby(["procedure", "lapses"], sort=False):
        row = {"procedure": procedure, "lapses": lapses, "studies": len(each)}
        for kind in ("participants", "means", "contrast"):
            row |= {kind: each[kind].mean(), f"se_{kind}": each[kind].std() / np.sqrt(len(each))}
        worst = each["mean_db"].iloc[int(np.nanargmax(each["mean_db"].abs()))]
        rows.append(row | {"error_db": each["error_db"].mean(), "worst_db": worst})
    return pd.DataFrame(rows)
