"""Tables of sensation levels through the scene of a study."""

import numpy as np
import pytest

from tactometry.contact import Contact
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.predictions import N_LEVELS, felt_db, level_table
from tactometry.experiments.study.study_file import load
from tactometry.protocols.batch.tracks import tracks


@pytest.fixture(scope="module")
def cells():
    study, _ = load("electrovibration-threshold")
    return tuple(wire(study, "study").cells.values())


def test_level_table_equals_scene_at_levels(cells):
    cell, levels = cells[0], (10.0, 20.0, 35.0)
    table = level_table(cell, levels, Contact(0.5, 0.05))
    assert table.felt[0].tolist() == [felt_db(cell, level, Contact(0.5, 0.05)) for level in levels]
    assert (np.diff(table.felt[0]) > 0).all()


def test_level_table_interpolates_scene(cells):
    cell = cells[0]
    table, (low, high) = level_table(cell), cell.procedure.rule.bounds
    assert len(table.levels) in (N_LEVELS, len(getattr(cell.procedure.rule, "levels", ())))
    for level in np.linspace(low + 0.3 * (high - low), high, 7):
        asked = np.interp(level, table.levels, table.felt[0])
        met = level_table(cell, (level, level + 1.0)).felt[0, 0]
        assert asked == pytest.approx(met, abs=0.1)


def test_batch_finds_the_level_at_threshold(cells):
    """The observer feels exactly the levels above 0 dB."""
    cell = cells[0]
    table = level_table(cell)
    made = tracks(cell.procedure.rule, np.zeros((1, 100)), table)
    at_zero = np.interp(0.0, table.felt[0], table.levels)
    last = made.levels[0, : made.n_trials[0]][-8:]
    assert last.min() - 1.0 <= at_zero <= last.max() + 1.0
