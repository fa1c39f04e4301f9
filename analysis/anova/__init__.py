"""Within-participant designs: analysis of variance, contrasts, pairs, ranks."""

from typing import TYPE_CHECKING

from tactometry.loading import exports

if TYPE_CHECKING:
    from .split_plot import mixed_anova
    from .within_subjects import permutation_test, repeated_measures

__all__ = ["mixed_anova", "permutation_test", "repeated_measures"]

_NAMES = {"split_plot": "mixed_anova", "within_subjects": "permutation_test repeated_measures"}
__getattr__, __dir__ = exports(__name__, _NAMES)
