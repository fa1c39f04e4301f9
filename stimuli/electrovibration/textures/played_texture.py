"""A texture under a moving finger: position sensor, latency, and the voltage that follows."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from tactometry.arguments import require
from tactometry.arguments.annotations import NotNegative, Positive, Vector
from tactometry.arguments.checked import checked
from tactometry.errors import InvalidParameter
from tactometry.signal import Signal

from ...arrays import FloatArray
from ..waveforms.sampled import strongest_hz
from ..waveforms.waveform import LevelUnit, check_nyquist, check_timing, peak_voltage_v, ramped
from .maps import Mapped
from .texture import Bump, Grating, Image, Noise, Region, Texture, Velvet


@checked
@dataclass(frozen=True)
class SensorModel:
    """What the screen knows of the finger: samples at a rate, in steps of a resolution, late, held until the next.

    Parameters
    ----------
    rate_hz : float
        Position reports per second.
    resolution_m : float
        Step of the reported position; 0 is none.
    latency_s : float
        From the position to the voltage that answers it.
    """

    rate_hz: Positive = 1000.0
    resolution_m: NotNegative = 0.0
    latency_s: NotNegative = 0.0

    def reported_m(self, x_m: Vector, rate_hz: Positive) -> FloatArray:
        """Positions (n_samples,) that are known at the samples of a path at `rate_hz`; the first before any report.

        >>> SensorModel(rate_hz=2.0).reported_m(np.arange(6.0), rate_hz=4.0).tolist()
        [0.0, 0.0, 2.0, 2.0, 4.0, 4.0]
        """
        t_s = np.arange(x_m.size) / rate_hz - self.latency_s
        report_s = np.floor(t_s * self.rate_hz + 1e-9) / self.rate_hz
        known = np.interp(report_s, np.arange(x_m.size) / rate_hz, x_m)
        steps = known if self.resolution_m == 0 else np.round(known / self.resolution_m) * self.resolution_m
        return np.asarray(steps, dtype=np.float64)

    def check(self, period_m: Positive, speed_m_per_s: NotNegative) -> None:
        """Refuse a texture whose period is not longer than two reports and two steps of resolution.

        >>> SensorModel(rate_hz=100.0).check(period_m=1e-3, speed_m_per_s=0.1)
        Traceback (most recent call last):
        tactometry.errors.InvalidParameter: SensorModel.rate_hz: found 100.0 reports per second, expected \
more than 200 for a period of 0.001 m at 0.1 m/s; else the texture aliases: widen it, slow down or report faster
        """
        needed_hz = 2 * speed_m_per_s / period_m
        require.expect(
            self.rate_hz > needed_hz * (1 + 1e-9),
            "SensorModel.rate_hz",
            f"{self.rate_hz} reports per second",
            f"more than {needed_hz:.6g} for a period of {period_m:.6g} m at {speed_m_per_s:.6g} m/s; else the texture "
            "aliases: widen it, slow down or report faster",
        )
        fine = self.resolution_m < period_m / 2 * (1 - 1e-9)
        less = f"less than half of the period ({period_m / 2:.6g} m); else the texture aliases: widen it"
        require.expect(fine, "SensorModel.resolution_m", f"{self.resolution_m} m", less)


@checked
@dataclass(frozen=True)
class PlayedTexture:
    """``V0 sqrt(share(x(t))) sin(2 pi f_c t)`` along the path of a finger.

    Raises `InvalidParameter` if a value is outside of its domain, or the path, sensor or carrier is too slow or too
    coarse.

    Parameters
    ----------
    texture : Texture or Velvet
    path_m : tuple of float
        Position of the finger at each sample.
    rate_hz : float
    carrier_hz : float
        Carrier, below half of `rate_hz`; 2 kHz is an unverified default.
    sensor : SensorModel or None
        None: the position is known exactly and at once.
    aliasing : {"refuse", "allow"}
        Whether a path, sensor or carrier that is too slow or too coarse for the finest part of the texture at the
        fastest part of the path is an error: each wants more than two steps in `finest_period_m`, the carrier at
        least twice the frequency at which that period passes, and their sum stays below half of `rate_hz`.
    ramp_s
        Ramps on and off over the time of the path; none by default.
    level_unit
        As in `Sine`.

    >>> grating = PlayedTexture(Grating(1e-3, "sinusoidal"), straight_path_m(0.1, 0.5, 20e3))
    >>> grating.voltage_frequency_hz, grating.force_frequency_hz
    (2000.0, 100.0)
    """

    texture: Texture | Velvet
    path_m: tuple[float, ...]
    rate_hz: Positive = 20_000.0
    carrier_hz: Positive = 2_000.0
    sensor: SensorModel | None = None
    aliasing: Literal["refuse", "allow"] = "refuse"
    ramp_s: float = 0.0
    level_unit: LevelUnit = "dB re 1 V"

    def __post_init__(self) -> None:
        check_nyquist("PlayedTexture", "carrier_hz", self.carrier_hz, self.rate_hz)
        path = np.asarray(self.path_m, dtype=np.float64)
        require.expect(path.size > 0, "PlayedTexture.path_m", f"shape {path.shape}", "positions (n_samples,)")
        check_timing("PlayedTexture", self.duration_s, self.ramp_s, self.rate_hz)
        period_m = finest_period_m(self.texture)
        if period_m is not None and self.aliasing == "refuse":
            self._check_sampling(period_m, float(np.abs(np.diff(path)).max(initial=0.0)))

    def _check_sampling(self, period_m: float, step_m: float) -> None:
        if step_m >= period_m / 2 * (1 - 1e-9):
            raise InvalidParameter(
                f"PlayedTexture.path_m: found a step of {step_m:.6g} m, expected less than half of the texture's "
                f"period ({period_m / 2:.6g} m); else the texture aliases: widen it, slow down or raise rate_hz"
            )
        if self.sensor is not None:
            self.sensor.check(period_m, step_m * self.rate_hz)
        texture_hz = step_m * self.rate_hz / period_m
        sideband_hz = round(self.carrier_hz + texture_hz, 6)
        check_nyquist("PlayedTexture", "carrier_hz + that of the texture", sideband_hz, self.rate_hz)
        check_carrier("PlayedTexture", self.carrier_hz, texture_hz)

    @property
    def duration_s(self) -> float:
        return len(self.path_m) / self.rate_hz

    @property
    def voltage_frequency_hz(self) -> float:
        return self.carrier_hz

    @property
    def force_frequency_hz(self) -> float:
        """The strongest line of the share along the path; 0 if there is none."""
        return strongest_hz(self.force_share, self.rate_hz)

    @property
    def force_share(self) -> FloatArray:
        """(n_samples,) share of the force that the finger is to meet."""
        path = np.array(self.path_m)
        known = path if self.sensor is None else self.sensor.reported_m(path, self.rate_hz)
        return share_along(self.texture, known)

    def at(self, level: float) -> Signal:
        """(1, n_samples) volt; no sample passes the peak that `level` states."""
        t_s = np.arange(len(self.path_m)) / self.rate_hz
        shape = np.sqrt(self.force_share) * np.sin(2 * np.pi * self.carrier_hz * t_s)
        samples = peak_voltage_v(level, self.level_unit) * ramped(shape, self.ramp_s, self.rate_hz)
        return Signal(samples[None, :], self.rate_hz, "V")


def share_along(texture: Texture | Velvet, path_m: FloatArray) -> FloatArray:
    """Share of the force along positions (n_times,) in the order in which a finger reaches them.

    >>> share_along(Grating(2e-3), np.array([0.5e-3, 1.5e-3])).tolist()
    [1.0, 0.0]
    """
    return texture.force_share_along(path_m) if isinstance(texture, Velvet) else texture.force_share(path_m)


def check_carrier(owner: str, carrier_hz: float, texture_hz: float) -> None:
    """Refuse a carrier that is too slow to show a texture whose finest part passes the finger at `texture_hz`."""
    expected = (
        f"at least twice the frequency of the texture under the finger ({2 * texture_hz:.6g} Hz); raise the carrier, "
        "slow down or widen the texture"
    )
    is_fast = carrier_hz >= 2 * texture_hz * (1 - 1e-9)
    require.expect(is_fast, f"{owner}.carrier_hz", f"{carrier_hz:g} Hz", expected)


def finest_period_m(texture: Texture | Velvet) -> float | None:
    """The shortest period (m) that positions must resolve; None if there is none.

    Of a sinusoidal or sawtooth grating, tufts or a band of noise it is the shortest one itself; else twice the
    narrowest part: of a square grating the part that is on or off, of a region its width, of a bump its `width_m`, of
    an image or heights a pixel. Positions closer than half of it miss no part.

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
        case Image(pixel_m=width_m) | Mapped(pixel_m=width_m) | Bump(width_m=width_m):
            return 2 * width_m
        case Region(left_m=left_m, right_m=right_m):
            return 2 * (right_m - left_m)
    return None


@checked
def straight_path_m(
    speed_m_per_s: float, duration_s: Positive, rate_hz: Positive, start_m: float = 0.0
) -> tuple[float, ...]:
    """Positions of a finger at constant speed.

    >>> straight_path_m(0.1, 0.2, 10.0)
    (0.0, 0.01)
    """
    check_timing("straight_path_m", duration_s, 0.0, rate_hz)
    return tuple((start_m + speed_m_per_s * np.arange(round(duration_s * rate_hz)) / rate_hz).tolist())
