"""Formulas of touch perception."""

from .channels import channel_thresholds_db, sensation_level_db
from .detection import Components, components

__all__ = ["Components", "channel_thresholds_db", "components", "sensation_level_db"]
