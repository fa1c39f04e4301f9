"""Force-gated touches with a sensor at 1 kHz and a window.

These tests must pass on a machine of any speed; `benchmarks/force_loop.py` measures the speed of the decision.
"""

import time

import numpy as np
import pytest
from emulated import Emulator, available, wait_for
from sampled import Passing

from tactometry.devices.sensors.counted_samples import SLEW
from tactometry.devices.sensors.streamed import ForceCalibration, streamed_force
from tactometry.gates import ForceGate
from tactometry.rigs.bench import Bench
from tactometry.rigs.device_rig import Equipment
from tactometry.rigs.texts import texts_in
from tactometry.session.request import Press
from tactometry.stimuli.electrovibration import Sine

TONE = Sine(frequency_hz=60.0, duration_s=0.05, ramp_s=0.01, level_unit="V")
PRESS = Press("tone", 5.0, 0.1, target_n=1.0, tolerance=0.2, hold_s=0.2, timeout_s=10.0)
APPROACH = "0.25:30,0.15:100,0.05:200,0.5:100"
"""Light; held too shortly; an excursion; held long enough. In counts of 0.01 N."""
GAPPED = "0.25:30,0.15:100,0.03:-,0.37:100"

pytestmark = pytest.mark.skipif(not available("serial"), reason="no pyserial: extra serial")


class Busy(Passing):
    def __init__(self, screen, work_s):
        super().__init__(screen)
        self._work_s = work_s

    def refresh(self, page):
        end_s = time.perf_counter() + self._work_s
        while time.perf_counter() < end_s:
            sum(range(50))
        return self.wrapped.refresh(page)


class Noting(Passing):
    def __init__(self, output):
        super().__init__(output)
        self.last, self.decided_from = None, []

    def hear(self, block):
        self.last = int(block.values[-1, 0]) if len(block.values) else self.last

    def play(self, signal):
        self.decided_from.append(self.last)
        return self.wrapped.play(signal)


class Loop:
    """Bench with a serial force sensor and a record of all its samples."""

    def __init__(self, device, screen, output):
        self.device, self.output = device, Noting(output)
        self.everything = []
        device.reader.subscribe(self.everything.append)
        device.reader.subscribe(self.output.hear)
        sensor = streamed_force(device.reader, 2, ForceCalibration(newtons_per_count=0.01))
        equipment = Equipment(self.output, {"tone": TONE}, sensor=sensor, release=False)
        self.bench = Bench(screen, equipment, texts_in("en", {}))
        wait_for(lambda: device.reader.facts()["n_samples"] > 0)

    def press(self, request=PRESS):
        touched = self.bench.answer(request)
        return touched, touched.onset_s + self.bench._supervisor.zero_s

    def truth(self):
        """Return the sampling times (s) and forces (N) according to the source.

        Its clock is the local one, in microseconds modulo 2**31.
        """
        values, now_s = np.concatenate([block.values for block in list(self.everything)]), time.perf_counter()
        ages_s = (now_s * 1e6 - values[:, 1]) % 2**31 * 1e-6
        return values[:, 0], now_s - ages_s, values[:, 2] * 0.01


def held(times_s, forces_n):
    """Return for each true sample whether a gate is open after it."""
    gate, found = ForceGate(PRESS.target_n, PRESS.tolerance, PRESS.hold_s * (1 - SLEW)), []
    for time_s, force_n in zip(times_s, forces_n, strict=True):
        gate = gate.after(time_s, force_n)
        found.append(gate.open)
    return np.array(found)


@pytest.fixture
def loop_of(watched, output, tmp_path):
    made = []

    def make(profile, work_s=0.0):
        device = Emulator("serial", tmp_path, profile=profile)
        made.append(device)
        made.append(loop := Loop(device, Busy(watched, work_s), output))
        return loop

    yield make
    for each in made:
        each.bench.close() if isinstance(each, Loop) else each.close()


@pytest.mark.parametrize("work_s", [0.0, 0.008], ids=["idle", "busy for 8 ms a frame"])
@pytest.mark.parametrize("profile", [APPROACH, GAPPED], ids=["excursion", "gap of 30 ms"])
def test_gate_never_opens_early_and_loses_no_samples(loop_of, log, profile, work_s):
    """The force was held in the samples received at the decision.

    On a machine so busy that the sensor is away for a while, the samples of that while are missing.
    """
    loop = loop_of(profile, work_s)
    touches = [loop.press() for _ in range(3)]
    counters, times_s, forces_n = loop.truth()
    assert np.all(np.diff(counters) == 1) or loop.device.reader.facts()["n_outages"]
    decided = np.searchsorted(counters, loop.output.decided_from)
    assert len(decided) == 3
    assert np.all(held(times_s, forces_n)[decided])
    for (touched, onset_s), last in zip(touches, decided, strict=True):
        assert touched.digest == TONE.at(5.0).digest()
        assert onset_s >= times_s[last]
    assert log.count("play 5 V") == 3
