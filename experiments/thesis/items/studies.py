"""What the participants of a built-in study feel: thresholds through the very stimuli and models of the study."""

import math
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from tactometry.contact import Contact
from tactometry.rigs.simulated import Sensation

from ...study.cells import WiredCell
from ...study.experiment import Experiment, wire
from ...study.study_file import load

if TYPE_CHECKING:
    from tactometry.analysis.reading.trials import Trials

BELOW_DB = 40.0
"""How far below the levels of a study a threshold is looked for."""
TOLERANCE_DB = 1e-3
UNFELT_DB = -300.0


@lru_cache(maxsize=4)
def experiment(study: str) -> Experiment:
    """A built-in study, wired."""
    return wire(load(study)[0], study)


def contact_of(cell: WiredCell) -> Contact:
    """How the finger meets the surface in a cell of a study."""
    touch = cell.condition.touch
    return Contact(getattr(touch, "force_n", 0.0), getattr(touch, "speed_m_per_s", 0.0))


def threshold_of(cell: WiredCell) -> float:
    """The level at which the stimulus of a cell is at the threshold of its model, for the contact that it asks for."""
    return level_at_threshold_db(cell, cell.sensation)


def level_at_threshold_db(cell: WiredCell, felt: Sensation) -> float:
    """The same by another model; nan if no level that the study may ask for is felt, or all are by 40 dB."""
    from scipy.optimize import brentq

    def above_db(level_db: float) -> float:
        return max(felt.sensation_db(cell.stimulus.at(level_db), contact_of(cell)), UNFELT_DB)

    low_db, high_db = cell.procedure.rule.bounds
    if not above_db(low_db - BELOW_DB) < 0 < above_db(high_db):
        return math.nan
    return float(brentq(above_db, low_db - BELOW_DB, high_db, xtol=TOLERANCE_DB))


@lru_cache(maxsize=4)
def simulated_trials(study: str, n_participants: int) -> "Trials":
    """The trials of simulated participants of a built-in study, with seed 1."""
    from tactometry.analysis.reading.trials import read_trials

    from ...sessions.simulation import Simulation, simulate

    with TemporaryDirectory() as folder:
        for _ in simulate(Simulation(load(study)[1], study, Path(folder), n_participants, seed=1)):
            pass
        return read_trials(Path(folder))
