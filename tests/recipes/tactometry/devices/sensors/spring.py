"""A spring that holds a weight: 1 count, a thousand times a second."""

import time
from dataclasses import dataclass

import numpy as np

from ...arguments.require import positive
from .reader import SampleBlock, SensorSettings, Source, now_s


@dataclass(frozen=True)
class SpringSettings(SensorSettings):
    rate_hz: float = 1000.0

    def __post_init__(self) -> None:
        positive("SpringSettings", rate_hz=self.rate_hz)

    def source(self) -> "SpringSource":
        return SpringSource("spring", self.rate_hz, n_channels=1)


class SpringSource(Source):
    def open(self) -> None:
        self._told_s = now_s()

    def receive(self) -> SampleBlock | None:
        time.sleep(0.005)
        first_s, self._told_s = self._told_s, now_s()
        times_s = np.arange(first_s, self._told_s, 1 / self.rate_hz)
        return SampleBlock(times_s, np.ones((len(times_s), 1)))
