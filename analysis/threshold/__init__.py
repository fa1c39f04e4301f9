"""A psychometric function fitted to counts."""

from typing import TYPE_CHECKING

from tactometry.loading import exports

if TYPE_CHECKING:
    from .fitting import fit, fit_many
    from .result import ThresholdFit
    from .status import Status

__all__ = ["Status", "ThresholdFit", "fit", "fit_many"]

_NAMES = {"fitting": "fit fit_many", "result": "ThresholdFit", "status": "Status"}
__getattr__, __dir__ = exports(__name__, _NAMES)
