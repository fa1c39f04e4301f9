"""Formulas of touch perception."""

from tactometry.stimuli.perception.detection import Components, components, sensation_level_db
from tactometry.stimuli.perception.sensitivity import sensitivity_db

__all__ = ["Components", "components", "sensation_level_db", "sensitivity_db"]
