"""Modes of a simply supported rectangle: products of sines, whose wavenumbers are exact."""

import math
from typing import NamedTuple

import numpy as np

from ...arrays import FloatArray, IntArray
from .rectangle import Rectangle


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
