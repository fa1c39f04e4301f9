"""What is felt of a cell at each level, touched as it is asked: a table for batches, made once for a population."""

from collections.abc import Sequence

import numpy as np

from tactometry.contact import Contact
from tactometry.position_dependent import felt_under, straight_way
from tactometry.protocols.batch.answers import LevelTable
from tactometry.protocols.procedures.procedure import OfLevels
from tactometry.session.request import TRAJECTORY_M

from .cells import WiredCell

N_LEVELS = 81
SILENT_DB = -200.0
"""Of what is not felt at all: a table holds numbers."""


def contact_of(cell: WiredCell) -> Contact:
    """As the cell asks for it; at rest where it asks for nothing."""
    request = cell.condition.touch.request(cell.condition.stimulus, None, None)
    return Contact(getattr(request, "target_n", None) or 0.0, getattr(request, "speed_m_per_s", None) or 0.0)


def felt_db(cell: WiredCell, level: float, contact: Contact) -> float:
    """The sensation level, -inf for what is not felt."""
    signal = cell.stimulus.at(level)
    way = straight_way(signal.duration_s, contact.speed_m_per_s, TRAJECTORY_M)
    return cell.sensation.sensation_db(felt_under(cell.stimulus, signal, *way), contact)


def level_table(cell: WiredCell, levels: Sequence[float] | None = None, contact: Contact | None = None) -> LevelTable:
    """Sensation levels (dB) through the scene of a cell, or what its stimulus has in place of one.

    Parameters
    ----------
    levels : (n_levels,) sequence of float
        Rising; those between are taken on straight lines. Without them the levels of the rule, or `N_LEVELS` from the
        lowest to the highest that it may ask for.
    contact : Contact
        Of a finger; without one as the cell asks for it.
    """
    met = contact_of(cell) if contact is None else contact
    rule = cell.procedure.rule
    own = sorted(set(rule.levels)) if isinstance(rule, OfLevels) else np.linspace(*rule.bounds, N_LEVELS).tolist()
    chosen = levels or own
    told = [max(felt_db(cell, level, met), SILENT_DB) for level in chosen]
    return LevelTable(np.asarray(chosen, dtype=np.float64), np.asarray(told))
