"""A rectangle with edges: what its modes depend on, as wavenumbers, before any material gives them a frequency."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...arrays import FloatArray, IntArray


@dataclass(frozen=True)
class Rectangle:
    """0..length in x and 0..width in y.

    Parameters
    ----------
    length_m, width_m : float
        Above 0.
    boundary : str
        Four letters, S (simply supported), C (clamped) or F (free), for x = 0, y = 0, x = length, y = width.
    poisson_ratio : float
        The one constant of a material that enters a shape, through free edges.
    """

    length_m: float
    width_m: float
    boundary: str
    poisson_ratio: float

    @property
    def edges_x(self) -> str:
        """The edges that the functions of x meet: at x = 0 and at x = length."""
        return self.boundary[::2]

    @property
    def edges_y(self) -> str:
        return self.boundary[1::2]

    @property
    def n_rigid(self) -> int:
        """Number of rigid-body motions, {1, x, y} under the essential conditions of the four edges.

        >>> [Rectangle(0.3, 0.2, boundary, 0.3).n_rigid for boundary in ("FFFF", "SFFF", "SFSF", "CFFF")]
        [3, 1, 0, 0]
        """
        edges = (self.edges_x, self.edges_y)
        constant = [pair == "FF" for pair in edges]
        linear = ["C" not in pair and pair.count("S") <= 1 for pair in edges]
        return constant[0] * constant[1] + linear[0] * constant[1] + constant[0] * linear[1]


class Sines(NamedTuple):
    """Half-waves `m` along x and `n` along y, each from 1, by ascending `wavenumber2_per_m2`."""

    m: IntArray
    n: IntArray
    wavenumber2_per_m2: FloatArray


def sines(rectangle: Rectangle, wavenumber2_max_per_m2: float) -> Sines:
    """All modes up to a squared wavenumber: k^2 = (m pi / a)^2 + (n pi / b)^2.

    >>> sines(Rectangle(2.0, 1.0, "SSSS", 0.3), 5 * np.pi**2).m
    array([1, 2, 3, 1, 2, 4])
    """
    sides = (rectangle.length_m, rectangle.width_m)
    along_x, along_y = (np.arange(1, int(side * math.sqrt(wavenumber2_max_per_m2) / math.pi) + 2) for side in sides)
    k2 = (math.pi * along_x[:, None] / sides[0]) ** 2 + (math.pi * along_y[None, :] / sides[1]) ** 2
    # a mode that lies at the limit belongs to it, whichever way its wavenumber was rounded
    m, n = np.nonzero(k2 <= wavenumber2_max_per_m2 * (1 + 1e-12))
    order = np.argsort(k2[m, n], kind="stable")
    return Sines(along_x[m[order]], along_y[n[order]], k2[m, n][order])
