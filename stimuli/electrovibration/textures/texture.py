"""Textures: friction as a function of the finger's position.

A texture is a map from positions to a share (0..1) of the electrostatic force; the envelope of the voltage is its
square root, because the force is quadratic in the voltage.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import accumulate, pairwise
from typing import Literal, NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tactometry.arguments import require
from tactometry.arguments.checked import NotNegative, Positive, checked
from tactometry.errors import InvalidParameter

from ...arrays import FloatArray


class Way(NamedTuple):
    """State of a finger's path up to a moment.

    Parameters
    ----------
    y_m : float
        Last position of the finger, without noise (`without_jitter`).
    direction : float
        Last direction of motion, 1 or -1; 1 before the finger moves.
    turned_m : float
        Position of the last turn, or of the start.
    pile, last_pile : float
        Share of the force at that turn and now, for a texture with a pile.
    """

    y_m: float
    direction: float = 1.0
    turned_m: float = 0.0
    pile: float = 0.0
    last_pile: float = 0.0


def without_jitter(x_m: FloatArray, y_m: float, turn_m: float) -> FloatArray:
    """Return positions (n,) that follow with a backlash of `turn_m`.

    Noise within `turn_m` does not change the direction. This is the play operator of hysteresis (Krasnosel'skii and
    Pokrovskii 1989).

    >>> without_jitter(np.array([0.0, 2.0, 1.5, 2.5, 0.0]), 0.0, 1.0).tolist()
    [0.0, 1.0, 1.0, 1.5, 1.0]
    """
    if turn_m == 0:
        return x_m
    followed = accumulate(x_m.tolist(), lambda y, x: min(max(y, x - turn_m), x + turn_m), initial=y_m)
    return np.array(list(followed)[1:])


def directions_along(path_m: FloatArray, way: Way) -> FloatArray:
    """Return the last direction of motion, 1 or -1, at each position (n,).

    >>> directions_along(np.array([0.0, 0.0, -1.0, -1.0, 2.0]), Way(0.0)).tolist()
    [1.0, 1.0, -1.0, -1.0, 1.0]
    """
    steps = np.sign(np.diff(path_m, prepend=way.y_m))
    moved = np.where(steps != 0, np.arange(path_m.size), -1)
    last = np.maximum.accumulate(moved)
    return np.where(last >= 0, steps[np.maximum(last, 0)], way.direction)


Shape = Literal["square", "sinusoidal", "sawtooth"]


@runtime_checkable
class Texture(Protocol):
    """A map from position to a share of the force."""

    def force_share(self, x_m: ArrayLike) -> FloatArray:
        """Return the share (0..1) of the full force at `x_m` (m), in its shape."""


@checked
@dataclass(frozen=True)
class Grating:
    """A periodic texture: square (on for `duty` of the period), sinusoidal or sawtooth.

    Parameters
    ----------
    period_m : float
        Length of a period, above 0.
    shape : {"square", "sinusoidal", "sawtooth"}
        Course of the friction over a period.
    duty : float
        On share of a ``square`` period.

    >>> Grating(2e-3, "sawtooth").force_share([0.0, 0.5e-3, 2.5e-3]).round(9).tolist()
    [0.0, 0.25, 0.25]
    """

    period_m: Positive
    shape: Shape = "square"
    duty: float = 0.5

    def __post_init__(self) -> None:
        require.within("Grating", 0, 1, duty=self.duty)

    def force_share(self, x_m: ArrayLike) -> FloatArray:
        phase = np.mod(np.asarray(x_m, dtype=np.float64) / self.period_m, 1.0)
        return np.asarray(SHAPES[self.shape](phase, self.duty), dtype=np.float64)


SHAPES: Mapping[str, Callable[[FloatArray, float], NDArray[np.generic]]] = {
    "square": lambda phase, duty: phase < duty,
    "sinusoidal": lambda phase, duty: (1 + np.sin(2 * np.pi * phase)) / 2,
    "sawtooth": lambda phase, duty: phase,
}


@checked
@dataclass(frozen=True)
class Region:
    """A region with share 1 between two edges and 0 outside; each edge may be a linear ramp centred on it.

    Parameters
    ----------
    left_m : float
        Left edge, along the path of the finger.
    right_m : float
        Right edge, along the path of the finger.
    edge_m : float
        Length of the ramp at each edge; 0 for a step.

    >>> Region(0.01, 0.03, edge_m=2e-3).force_share([0.005, 0.01, 0.02, 0.03]).round(9).tolist()
    [0.0, 0.5, 1.0, 0.5]
    """

    left_m: float
    right_m: float
    edge_m: NotNegative = 0.0

    def __post_init__(self) -> None:
        apart = self.right_m - self.left_m >= self.edge_m and self.right_m > self.left_m
        found = f"{self.left_m} to {self.right_m} m with edges of {self.edge_m} m"
        require.expect(apart, "Region", found, "a right edge at least edge_m to the right of the left one")

    def force_share(self, x_m: ArrayLike) -> FloatArray:
        x = np.asarray(x_m, dtype=np.float64)
        if self.edge_m == 0:
            return np.where((x >= self.left_m) & (x < self.right_m), 1.0, 0.0)
        inside_m = np.minimum(x - self.left_m, self.right_m - x)
        return np.clip(inside_m / self.edge_m + 0.5, 0.0, 1.0)


@checked
@dataclass(frozen=True)
class Bump:
    """A bump or hole rendered by its slope: ``1/2 + h'(x)/(2 max |h'|)``, 1/2 outside.

    The friction follows the slope of a Gaussian height of standard deviation `width_m`, since a lateral force that
    follows the slope is felt as a bump. The slope rule is unverified. A finger that moves the other way feels the
    opposite slope: `direction` is 1 or -1.

    Parameters
    ----------
    centre_m : float
        Position of the peak, along the path of the finger.
    width_m : float
        Standard deviation of the Gaussian height.
    height_sign : int
        1 for a bump, -1 for a hole.
    direction : int
        1 for a finger that moves along the path, -1 for one that moves back.

    >>> Bump(0.02, width_m=5e-3).force_share([0.0, 0.015, 0.02, 0.025]).round(3).tolist()
    [0.501, 1.0, 0.5, 0.0]
    """

    centre_m: float
    width_m: Positive
    height_sign: int = 1
    direction: int = 1

    def __post_init__(self) -> None:
        require.one_of("Bump.height_sign", self.height_sign, SIGNS)
        require.one_of("Bump.direction", self.direction, SIGNS)

    def force_share(self, x_m: ArrayLike) -> FloatArray:
        u = (np.asarray(x_m, dtype=np.float64) - self.centre_m) / self.width_m
        steepest = np.exp(-0.5)
        slope = -u * np.exp(-(u**2) / 2) / steepest
        return np.asarray(0.5 + self.height_sign * self.direction * slope / 2)


SIGNS = (1, -1)
LARGEST_TABLE, MOST_LINES = 2**20, 2**28


@checked
@dataclass(frozen=True)
class Noise:
    """A random texture with power ``f^exponent`` between two spatial frequencies, drawn once.

    Parameters
    ----------
    low_per_m, high_per_m : float
        Band (cycles per metre).
    length_m : float
        Length after which the texture repeats; its spectral lines are multiples of ``1/length_m``.
    phases_rad : tuple of float
        One phase per spectral line, from `drawn`.
    exponent : float
        Exponent of the power over spatial frequency; 0 for white noise in the band.
    n_rms : float
        The force share is ``1/2`` plus the noise, clipped to 0..1, where `n_rms` standard deviations make ``1/2``.
    """

    low_per_m: float
    high_per_m: float
    length_m: float
    phases_rad: tuple[float, ...]
    exponent: float = 0.0
    n_rms: Positive = 3.0

    def __post_init__(self) -> None:
        if len(self.phases_rad) != len(self.lines_per_m) or not self.phases_rad:
            raise InvalidParameter(
                f"Noise.phases_rad: found {len(self.phases_rad)}, expected one for each of the "
                f"{len(self.lines_per_m)} lines between {self.low_per_m} and {self.high_per_m} per m "
                f"(multiples of 1/length_m), at least one; use Noise.drawn"
            )

    @classmethod
    def drawn(
        cls, low_per_m: float, high_per_m: float, length_m: float, *, rng: np.random.Generator, exponent: float = 0.0
    ) -> "Noise":
        """Draw a texture with uniform random phases.

        >>> texture = Noise.drawn(100.0, 500.0, 0.1, rng=np.random.default_rng(1))
        >>> len(texture.phases_rad)
        41
        """
        n_lines = len(_lines(low_per_m, high_per_m, length_m))
        return cls(low_per_m, high_per_m, length_m, tuple(rng.uniform(0, 2 * np.pi, n_lines).tolist()), exponent)

    @property
    def lines_per_m(self) -> FloatArray:
        """Spatial frequencies of the texture."""
        return _lines(self.low_per_m, self.high_per_m, self.length_m)

    def height(self, x_m: ArrayLike) -> FloatArray:
        """Return noise of standard deviation 1 over a length, at positions `x_m`."""
        lines = self.lines_per_m
        strongest = lines[-1] if self.exponent >= 0 else lines[0]
        amplitudes = (lines / strongest) ** (self.exponent / 2)
        amplitudes *= np.sqrt(2 / (amplitudes**2).sum())
        x, phases_rad = np.asarray(x_m, dtype=np.float64), np.array(self.phases_rad)
        chunks = np.array_split(x.ravel(), 1 + x.size * lines.size // LARGEST_TABLE)
        parts = [np.cos(2 * np.pi * np.multiply.outer(chunk, lines) + phases_rad) @ amplitudes for chunk in chunks]
        return np.asarray(np.concatenate(parts).reshape(x.shape))

    def force_share(self, x_m: ArrayLike) -> FloatArray:
        return np.clip(0.5 + self.height(x_m) / (2 * self.n_rms), 0.0, 1.0)


def _lines(low_per_m: float, high_per_m: float, length_m: float) -> FloatArray:
    require.positive("Noise", low_per_m=low_per_m, high_per_m=high_per_m, length_m=length_m)
    found = f"{high_per_m} per m over {length_m} m"
    require.expect(high_per_m * length_m <= MOST_LINES, "Noise.high_per_m", found, f"at most {MOST_LINES} lines")
    first, last = int(np.ceil(low_per_m * length_m - 1e-9)), int(np.floor(high_per_m * length_m + 1e-9))
    return np.arange(max(first, 1), last + 1) / length_m


@checked
@dataclass(frozen=True)
class Velvet:
    """Four features of a pile fabric as shares of the electrostatic force; all values are unverified defaults.

    Raises `InvalidParameter` if a share is not in 0..1, or a length not above 0.

    Parameters
    ----------
    with_pile : float
        Share when the finger slides with the pile (positive speed).
    against_pile : float
        Share when the finger slides against the pile (negative speed).
    reversal_m : float
        Length over which the pile lies down after a reversal: an exponential transition from the old to the new share.
    tuft_period_m : float
        Distance L between tufts, which modulate the friction at the frequency ``v/L``.
    tuft_depth : float
        Depth of that modulation, as a part (0..1) of the share.
    """

    with_pile: float = 0.3
    against_pile: float = 0.9
    reversal_m: Positive = 2e-3
    tuft_period_m: Positive = 1e-3
    tuft_depth: float = 0.3

    def __post_init__(self) -> None:
        require.within(
            "Velvet", 0, 1, with_pile=self.with_pile, against_pile=self.against_pile, tuft_depth=self.tuft_depth
        )

    def force_share_along(self, x_m: ArrayLike) -> FloatArray:
        """Return shares (n_times,) along a path, with the memory of the pile.

        >>> path_m = np.r_[np.linspace(0, 0.05, 501), np.linspace(0.05, 0, 501)[1:]]
        >>> share = Velvet(tuft_depth=0.0).force_share_along(path_m)
        >>> share[[500, -1]].round(3).tolist()
        [0.3, 0.9]
        """
        path = np.asarray(x_m, dtype=np.float64)
        if path.ndim != 1 or path.size == 0:
            raise InvalidParameter(f"Velvet.x_m: found shape {path.shape}, expected positions (n_times,), at least one")
        return self.after(path, path, None)[0]

    def after(self, x_m: FloatArray, y_m: FloatArray, way: Way | None) -> tuple[FloatArray, Way]:
        """Return shares at positions `x_m` that continue a path, and the new path.

        >>> velvet, path_m = Velvet(), np.r_[np.linspace(0, 0.05, 501), np.linspace(0.05, 0, 501)[1:]]
        >>> first, way = velvet.after(path_m[:700], path_m[:700], None)
        >>> second, _ = velvet.after(path_m[700:], path_m[700:], way)
        >>> bool(np.allclose(np.r_[first, second], velvet.force_share_along(path_m), rtol=0, atol=1e-15))
        True
        """
        found = f"{len(x_m)} positions and {len(y_m)} path points"
        require.expect(len(x_m) == len(y_m) > 0, "Velvet.after.y_m", found, "equal numbers, at least one")
        pile, then = self._pile(y_m, way or Way(float(y_m[0]), 1.0, float(y_m[0]), self.with_pile, self.with_pile))
        return pile * (1 - self.tuft_depth * (1 - np.cos(2 * np.pi * x_m / self.tuft_period_m)) / 2), then

    def _pile(self, path: FloatArray, way: Way) -> tuple[FloatArray, Way]:
        directions = directions_along(path, way)
        target = np.where(directions > 0, self.with_pile, self.against_pile)
        turns = np.flatnonzero(np.diff(directions, prepend=way.direction))
        share, before, turned_m = np.empty(path.size), way.pile, way.turned_m
        for low, high in pairwise((0, *turns.tolist(), path.size)):
            if low or (turns.size and turns[0] == 0):
                before = float(share[low - 1]) if low else way.last_pile
                turned_m = float(path[low - 1]) if low else way.y_m
            way_m = np.abs(path[low:high] - turned_m)
            share[low:high] = target[low:high] + (before - target[low:high]) * np.exp(-way_m / self.reversal_m)
        return share, Way(float(path[-1]), float(directions[-1]), turned_m, before, float(share[-1]))
