"""Formulas of touch perception."""

from typing import TYPE_CHECKING

from tactometry.loading import exports

if TYPE_CHECKING:
    from .channels import channel_thresholds_db as channel_thresholds_db, sensation_level_db as sensation_level_db

__getattr__, __dir__ = exports(__name__, __file__)
