"""Semantic differentials: scores, consistency, comparisons of patterns."""

from typing import TYPE_CHECKING

from tactometry.loading import exports

if TYPE_CHECKING:
    from .scoring import scores as scores

__getattr__, __dir__ = exports(__name__, __file__)
