"""Formulas of touch perception."""

from .detection import Components, components, sensation_level_db, sensitivity_db

__all__ = ["Components", "components", "sensation_level_db", "sensitivity_db"]
