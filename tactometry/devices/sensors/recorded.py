"""Recorded file as a sensor, played back in real time."""

import io
import time
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ...arguments.constraints import Positive, PositiveWhole, constrained
from ...errors import DeviceFailed, TactometryError
from ...files.durable import read_file
from ...files.samples import table_of_numbers
from .reader import SampleBlock, SensorSettings, Source, now_s

STEP_S = 0.005


@dataclass(frozen=True)
@constrained
class RecordedSettings(SensorSettings):
    """Recording in a CSV file with a header.

    The first column is ``time_s``, the other columns are channels in counts.

    - `path`: Path of the CSV file, relative to the working directory.
    - `rate_hz`: Sampling rate of the recording.
    - `n_channels`: Number of columns after ``time_s``.
    """

    live: ClassVar[bool] = False
    path: str
    rate_hz: Positive
    n_channels: PositiveWhole = 1

    def source(self) -> "RecordedSource":
        return RecordedSource(self)


class RecordedSource(Source):
    """Source that returns each sample at its time after opening."""

    def __init__(self, settings: RecordedSettings) -> None:
        super().__init__(f"recorded {settings.path}", settings.rate_hz, settings.n_channels)
        self._settings = settings
        self._n_read = 0

    def check(self) -> None:
        _table(Path(self._settings.path), self.n_channels)

    def open(self) -> None:
        table = _table(Path(self._settings.path), self.n_channels)
        self._times_s = table[:, 0] - table[0, 0] + now_s()  # as if the recording began now
        self._values = table[:, 1:]
        self._n_read = 0

    def receive(self) -> SampleBlock | None:
        time.sleep(STEP_S)
        first = self._n_read
        self._n_read = int(np.searchsorted(self._times_s, now_s(), side="right"))
        new = slice(first, self._n_read)
        return SampleBlock(self._times_s[new], self._values[new])


def _table(path: Path, n_channels: int) -> NDArray[np.float64]:
    try:
        lines = io.StringIO(read_file(path, "a CSV file").decode("utf-8-sig"))
        header = lines.readline().strip().split(",")
        table = table_of_numbers(lines, n_columns=len(header))
    except (TactometryError, ValueError) as error:
        raise DeviceFailed(f"{path}: cannot be read as a recording ({error}), expected a CSV file") from None
    if header[0] != "time_s" or len(header) != n_channels + 1:
        raise DeviceFailed(f"{path}: found the columns {', '.join(header)}, expected time_s and {n_channels} channels")
    if not np.isfinite(table[:, 0]).all() or np.any(np.diff(table[:, 0]) <= 0):
        raise DeviceFailed(f"{path}: found times that do not increase, expected increasing times")
    return np.asarray(table)
