"""Bias and coverage of estimates by design, lapse rate and true shape.

Each track is fitted twice: as `analyse` does, and with the mode and psignifit's lapse prior ("before").
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product
from typing import Any

import numpy as np
import pandas as pd

from tactometry.analysis.threshold.status import Status
from tactometry.protocols import ConstantStimuli
from tactometry.protocols.batch.answers import criteria
from tactometry.protocols.procedures.procedure import Rule

from .participants import STEPS_DB, SimulatedTask, answered, ends_of, fits, quest_plus, up_down
from .statuses import TOLD

LAPSE_RATES, TRUTHS = (0.0, 0.02, 0.05, 0.08), ("normal", "gumbel")
"""True shapes. The Gumbel function is fitted to both."""
THRESHOLDS_DB, WIDTHS_DB = (17.0, 28.0), (5.0, 15.0)
CONSTANT_DB = tuple(np.arange(10.0, 36.0, 5.0).tolist())
FITS: Mapping[str, Mapping[str, Any]] = {"before": {"lapse_beta": 10.0, "estimate": "mode"}, "now": {}}
FORCED, YES_NO = SimulatedTask("2AFC", 0.5, 0.5), SimulatedTask("", 0.05, None, 0.2)


@dataclass(frozen=True)
class TrackDesign:
    """Procedure for a task, with its number of trials, excluding catch trials."""

    name: str
    rule: Callable[[], Rule[Any]]
    task: SimulatedTask
    n_trials: int


DESIGNS = (
    *(TrackDesign(f"QUEST+ 2AFC {n}", partial(quest_plus, 0.5, "parameters"), FORCED, n) for n in (40, 60)),
    TrackDesign("3 down 1 up 40, 2 dB", partial(up_down, 3, 35.0, (2.0,)), FORCED, 40),
    TrackDesign("3 down 1 up 40, 8-4-2 dB", partial(up_down, 3, 35.0, STEPS_DB), FORCED, 40),
    TrackDesign("constant 2AFC 6 x 20", partial(ConstantStimuli, CONSTANT_DB, 20), FORCED, 120),
    TrackDesign("yes/no 6 x 15 + 18 catch", partial(ConstantStimuli, CONSTANT_DB, 15), YES_NO, 90),
    TrackDesign("QUEST+ yes/no 40 + 8", partial(quest_plus, 0.05, "parameters"), YES_NO, 40),
)


def outcomes_of(
    n_sets: int,
    rng: np.random.Generator,
    designs: Sequence[TrackDesign] = DESIGNS,
    lapse_rates: Sequence[float] = LAPSE_RATES,
    truths: Sequence[str] = TRUTHS,
) -> Iterator[pd.DataFrame]:
    """Yield a table for each design, lapse rate, truth and fit."""
    for design, lapse_rate, truth in product(designs, lapse_rates, truths):
        true_db, width_db = (rng.uniform(*ends, n_sets) for ends in (THRESHOLDS_DB, WIDTHS_DB))
        uniform, rates = rng.random((n_sets, design.n_trials)), (design.task.guess_rate, lapse_rate)
        drawn = criteria(uniform, truth, true_db[:, None], width_db[:, None], *rates)
        simulated = answered(design.rule(), drawn, true_db, width_db, rng)
        alarms = design.task.false_alarms(design.n_trials, n_sets, rng)
        for name, options in FITS.items():
            result = fits(simulated, design.task, design.n_trials, alarms, **options)
            rows = [(one.status.value, one.threshold, *ends_of(one)) for one in result]
            table = pd.DataFrame(rows, columns=["status", "threshold_db", "low_db", "high_db"])
            names: dict[str, Any] = {"design": design.name, "lapse_rate": lapse_rate, "truth": truth, "fit": name}
            yield table.astype({"threshold_db": float}).assign(true_db=true_db, **names)


def summary(outcomes: pd.DataFrame) -> pd.DataFrame:
    """Return bias (SDs), coverage, length and share `flat` by row and fit."""
    by = ["design", "lapse_rate", "truth", "fit"]
    rows = [(*key, *_row(each)) for key, each in outcomes.groupby(by, sort=False)]
    return pd.DataFrame(rows, columns=[*by, "bias", "covered", "covered_all", "length_db", "flat", "flat_covered"])


def _row(outcomes: pd.DataFrame) -> tuple[float, ...]:
    covers = outcomes["true_db"].between(outcomes["low_db"], outcomes["high_db"])
    is_known, is_flat = outcomes["status"].isin(TOLD), outcomes["status"] == Status.FLAT
    known = outcomes[is_known]
    error_db = known["threshold_db"] - known["true_db"]
    length_db = (known["high_db"] - known["low_db"]).median()
    bias = error_db.mean() / error_db.std()
    return bias, covers[is_known].mean(), covers.mean(), length_db, is_flat.mean(), covers[is_flat].mean()
