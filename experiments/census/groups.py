"""Simulated studies of ten participants in two conditions, each fitted by the hierarchical model: how often its
intervals contain the true values. The table of docs/reference/analysis.md is made of it
(`python benchmarks/census_groups.py`).
"""

from collections.abc import Iterator, Sequence

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from tactometry.analysis.hierarchical.fitting import HierarchicalFit, fit_hierarchical
from tactometry.protocols.batch import tracks as batch
from tactometry.protocols.batch.answers import criteria
from tactometry.protocols.order import stream
from tactometry.protocols.procedures.stepping import SteppingRule

from .thresholds import PROCEDURES, SHAPE

Array = NDArray[np.float64]
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
COLUMNS = ("procedure", "lapses", "study", "n_participants", "participants", "means", "contrast", "error_db", "mean_db")


def outcome(procedure: str, lapses: str, study: int, seed: int) -> tuple[object, ...]:
    """Simulate a study, fit it, and return the shares of intervals that contain the true values (`COLUMNS`)."""
    rng = stream(seed, CHOSEN.index(procedure), list(LAPSES).index(lapses), study)
    own, deviations = rng.standard_normal((N_PEOPLE, 1)), rng.standard_normal((N_PEOPLE, N_CONDITIONS))
    true_db = MEAN_DB + PEOPLE_SD_DB * own + CELL_SD_DB * deviations
    found = _fit(procedure, LAPSES[lapses], true_db, rng)
    table = found.participants
    estimates = table["threshold"].to_numpy(float)
    is_given = table[["interval_low", "interval_high"]].notna().any(axis=1).to_numpy()
    is_held = _holds(table["interval_low"], table["interval_high"], true_db.ravel())[is_given]
    means = found.conditions
    contrast = found.contrast({(1.0,): 1.0, (0.0,): -1.0}) if means["threshold"].notna().all() else None
    held = (is_held.mean(), _holds(means["interval_low"], means["interval_high"], MEAN_DB).mean())
    covers = np.nan if contrast is None else float(contrast.interval_low <= 0 <= contrast.interval_high)
    errors = np.nanmean(estimates - true_db.ravel()), means["threshold"].mean() - MEAN_DB
    return (procedure, lapses, study, is_held.size, *held, covers, *errors)


def _holds(low: pd.Series, high: pd.Series, truth: Array | float) -> NDArray[np.bool_]:
    """Return whether intervals contain the truth; a missing end is infinite."""
    is_above = low.fillna(-np.inf).to_numpy(float) <= truth
    return np.asarray(is_above & (truth <= high.fillna(np.inf).to_numpy(float)))


def _fit(procedure: str, lapses: tuple[float, float], true_db: Array, rng: np.random.Generator) -> HierarchicalFit:
    rule, n_sets = PROCEDURES[procedure](GUESS_RATE), true_db.size
    lapse_rates = np.repeat(np.where(np.arange(N_PEOPLE) < 2, *lapses), N_CONDITIONS)[:, None]
    uniform = rng.random((n_sets, N_TRIALS))
    drawn = criteria(uniform, SHAPE, true_db.reshape(-1, 1), WIDTH_DB, GUESS_RATE, lapse_rates)
    orders = rule.orders(n_sets, rng)[:, :N_TRIALS] if isinstance(rule, SteppingRule) else None
    made = batch.tracks(rule, drawn, orders=orders)
    names = [f"P{place:02d}" for place in range(N_PEOPLE) for _ in range(N_CONDITIONS * N_TRIALS)]
    condition = np.tile(np.repeat([0.0, 1.0], N_TRIALS), N_PEOPLE).tolist()
    levels, answers = made.levels.ravel(), made.answers.ravel()
    is_asked = np.isfinite(levels)
    counts = np.where(is_asked, levels, 0.0), np.where(is_asked, answers, 0), is_asked.astype(int)
    return fit_hierarchical(*counts, names, {"condition": condition}, shape=SHAPE, guess_rate=GUESS_RATE)


def census(studies: Sequence[int], seed: int) -> Iterator[pd.DataFrame]:
    """Return a table of all procedures and lapse rates for each number of a study."""
    for study in studies:
        rows = [outcome(procedure, lapses, study, seed) for procedure in CHOSEN for lapses in LAPSES]
        yield pd.DataFrame(rows, columns=COLUMNS)


def summary(outcomes: pd.DataFrame) -> pd.DataFrame:
    """Return shares in per cent with standard errors over studies, mean error and the worst error of a group mean."""
    rows = []
    for key, each in outcomes.groupby(["procedure", "lapses"], sort=False):
        n, kinds = len(each), ("participants", "means", "contrast")
        shares = [100 * value for kind in kinds for value in (each[kind].mean(), each[kind].std() / np.sqrt(n))]
        worst = each["mean_db"].iloc[int(np.nanargmax(each["mean_db"].abs()))]
        rows.append((*key, n, *shares, each["error_db"].mean(), worst))
    names = ["participants", "se", "means", "se_means", "contrast", "se_contrast", "error_db", "worst_db"]
    return pd.DataFrame(rows, columns=["procedure", "lapses", "studies", *names])
