"""A carrier whose strength follows a finger over a texture."""

from dataclasses import dataclass, replace
from functools import cached_property
from math import ceil
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tactometry.arguments import require
from tactometry.arguments.checked import NotNegative, Positive, checked

from ...arrays import FloatArray
from ..waveforms.pieces import Pieces
from ..waveforms.sine import Sine
from ..waveforms.waveform import LevelUnit, Ramped, check_nyquist
from .maps import HeightMap, Mapped
from .texture import Bump, Grating, Noise, Region, Texture, Velvet, Way, directions_along, without_jitter


class Followed(NamedTuple):
    """State of a followed path: the finger's path and recent unsmoothed shares."""

    way: Way
    recent: FloatArray


@checked
@dataclass(frozen=True)
class FollowedTexture(Ramped):
    """The voltage ``V0 sqrt(share(x)) sin(2 pi f_c t)``, with x the measured or simulated position of the finger.

    Parameters
    ----------
    texture : Texture or Velvet
        Texture that the friction follows as the finger slides.
    carrier_hz : float
        Carrier frequency, below half of `rate_hz`; the default of 2 kHz is a choice.
    duration_s, ramp_s, rate_hz, level_unit
        As in `Sine`.
    rise_s : float
        Averaging time of the envelope, which limits the slope of an edge and thus the current.
        The default of 1 ms is a choice.
    turn_m : float
        Half of the distance by which the finger must move back to count as turned, so that position noise does not
        count. The default of 0.1 mm is a choice.

    >>> from .texture import Grating
    >>> texture = FollowedTexture(Grating(2e-3), duration_s=0.1, rise_s=5e-5)
    >>> parts, before = texture.parts(np.array([0.5e-3, 1.5e-3]))
    >>> parts.tolist(), texture.parts(np.array([2.5e-3]), before)[0].tolist()
    ([1.0, 0.0], [1.0])
    >>> texture.at(20.0).peak <= 10.0
    True
    """

    texture: Texture | Velvet
    carrier_hz: Positive = 2_000.0
    duration_s: float = 1.0
    ramp_s: float = 0.05
    rate_hz: Positive = 20_000.0
    rise_s: Positive = 1e-3
    turn_m: NotNegative = 1e-4
    level_unit: LevelUnit = "dB re 1 V"

    def __post_init__(self) -> None:
        super().__post_init__()
        check_nyquist("FollowedTexture", "carrier_hz", self.carrier_hz, self.rate_hz)
        short = f"at most duration_s, {self.duration_s:g} s"
        require.expect(self.rise_s <= self.duration_s, "FollowedTexture.rise_s", f"{self.rise_s:g} s", short)

    @cached_property
    def _carrier(self) -> Sine:
        return Sine(self.carrier_hz, self.duration_s, self.ramp_s, self.rate_hz, level_unit=self.level_unit)

    @property
    def voltage_frequency_hz(self) -> float:
        return self.carrier_hz

    @property
    def force_frequency_hz(self) -> float:
        """0, as the force frequency depends on the speed of the finger."""
        return 0.0

    def _unit(self) -> FloatArray:
        return self._carrier._unit()

    def pieces(self, level: float) -> Pieces:
        return self._carrier.pieces(level)

    def parts(self, x_m: Any, before: Followed | None = None) -> tuple[FloatArray, Followed]:
        """Return the share (0..1) of the peak voltage at positions (n_samples,).

        `before` is the state of the path so far; without it the finger starts here, as if it had rested here before. At
        NaN, an unknown position, the share is 0.
        """
        x_m = np.atleast_1d(require.array("FollowedTexture.parts.x_m", x_m))
        require.expect(x_m.size > 0, "FollowedTexture.parts.x_m", "no place", "at least one")
        way = None if before is None else before.way
        known = np.isfinite(x_m)
        shares, way = self._shares(x_m if known.all() else _filled(x_m, known, way), way)
        roots = np.sqrt(np.where(known, shares, 0.0))
        # no two shares differ by more than their time difference divided by `rise_s`
        n = max(1, ceil(self.rise_s * self.rate_hz * (1 - 1e-12)))
        recent = np.full(n - 1, roots[0]) if before is None else before.recent
        course = np.concatenate([recent, roots])
        sums = np.cumsum(np.concatenate([[0.0], course]))
        return np.clip((sums[n:] - sums[:-n]) / n, 0.0, 1.0), Followed(way, course[course.size - n + 1 :])

    def _shares(self, x_m: FloatArray, way: Way | None) -> tuple[FloatArray, Way]:
        start_m = float(x_m[0]) if way is None else way.y_m
        texture = self.texture
        if not isinstance(texture, Velvet | Bump | HeightMap):
            return texture.force_share(x_m), Way(float(x_m[-1]))
        y_m = without_jitter(x_m, start_m, self.turn_m)
        if isinstance(texture, Velvet):
            return texture.after(x_m, y_m, way)
        directions = directions_along(y_m, way or Way(start_m))
        back = replace(texture, direction=-texture.direction)
        shares = np.where(directions > 0, texture.force_share(x_m), back.force_share(x_m))
        return shares, Way(float(y_m[-1]), float(directions[-1]))

    def check_motion(self, speed_m_per_s: float, positions_hz: float | None = None) -> None:
        """Raise an error if the speed is too high for carrier or position rate.

        >>> from .texture import Grating
        >>> FollowedTexture(Grating(1e-4)).check_motion(0.2)
        Traceback (most recent call last):
        tactometry.errors.InvalidParameter: FollowedTexture.carrier_hz: found 2000 Hz, expected at least twice the \
frequency of the texture under the finger (4000 Hz); raise the carrier, slow down or widen the texture
        >>> FollowedTexture(Grating(1e-3)).check_motion(0.1, positions_hz=100.0)
        Traceback (most recent call last):
        tactometry.errors.InvalidParameter: sensor.rate_hz: found 100.0 reports per second, expected \
more than 200 for a period of 0.001 m at 0.1 m/s; else the texture aliases: widen it, slow down or report faster
        """
        period_m = finest_period_m(self.texture)
        if period_m is None:
            return
        needed_hz = 2 * speed_m_per_s / period_m
        require.expect(
            self.carrier_hz >= needed_hz * (1 - 1e-9),
            "FollowedTexture.carrier_hz",
            f"{self.carrier_hz:g} Hz",
            f"at least twice the frequency of the texture under the finger ({needed_hz:.6g} Hz); raise the carrier, "
            "slow down or widen the texture",
        )
        require.expect(
            positions_hz is None or positions_hz > needed_hz * (1 + 1e-9),
            "sensor.rate_hz",
            f"{positions_hz} reports per second",
            f"more than {needed_hz:.6g} for a period of {period_m:.6g} m at {speed_m_per_s:.6g} m/s; else the texture "
            "aliases: widen it, slow down or report faster",
        )


def share_along(texture: Texture | Velvet, path_m: FloatArray) -> FloatArray:
    """Return the share of the force along a path (n_times,).

    >>> share_along(Grating(2e-3), np.array([0.5e-3, 1.5e-3])).tolist()
    [1.0, 0.0]
    """
    return texture.force_share_along(path_m) if isinstance(texture, Velvet) else texture.force_share(path_m)


def finest_period_m(texture: Texture | Velvet) -> float | None:
    """Return the shortest period (m) that positions must resolve, or None.

    For a sinusoidal or sawtooth grating, tufts or noise it is the shortest period. Otherwise it is twice the narrowest
    part: the on or off part of a square grating, the width of a region, the `width_m` of a bump, or a pixel. Positions
    closer than half of it miss no part.

    >>> finest_period_m(Grating(2e-3)), finest_period_m(Grating(2e-3, duty=0.25))
    (0.002, 0.001)
    """
    match texture:
        case Grating(shape="square"):
            return 2 * min(texture.duty, 1 - texture.duty) * texture.period_m or None
        case Grating(period_m=period_m):
            return period_m
        case Velvet(tuft_period_m=period_m, tuft_depth=depth):
            return period_m if depth else None
        case Noise(high_per_m=high_per_m):
            return 1 / high_per_m
        case Mapped(pixel_m=width_m) | Bump(width_m=width_m):
            return 2 * width_m
        case Region(left_m=left_m, right_m=right_m):
            return 2 * (right_m - left_m)
    return None


def _filled(x_m: FloatArray, known: NDArray[np.bool_], way: Way | None) -> FloatArray:
    """Replace unknown positions by the last known position.

    >>> _filled(np.array([np.nan, 1.0, np.nan]), np.array([False, True, False]), None).tolist()
    [0.0, 1.0, 1.0]
    """
    padded_m = np.concatenate([[0.0 if way is None else way.y_m], np.where(known, x_m, 0.0)])
    at = np.maximum.accumulate(np.where(known, np.arange(1, x_m.size + 1), 0))
    return np.asarray(padded_m[at])
