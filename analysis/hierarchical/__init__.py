"""Hierarchical psychometric model of all participants."""

from typing import TYPE_CHECKING

from tactometry.loading import exports

if TYPE_CHECKING:
    from .fitting import fit_hierarchical as fit_hierarchical
    from .result import HierarchicalFit as HierarchicalFit

__getattr__, __dir__ = exports(__name__, __file__)
