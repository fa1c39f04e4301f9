"""ANOVA, contrasts and pairwise comparisons of within-participant designs."""

from typing import TYPE_CHECKING

from tactometry.loading import exports

if TYPE_CHECKING:
    from .within_subjects import repeated_measures as repeated_measures

__getattr__, __dir__ = exports(__name__, __file__)
