"""Fits of psychometric functions to counts of answers."""

from typing import TYPE_CHECKING

from tactometry.loading import exports

if TYPE_CHECKING:
    from .estimates import ThresholdFit as ThresholdFit
    from .fitting import fit as fit, fit_many as fit_many
    from .status import Status as Status

__getattr__, __dir__ = exports(__name__, __file__)
