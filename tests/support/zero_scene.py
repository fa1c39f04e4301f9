"""A bench that notes when its output falls to zero."""

import threading
from dataclasses import dataclass

import numpy as np
import player
from emulated import wait_for
from sampled import Passing, Sampled
from sound_server import heard_part

from tactometry.devices.outputs.guarded import Guarded
from tactometry.devices.outputs.output import with_ramps
from tactometry.devices.sensors.reader import Reader
from tactometry.devices.sensors.streamed import ForceCalibration, streamed_force
from tactometry.rigs.bench import Bench
from tactometry.rigs.device_rig import Equipment
from tactometry.rigs.emitter import RAMP_S
from tactometry.rigs.texts import texts_in
from tactometry.safety.limits import Limits
from tactometry.safety.load import Load
from tactometry.session.request import Press

RATE_HZ = 48_000.0

PRESS = Press("noise", 1.0, 20.0, target_n=1.0, tolerance=0.2, hold_s=0.1, timeout_s=30.0)


class Noting(Passing):
    n_given = None

    def _note(self):
        if self.n_given is None and self.wrapped._feed is not None:
            self.n_given = self.wrapped._feed._at

    def stop(self):
        """Stop, then note it: the device may request blocks in between."""
        self.wrapped.stop()
        self._note()

    def close(self):
        self._note()
        self.wrapped.close()


class Scene:
    """A touch of a 20 s noise, ended by `happens` once the sink hears it."""

    def __init__(self, watched, driver, sink):
        self.sink, self.driver, self.force_n, self.ended = sink, driver, 1.0, threading.Event()
        self.screen = Failing(watched)
        self.source = Sampled(self.felt)
        sensor = streamed_force(Reader(self.source), 0, ForceCalibration(newtons_per_count=1.0))
        output = Guarded(driver, LIMITS, Load("electrode", 1e-9))
        bank, texts = {"noise": Noise(20.0), "short": Noise(0.5)}, texts_in("en", {})
        self.bench = Bench(self.screen, Equipment(output, bank, sensor=sensor, release=False), texts)

    def felt(self, time_s):
        del time_s
        return self.force_n

    def when_heard(self, happens, *args):
        """Call a function when the sink hears the touch, unless it has ended."""
        wait_for(lambda: self.ended.is_set() or self.sink.heard() > 2 * N_HEARD)
        if not self.ended.is_set():
            happens(*args)

    def heard(self, stimulus="noise"):
        frames = self.sink.end()
        assert not frames[-4800:].any()
        heard = heard_part(frames)
        if self.driver.facts()["n_underruns"]:
            return np.count_nonzero(heard.any(axis=1))
        final = self.bench._emitter._output.check(with_ramps(self.bench._emitter._bank[stimulus].at(1.0), RAMP_S))[1]
        wanted = np.round(final.samples.T / 50.0 * 32767).astype("<i2")
        wanted = wanted[np.flatnonzero(wanted.any(axis=1))[0] :]
        n_whole = max(0, len(heard) - 48)
        assert np.array_equal(heard[:n_whole], wanted[:n_whole])
        return len(heard)


N_HEARD = 4800

LIMITS = Limits(voltage_peak_v=200.0, current_peak_a=1.0, duty=1.0, session_s=600.0, duration_s=30.0, stop_within_s=0.5)


@dataclass(frozen=True)
class Noise:
    duration_s: float
    unit = "V"

    def at(self, level):
        del level
        return player.noise(2, RATE_HZ, self.duration_s)


class Failing(Passing):
    def __init__(self, screen):
        super().__init__(screen)
        self.fails = threading.Event()

    def refresh(self, page):
        if self.fails.is_set():
            raise BadError
        return self.wrapped.refresh(page)


class BadError(Exception):
    pass
