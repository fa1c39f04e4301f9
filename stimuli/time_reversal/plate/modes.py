"""Modes of a plate: natural frequencies and mode shapes.

Every shape has mean square 1 over the plate, so that every modal mass is the mass of the plate.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Final, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments.checked import Positive, Vector, checked
from tactometry.arguments.require import expect, finite_array, shape

from ...arrays import FloatArray, IntArray
from .dispersion import mindlin_angular_frequency_rad_per_s, mindlin_wavenumber_rad_per_m
from .plate import Plate, navier, ritz
from .rectangle import Axis, SineAxis

if TYPE_CHECKING:
    from .ritz import ParityBlock

ROUNDING: Final = 1e-12
"""Largest shape value that counts as 0: polynomials that vanish at an edge leave up to 3e-14 there."""

OnAxis = Callable[[Axis], FloatArray]


@checked
@runtime_checkable
class Modes(Protocol):
    """Natural frequencies and shapes, sorted by frequency."""

    plate: Plate
    angular_frequency_rad_per_s: FloatArray

    @property
    def frequency_hz(self) -> FloatArray:
        return self.angular_frequency_rad_per_s / (2 * math.pi)

    def products(self, on_x: OnAxis, on_y: OnAxis) -> FloatArray:
        """Return products of `on_x` and `on_y` of each mode's axis functions."""
        raise NotImplementedError

    def frame(self, x_m: Vector, y_m: Vector) -> Callable[[FloatArray], FloatArray]:
        """Return `field` as a function of amplitudes on a fixed grid."""
        raise NotImplementedError

    def field(self, amplitude: FloatArray, x_m: Vector, y_m: Vector) -> FloatArray:
        """Return amplitudes times shapes on a grid by X^T A Y.

        This takes 1/20 of the operations of a sum over modes, and stays in cache.
        """
        return self.frame(x_m, y_m)(amplitude)


@checked
def values(modes: Modes, x_m: ArrayLike, y_m: ArrayLike) -> FloatArray:
    """Return shapes at points (n_modes, n_points), 0 below `ROUNDING`."""
    _check_points(x_m, y_m)
    shapes = modes.products(lambda axis: axis.value(x_m), lambda axis: axis.value(y_m))
    shapes[:, np.abs(shapes).max(axis=0, initial=0.0) < ROUNDING] = 0.0
    return shapes


@checked
def laplacians(modes: Modes, x_m: ArrayLike, y_m: ArrayLike) -> FloatArray:
    """Return Laplacians of the shapes at points, (n_modes, n_points)."""
    _check_points(x_m, y_m)
    along_x = modes.products(lambda axis: axis.curvature(x_m), lambda axis: axis.value(y_m))
    return along_x + modes.products(lambda axis: axis.value(x_m), lambda axis: axis.curvature(y_m))


@checked
@dataclass(frozen=True, eq=False)
class SeparableModes(Modes):
    """Exact modes of simply supported edges: phi_mn = 2 sin(m pi x / a) sin(n pi y / b).

    `m` and `n` (from 1) are in the ascending order of `angular_frequency_rad_per_s`.
    """

    plate: Plate
    angular_frequency_rad_per_s: FloatArray
    m: IntArray
    n: IntArray

    @property
    def on_x(self) -> SineAxis:
        return SineAxis(self.plate.length_m, int(self.m.max(initial=0)))

    @property
    def on_y(self) -> SineAxis:
        return SineAxis(self.plate.width_m, int(self.n.max(initial=0)))

    def products(self, on_x: OnAxis, on_y: OnAxis) -> FloatArray:
        return on_x(self.on_x)[self.m - 1] * on_y(self.on_y)[self.n - 1]

    def frame(self, x_m: Vector, y_m: Vector) -> Callable[[FloatArray], FloatArray]:
        x_functions = np.ascontiguousarray(self.on_x.value(x_m).T)
        y_functions = self.on_y.value(y_m)
        place = (self.m - 1) * len(y_functions) + self.n - 1

        def draw(amplitude: FloatArray) -> FloatArray:
            shape("SeparableModes.draw.amplitude", amplitude, (*amplitude.shape[:-1], len(place)))
            return _field_of(amplitude, place, x_functions, y_functions)

        return draw


@checked
@dataclass(frozen=True, eq=False)
class RitzModes(Modes):
    """Modes of any edges, selected and sorted from blocks of `ritz.solve`."""

    plate: Plate
    angular_frequency_rad_per_s: FloatArray
    blocks: Sequence["ParityBlock"]
    order: IntArray

    def products(self, on_x: OnAxis, on_y: OnAxis) -> FloatArray:
        parts = [b.vectors @ (on_x(b.on_x.axis)[b.i] * on_y(b.on_y.axis)[b.j]) for b in self.blocks]
        return np.concatenate(parts)[self.order]

    def frame(self, x_m: Vector, y_m: Vector) -> Callable[[FloatArray], FloatArray]:
        grids = [(block.on_x.axis.value(x_m).T, block.on_y.axis.value(y_m)) for block in self.blocks]
        ends = np.cumsum([len(block.vectors) for block in self.blocks])

        def draw(amplitude: FloatArray) -> FloatArray:
            shape("RitzModes.draw.amplitude", amplitude, (*amplitude.shape[:-1], len(self.order)))
            unsorted = np.zeros((*amplitude.shape[:-1], ends[-1]))
            unsorted[..., self.order] = amplitude
            parts = np.split(unsorted, ends[:-1], axis=-1)
            drawn = [_draw(b, part, *grid) for b, part, grid in zip(self.blocks, parts, grids, strict=True)]
            return np.asarray(np.sum(drawn, axis=0))

        return draw


@checked
def modes_of(plate: Plate, f_max_hz: Positive, *, shear_factor: float | None = None) -> SeparableModes | RitzModes:
    """Return the modes from 0 Hz to `f_max_hz`, sorted, and cache the last.

    Raises `InvalidParameter` if `f_max_hz` is not above 0, or a Ritz solution would be too large.

    Parameters
    ----------
    plate : Plate
    f_max_hz : float
        Highest frequency of a mode, above 0.
    shear_factor : float, optional
        If given (5/6), Mindlin's dispersion replaces Kirchhoff's, which is exact for simply supported edges. For other
        edges the shapes remain those of the thin plate, and the frequencies are corrected mode by mode (`mindlin`).
        With k the wavenumber and h the thickness, the error is at most 0.2 % up to k h = 0.4 if h is 0.02 of the
        shorter side, and 2.7 % up to k h = 2 if h is 0.1 of it. The errors of the thin plate are 4 % and 60 %.
    """
    return _modes_of(plate, f_max_hz, shear_factor)


@lru_cache(maxsize=16)
def _modes_of(plate: Plate, f_max_hz: float, shear_factor: float | None) -> SeparableModes | RitzModes:
    solve = _separable if plate.boundary == "SSSS" else _ritz
    modes = solve(plate, f_max_hz, shear_factor)
    modes.angular_frequency_rad_per_s.setflags(write=False)  # callers share the result through the cache
    return modes


def _check_points(x_m: ArrayLike, y_m: ArrayLike) -> None:
    finite_array("x_m", x_m)
    finite_array("y_m", y_m)
    expect(np.size(x_m) == np.size(y_m), "x_m, y_m", f"{np.size(x_m)} and {np.size(y_m)} numbers", "as many")


def _thin_hz(plate: Plate, f_max_hz: float, shear_factor: float) -> float:
    """Return the thin plate's frequency for the thick one's wavelength."""
    k_max = float(mindlin_wavenumber_rad_per_m(plate, f_max_hz, shear_factor))
    return plate.wave_constant_m2_per_s * k_max**2 / (2 * math.pi)


def _separable(plate: Plate, f_max_hz: float, shear_factor: float | None) -> SeparableModes:
    if shear_factor is None:
        m, n, k2 = navier(plate, f_max_hz)
        return SeparableModes(plate, plate.wave_constant_m2_per_s * k2, m, n)
    m, n, k2 = navier(plate, _thin_hz(plate, f_max_hz, shear_factor))
    return SeparableModes(plate, mindlin_angular_frequency_rad_per_s(plate, np.sqrt(k2), shear_factor), m, n)


def _ritz(plate: Plate, f_max_hz: float, shear_factor: float | None) -> RitzModes:
    if shear_factor is None:
        blocks = ritz(plate, f_max_hz)
        omega = plate.wave_constant_m2_per_s * np.concatenate([block.wavenumber2_per_m2 for block in blocks])
        return RitzModes(plate, np.sort(omega), blocks, np.argsort(omega, kind="stable"))
    from .dispersion import frequencies_rad_per_s

    thin_hz = _thin_hz(plate, f_max_hz, shear_factor)
    # some modes are slower than their plane wave: solve higher modes too, then cut
    slower = 1.05 + 0.2 * thin_hz * plate.thickness_m**2 * 2 * math.pi / plate.wave_constant_m2_per_s
    blocks = ritz(plate, slower * thin_hz)
    omega = np.concatenate([frequencies_rad_per_s(plate, block, shear_factor) for block in blocks])
    order = np.argsort(omega, kind="stable")
    order = order[omega[order] <= 2 * math.pi * f_max_hz]
    return RitzModes(plate, omega[order], blocks, order)


def _draw(block: "ParityBlock", amplitude: FloatArray, x_functions: FloatArray, y_functions: FloatArray) -> FloatArray:
    place = block.i * len(y_functions) + block.j
    return _field_of(np.asarray(amplitude @ block.vectors), place, x_functions, y_functions)


def _field_of(amplitude: FloatArray, place: IntArray, x_functions: FloatArray, y_functions: FloatArray) -> FloatArray:
    """Return X A Y, with the cheaper product first."""
    (n_x, n_m), (n_n, n_y) = x_functions.shape, y_functions.shape
    table = np.zeros((*amplitude.shape[:-1], n_m * n_n))
    table[..., place] = amplitude
    table = table.reshape(*amplitude.shape[:-1], n_m, n_n)
    if n_x * n_n * (n_m + n_y) < n_m * n_y * (n_n + n_x):
        return np.asarray((x_functions @ table) @ y_functions)
    return np.asarray(x_functions @ (table @ y_functions))
