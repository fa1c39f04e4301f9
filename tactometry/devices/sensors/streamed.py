"""Force and position out of the channels of a stream; both may come out of one."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from .force_calibration import ForceCalibration
from .reader import Hear, Reader

FloatArray = NDArray[np.float64]


class StreamedSensor:
    """A sensor that is some channels of a reader: `convert` makes its quantity from counts (n_samples, n_channels)."""

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
        return self._reader.failure

    def facts(self) -> dict[str, str | int | float | None]:
        return self._reader.facts()

    def open(self) -> None:
        if not self._is_open:
            self._reader.open()
            self._is_open = True
            self.read()  # a shared reader may have run before: what it took then is not of this opening

    def read(self) -> tuple[FloatArray, FloatArray]:
        block = self._listener.read(self._reader.source.n_channels)
        return block.times_s, self._convert(block.values)

    def listen(self, hear: Hear) -> Callable[[], None]:
        return self._reader.tell(lambda block: hear(block.times_s, self._convert(block.values)))

    def close(self) -> None:
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
