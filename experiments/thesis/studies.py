"""Built-in studies: sensations of simulated participants, and data."""

import math
from functools import lru_cache, partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from tactometry.contact import Contact
from tactometry.observers.finger import SimulatedFinger
from tactometry.rigs.simulated import Sensation

from ..study import predictions
from ..study.cells import WiredCell
from ..study.experiment import Experiment, wire
from ..study.study_file import load

if TYPE_CHECKING:
    import pandas as pd

    from tactometry.analysis.reading.trials import Trials

STUDY, N_PARTICIPANTS, FORCE = "electrovibration-threshold", 4, "force_n"
FORCES_ASSUME = (
    f"{N_PARTICIPANTS} simulated participants of the built-in study {STUDY} with seed 1. Its forces are unverified "
    f"defaults, and so is the finger: its mean force differs between trials by {100 * SimulatedFinger.force_cv:g} %, "
    "drawn again outside of the 20 % that open the gate, and varies by "
    f"{100 * SimulatedFinger.waver_cv:g} % within a trial. No simulation can say how people pressed."
)


@lru_cache(maxsize=4)
def experiment(study: str) -> Experiment:
    """Return a wired built-in study."""
    return wire(load(study)[0], study)


def cells_of(study: str) -> list[WiredCell]:
    """Return the cells of a built-in study."""
    return list(experiment(study).cells.values())


def contact_of(cell: WiredCell) -> Contact:
    """Return force and speed of the finger in a cell."""
    touch = cell.condition.touch
    return Contact(getattr(touch, "force_n", 0.0), getattr(touch, "speed_m_per_s", 0.0))


def sensation_db(cell: WiredCell, level_db: float, felt: Sensation | None = None) -> float:
    """Return the sensation level of a stimulus level."""
    return (felt or cell.sensation).sensation_db(cell.stimulus.at(level_db), contact_of(cell))


def threshold_db(cell: WiredCell, felt: Sensation | None = None) -> float:
    """Return the stimulus level at the threshold of the model.

    The result is NaN if no level of the study is felt, or if all are by 40 dB.
    """
    result = predictions.threshold_db(partial(sensation_db, cell, felt=felt), cell.procedure.rule.bounds)
    return math.nan if result is None else result


@lru_cache(maxsize=4)
def simulated_trials(study: str, n_participants: int) -> "Trials":
    """Return simulated trials of a built-in study, with seed 1."""
    from tactometry.analysis.reading.trials import read_trials

    from ..sessions.simulation import Simulation, simulate

    with TemporaryDirectory() as folder:
        for _ in simulate(Simulation(load(study)[1], study, Path(folder), n_participants, seed=1)):
            pass
        return read_trials(Path(folder))


@lru_cache(maxsize=1)
def touches() -> "pd.DataFrame":
    """Return the used trials with their mean applied force."""
    from tactometry.analysis.reading.trials import used_rows

    return used_rows(simulated_trials(STUDY, N_PARTICIPANTS))
