"""Impulse responses from every channel to every point."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from tactometry.arguments.checked import checked
from tactometry.arguments.require import expect, one_of, some, whole
from tactometry.errors import InvalidParameter

from ...arrays import FloatArray
from ...defaults import AUDIBLE_MAX_HZ
from ..filters import Band, GainCurve, filtered
from ..plate.modes import values
from ..plate.oscillators import QUANTITIES, check_sampling
from ..screen.screen import Screen

Point = tuple[float, float]

CHUNK: Final = 16_384
MAX_SAMPLES: Final = 1_000_000_000


@checked
@dataclass(frozen=True, eq=False)
class Responses:
    """Responses of each point to a unit sample on each channel.

    Parameters
    ----------
    samples : (n_points, n_channels, n_samples) array
        Finite values in m, m/s or m/s^2 per unit of the channel. The array is made read-only.
    rate_hz : float
        Sampling rate, above 0.
    quantity : str
        ``displacement``, ``velocity`` or ``acceleration``.
    """

    samples: FloatArray
    rate_hz: float
    quantity: str = "displacement"

    def __post_init__(self) -> None:
        samples = np.asarray(self.samples, float).view()  # copied, as it is made read-only below
        if samples.ndim != 3 or 0 in samples.shape[:2]:
            raise InvalidParameter(
                f"Responses.samples: found shape {samples.shape}, expected (n_points, n_channels, n_samples) "
                "with at least one point and one channel"
            )
        check_sampling(self.rate_hz, samples.shape[2])
        one_of("Responses.quantity", self.quantity, QUANTITIES)
        samples.setflags(write=False)
        object.__setattr__(self, "samples", samples)

    @property
    def n_points(self) -> int:
        return int(self.samples.shape[0])

    @property
    def n_channels(self) -> int:
        return int(self.samples.shape[1])

    @property
    def n_samples(self) -> int:
        return int(self.samples.shape[2])

    @property
    def duration_s(self) -> float:
        return self.n_samples / self.rate_hz

    def at_point(self, index: int) -> "Responses":
        """Return the responses of one point."""
        return replace(self, samples=self.samples[index : index + 1])

    def mean_of(self, points: Sequence[int]) -> "Responses":
        """Return the mean over at least one point, as for simultaneous foci."""
        some("Responses.mean_of.points", points)
        return replace(self, samples=self.samples[list(points)].mean(axis=0, keepdims=True))

    def of_channels(self, channels: Sequence[int]) -> "Responses":
        """Return the responses of some channels."""
        return replace(self, samples=self.samples[:, list(channels)])


@checked
def impulse_responses(
    screen: Screen,
    points: Sequence[Point],
    *,
    rate_hz: float,
    duration_s: float,
    f_max_hz: float,
    quantity: str = "displacement",
    static_to_hz: float | None = None,
) -> Responses:
    """Return the model's responses, exact sums over modes to `f_max_hz`.

    A unit sample is an impulse of area 1 / rate. All pairs of point and channel are summed at once, chunk by
    chunk of time; see `modal_sum`.

    Raises `InvalidParameter` if a point or transducer is missing or outside the plate, `f_max_hz` is above the Nyquist
    frequency, or `static_to_hz` is invalid.

    Parameters
    ----------
    screen : Screen
    points : sequence of (x_m, y_m)
    rate_hz : float
        Sampling rate, at least twice `f_max_hz`.
    duration_s : float
        Duration, at least 0, rounded to whole samples.
    static_to_hz : float, optional
        Frequency above `f_max_hz`. Modes between the two respond without inertia, which adds their static compliance to
        sample 0 (displacement only). Up to half of `f_max_hz` this is more accurate than three times as many modes.

    >>> from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE
    >>> h = impulse_responses(A4_PROTOTYPE, [(0.1, 0.1)], rate_hz=50e3, duration_s=1e-3, f_max_hz=10e3)
    >>> h.samples.shape
    (1, 32, 50)
    """
    one_of("impulse_responses.quantity", quantity, QUANTITIES)
    n_samples = samples_in("duration_s", duration_s, rate_hz)
    if 2 * f_max_hz > rate_hz:
        raise InvalidParameter(
            f"f_max_hz: found {f_max_hz}, above the Nyquist frequency {rate_hz / 2}; raise rate_hz or lower f_max_hz"
        )
    from ..plate.modal_sum import modal_sums

    at_points = values_at(screen, points, f_max_hz)
    weights = np.asarray(at_points.T[:, None, :] * screen.modal_forces(f_max_hz).T[None, :, :])
    out = np.empty((weights.shape[0] * weights.shape[1], n_samples))
    flat = weights.reshape(len(out), -1) / (screen.plate.mass_kg * rate_hz)
    for start, stop in chunks(n_samples):
        modal_sums(screen.oscillators(f_max_hz), flat, rate_hz, start, stop, quantity, out=out[:, start:stop])
    if static_to_hz is not None and n_samples:
        out[:, 0] += _static_residual(screen, points, f_max_hz, static_to_hz, quantity).ravel()
    return Responses(out.reshape(*weights.shape[:2], n_samples), rate_hz, quantity)


@checked
def samples_in(name: str, duration_s: float, rate_hz: float) -> int:
    """Return the whole samples of a duration, at least 0."""
    check_sampling(rate_hz, 0)
    expect(np.isfinite(duration_s) and duration_s >= 0, name, duration_s, "a finite time, at least 0")
    expected = f"at most {MAX_SAMPLES:.0e} samples"
    expect(duration_s * rate_hz <= MAX_SAMPLES, name, f"{duration_s} s at {rate_hz} Hz", expected)
    return round(duration_s * rate_hz)


@checked
def chunks(n_samples: int, size: int = CHUNK) -> Iterator[tuple[int, int]]:
    """Return start and stop of chunks of at most `size` samples."""
    whole("chunks", lowest=1, size=size)
    for start in range(0, n_samples, size):
        yield start, min(start + size, n_samples)


def _static_residual(
    screen: Screen, points: Sequence[Point], f_max_hz: float, static_to_hz: float, quantity: str
) -> FloatArray:
    """Return the static displacement by the modes above `f_max_hz`."""
    found, expected = f"{static_to_hz} for {quantity}", f"a frequency above f_max_hz = {f_max_hz} and displacement"
    expect(f_max_hz < static_to_hz < np.inf and quantity == "displacement", "static_to_hz", found, expected)
    omega = screen.modes(static_to_hz).angular_frequency_rad_per_s
    left_out = omega > 2 * np.pi * f_max_hz
    compliance = left_out / (screen.plate.mass_kg * np.where(left_out, omega, 1.0) ** 2)
    at_points = values_at(screen, points, static_to_hz) * compliance[:, None]
    return np.asarray(at_points.T @ screen.modal_forces(static_to_hz))


@checked
def values_at(screen: Screen, points: Sequence[Point], f_max_hz: float) -> FloatArray:
    """Return the mode shapes at points of the plate, (n_modes, n_points).

    Raises `InvalidParameter` if there is no point, or one is outside of the plate.
    """
    place = np.asarray(points, float)
    expect(len(place) != 0, "points", "none", "at least one")
    expect(place.ndim == 2 and place.shape[1] == 2, "points", f"shape {place.shape}", "(n_points, 2), pairs (x_m, y_m)")
    for i, (x, y) in enumerate(place):
        screen.plate.check_holds(f"points[{i}]", (x, y))
    return values(screen.modes(f_max_hz), place[:, 0], place[:, 1])


@checked
def through(responses: Responses, gain: GainCurve) -> Responses:
    """Return the responses filtered by a linear element.

    The part before time 0 is cut off.

    >>> h = Responses(np.eye(1, 64)[None], 1e3)
    >>> from tactometry.stimuli.time_reversal.filters import Butterworth
    >>> np.round(through(h, Butterworth(10.0)).samples[0, 0, :2], 3)
    array([0.031, 0.065])
    """
    return replace(responses, samples=filtered(responses.samples, responses.rate_hz, gain))


@checked
def band_limited(responses: Responses, band: Band) -> Responses:
    """Filter responses to a band.

    Raises `InvalidParameter` if the band reaches above the Nyquist frequency.
    """
    if 2 * band.f_max_hz > responses.rate_hz * (1 + 1e-12):
        raise InvalidParameter(
            f"Band.f_max_hz: found {band.f_max_hz}, above the Nyquist frequency "
            f"{responses.rate_hz / 2} of the responses; lower it"
        )
    return through(responses, band)


@checked
def inaudible(responses: Responses, cutoff_hz: float = AUDIBLE_MAX_HZ, flank_hz: float = 0.0) -> Responses:
    """Filter responses to frequencies above `cutoff_hz`, before reversal."""
    return band_limited(responses, Band(cutoff_hz, responses.rate_hz / 2, flank_hz))
