"""Semantic differentials: scores, consistency, patterns of the thesis."""

from typing import TYPE_CHECKING

from tactometry.loading import exports

if TYPE_CHECKING:
    from .scoring import item_scores, scores

__all__ = ["item_scores", "scores"]

_NAMES = {"scoring": "item_scores scores"}
__getattr__, __dir__ = exports(__name__, _NAMES)
