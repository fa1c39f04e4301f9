"""What measures where the finger is: the seam of every position sensor, and the speed that follows."""

from typing import Protocol

import numpy as np

from ...errors import InvalidParameter
from .reader import FloatArray, Told

MEAN_S = 0.02
"""Positions are averaged over this time before distances are summed, so that noise is no way (unverified default)."""


class PositionSensor(Told, Protocol):
    """A stream of positions on the surface, m, (n_samples, n_axes), stamped as those of a `ForceSensor`."""

    @property
    def name(self) -> str: ...

    @property
    def rate_hz(self) -> float: ...

    def open(self) -> None:
        """Begin to collect. Raises `DeviceFailed`."""

    def close(self) -> None:
        """May be called more than once."""


def mean_speed_m_per_s(times_s: FloatArray, positions_m: FloatArray) -> float | None:
    """How fast a finger moved: the way along the mean positions of each `MEAN_S`, over the time between them.

    Parameters
    ----------
    times_s : (n_samples,) array
        Rising stamps, s.
    positions_m : (n_samples, n_axes) array
        Finite positions, m.

    Returns
    -------
    float or None
        None where the samples fill less than two such times.

    Raises
    ------
    InvalidParameter
        If the shapes do not fit or the stamps go back.

    Examples
    --------
    >>> times_s = np.arange(1000) / 1000
    >>> round(mean_speed_m_per_s(times_s, np.column_stack([0.03 * times_s, 0.04 * times_s])), 9)
    0.05
    """
    if times_s.ndim != 1 or positions_m.ndim != 2 or len(times_s) != len(positions_m) or np.any(np.diff(times_s) < 0):
        raise InvalidParameter(
            f"mean_speed_m_per_s: found {times_s.shape} stamps and {positions_m.shape} positions, expected rising "
            "stamps (n_samples,) and positions (n_samples, n_axes)"
        )
    if len(times_s) == 0:
        return None
    bins = np.floor((times_s - times_s[0]) / MEAN_S).astype(int)
    kept, first = np.unique(bins, return_index=True)
    if len(kept) < 2:
        return None
    n_each = np.diff([*first, len(times_s)])
    mean_times_s = np.add.reduceat(times_s, first) / n_each
    means_m = np.add.reduceat(positions_m, first, axis=0) / n_each[:, None]
    way_m = np.linalg.norm(np.diff(means_m, axis=0), axis=1).sum()
    return float(way_m / (mean_times_s[-1] - mean_times_s[0]))
