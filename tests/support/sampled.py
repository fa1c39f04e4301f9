"""A sensor that samples a function of time in the reader's thread, and wrappers of devices."""

import time

import numpy as np

from tactometry.devices.sensors.reader import Reader, SampleBlock
from tactometry.devices.sensors.streamed import ForceCalibration, streamed_force

STEP_S = 0.002


class Sampled:
    """A source of one channel: `value` gives the counts at a time (s), None where a sample is missing."""

    name, n_channels = "sampled", 1

    def __init__(self, value, log=(), rate_hz=1000.0):
        self._value, self._log, self.rate_hz = value, log, rate_hz

    def facts(self):
        return {}

    def open(self):
        self.zero_s, self._n_read = time.perf_counter(), 0

    def receive(self):
        time.sleep(STEP_S)
        n_due = int((time.perf_counter() - self.zero_s) * self.rate_hz)
        times_s = np.arange(self._n_read, n_due) / self.rate_hz
        self._n_read = n_due
        samples = [(self.zero_s + time_s, self._value(time_s)) for time_s in times_s.tolist()]
        known = np.array([sample for sample in samples if sample[1] is not None], dtype=float).reshape(-1, 2)
        return SampleBlock(known[:, 0], known[:, 1:]) if len(known) else None

    def close(self):
        if isinstance(self._log, list):
            self._log.append("sensor.close")


def force_sensor(force_n, log=()):
    """Return a force sensor whose force (N) is a function of time (s)."""
    return streamed_force(Reader(Sampled(force_n, log)), 0, ForceCalibration(newtons_per_count=1.0))


class Passing:
    """Passes everything on to `wrapped`, for subclasses that change one method."""

    def __init__(self, wrapped):
        self.wrapped = wrapped

    def __getattr__(self, name):
        return getattr(self.wrapped, name)
