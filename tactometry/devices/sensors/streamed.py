"""Force and position out of the channels of a stream; both may come out of one."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ...arguments.require import expect
from .force_calibration import ForceCalibration
from .reader import Reader

FloatArray = NDArray[np.float64]
OnSamples = Callable[[FloatArray, FloatArray], None]
"""What takes samples: their times (n_samples,) in s on `time.perf_counter`, and their values."""
MEAN_S = 0.02
"""Positions are averaged over this time before distances are summed, so that noise is no way (unverified default)."""


class StreamedSensor:
    """A sensor that is some channels of a reader: `convert` makes its quantity from counts (n_samples, n_channels).

    A force is in N, (n_samples,), a position on the surface in m, (n_samples, n_axes). Stamps are seconds on
    `time.perf_counter`; a sample that the device knows to be lost is NaN. The device is read in a thread of its own, so
    that drawing never starves it.
    """

    def __init__(self, reader: Reader, convert: Callable[[FloatArray], FloatArray]) -> None:
        self._reader, self._convert = reader, convert
        self._listener = reader.listen()
        self._is_open = False

    @property
    def name(self) -> str:
        return self._reader.source.name

    @property
    def rate_hz(self) -> float:
        return self._reader.source.rate_hz

    @property
    def failure(self) -> str | None:
        """Why it says nothing, where that is known."""
        return self._reader.failure

    def facts(self) -> dict[str, str | int | float | None]:
        return self._reader.facts()

    def open(self) -> None:
        """Begin to collect. Raises `DeviceFailed`."""
        if not self._is_open:
            self._reader.open()
            self._is_open = True
            self.read()  # a shared reader may have run before: what it took then is not of this opening

    def read(self) -> tuple[FloatArray, FloatArray]:
        block = self._listener.read()
        return block.times_s, self._convert(block.values)

    def subscribe(self, on_samples: OnSamples) -> Callable[[], None]:
        """Call `on_samples` with all samples from now on, in the thread that collects them, until the result is called.

        A device that says nothing is told about every `POLL_S`, with empty arrays.
        """
        return self._reader.subscribe(lambda block: on_samples(block.times_s, self._convert(block.values)))

    def close(self) -> None:
        """Let go of the device; may be called more than once."""
        if self._is_open:
            self._is_open = False
            self._reader.close()


def streamed_force(reader: Reader, channel: int, calibration: ForceCalibration) -> StreamedSensor:
    """A force sensor on one channel."""
    return StreamedSensor(reader, lambda counts: calibration.force_n(counts[:, channel]))


def streamed_position(
    reader: Reader, channels: tuple[int, ...], metres_per_count: float, zero_counts: tuple[float, ...] = ()
) -> StreamedSensor:
    """A position sensor on one channel per axis; `zero_counts` (default 0) is where a position is 0."""
    zero = np.array(zero_counts or (0.0,) * len(channels))
    return StreamedSensor(reader, lambda counts: (counts[:, list(channels)] - zero) * metres_per_count)


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
    paired = times_s.ndim == 1 and positions_m.ndim == 2 and len(times_s) == len(positions_m)
    sizes = f"{times_s.shape} stamps and {positions_m.shape} positions"
    expected = "rising stamps (n_samples,) and positions (n_samples, n_axes)"
    expect(paired and not np.any(np.diff(times_s) < 0), "mean_speed_m_per_s", sizes, expected)
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
