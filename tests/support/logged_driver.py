"""An output whose calls are logged in a list."""

import time

from tactometry.devices.outputs.output import Driver


class LoggedDriver(Driver):
    name, n_channels, rate_hz, full_scale_v, connected = "list", 1, 20_000.0, 50.0, False

    def __init__(self, log):
        self._log = log

    def final(self, signal):
        return signal

    def open(self):
        self._log.append("output.open")

    def play(self, signal):
        self._log.append(f"play {signal.peak:.3g} V")
        return time.perf_counter()

    def stop(self):
        self._log.append("output.stop")

    def close(self):
        self._log.append("output.close")
