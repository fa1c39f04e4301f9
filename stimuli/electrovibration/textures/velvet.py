"""A velvet-like texture: friction that knows the direction of the pile."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments import require
from tactometry.arguments.checked import checked
from tactometry.errors import InvalidParameter

from ...arrays import FloatArray


@dataclass(frozen=True)
class Velvet:
    """Four features of a pile fabric as shares of the electrostatic force; all values are unverified defaults.

    Parameters
    ----------
    with_pile, against_pile : float
        Share when the finger slides with the pile (positive speed) and against it.
    reversal_m : float
        After a change of direction the pile lies down over this length: an exponential transient from the share
        before the reversal to the one after it.
    tuft_period_m : float
        Distance of the tufts, which modulate the friction at ``v/L``.
    tuft_depth : float
        Depth of that modulation (0..1) of the share.

    Raises
    ------
    InvalidParameter
        If a share is not in 0..1, or a length not above 0.
    """

    with_pile: float = 0.3
    against_pile: float = 0.9
    reversal_m: float = 2e-3
    tuft_period_m: float = 1e-3
    tuft_depth: float = 0.3

    def __post_init__(self) -> None:
        require.within(
            "Velvet", 0, 1, with_pile=self.with_pile, against_pile=self.against_pile, tuft_depth=self.tuft_depth
        )
        require.positive("Velvet", reversal_m=self.reversal_m, tuft_period_m=self.tuft_period_m)

    @checked
    def force_share_along(self, x_m: ArrayLike) -> FloatArray:
        """Shares (n_times,) along a path of positions (n_times,): the pile remembers where the finger came from.

        >>> path_m = np.r_[np.linspace(0, 0.05, 501), np.linspace(0.05, 0, 501)[1:]]
        >>> share = Velvet(tuft_depth=0.0).force_share_along(path_m)
        >>> share[[500, -1]].round(3).tolist()
        [0.3, 0.9]
        """
        path = np.asarray(x_m, dtype=np.float64)
        if path.ndim != 1 or path.size == 0:
            raise InvalidParameter(f"Velvet.x_m: found shape {path.shape}, expected positions (n_times,), at least one")
        return self._pile(path) * (1 - self.tuft_depth * (1 - np.cos(2 * np.pi * path / self.tuft_period_m)) / 2)

    def _pile(self, path: FloatArray) -> FloatArray:
        direction = _directions(path)
        target = np.where(direction >= 0, self.with_pile, self.against_pile)
        turns = np.flatnonzero(np.diff(target)) + 1
        bounds = np.r_[0, turns, path.size]
        share, before = np.empty(path.size), float(target[0])
        for low, high in pairwise(bounds):
            way_m = np.abs(path[low:high] - path[max(low - 1, 0)])
            share[low:high] = target[low] + (before - target[low]) * np.exp(-way_m / self.reversal_m)
            before = float(share[high - 1]) if high > low else before
        return share


def _directions(path: FloatArray) -> FloatArray:
    """1 or -1 at each position, the last one that the finger moved in; 1 before it moves."""
    steps = np.sign(np.diff(path, prepend=path[:1]))
    moved = np.where(steps != 0, np.arange(path.size), -1)
    last = np.maximum.accumulate(moved)
    return np.where(last >= 0, steps[np.maximum(last, 0)], 1.0)
