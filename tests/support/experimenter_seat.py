"""A windowed bench whose experimenter uses a real pseudo-terminal."""

import os
import select
import time
from contextlib import suppress

import pytest
from kept_events import Kept
from patience import LONGEST_WAIT_S
from sampled import force_sensor

from tactometry.rigs.bench import Bench
from tactometry.rigs.device_rig import Equipment
from tactometry.rigs.experimenter.terminal import ExperimenterTerminal
from tactometry.rigs.texts import texts_in
from tactometry.session.request import Choose, Press, Record, Wait
from tactometry.stimuli.electrovibration import Sine
from tactometry.trials.trial import Trial

TONE = Sine(frequency_hz=60.0, duration_s=0.3, ramp_s=0.02, level_unit="V")
BLIP = Sine(frequency_hz=60.0, duration_s=0.1, ramp_s=0.02, level_unit="V")
PRESS = Press("tone", 5.0, 0.3, target_n=1.0, tolerance=0.2, hold_s=0.1, timeout_s=20.0)
FELT = Choose("felt", (0, 1), ("no", "yes"))
ROW = Record(Trial(2, 7, {}, "staircase", 5.0, "V", "yes_no", 1))


class Terminal:
    """Both ends of a pseudo-terminal, for the console and the experimenter."""

    def __init__(self):
        self._master, slave = os.openpty()
        self._file = os.fdopen(slave, "r+b", buffering=0)
        self.source, self.output = open(slave, closefd=False), open(slave, "w", closefd=False)  # noqa: SIM115
        self.desk = ExperimenterTerminal(self.source, self.output)
        self._seen = b""

    def types(self, line):
        os.write(self._master, line.encode() + b"\n")

    def sees(self, words):
        while select.select([self._master], [], [], 0)[0]:
            self._seen += os.read(self._master, 4096)
        return words.encode() in self._seen

    def shows(self, words):
        """Wait until the terminal has shown these words."""
        end_s = time.monotonic() + LONGEST_WAIT_S
        while not self.sees(words):
            assert time.monotonic() < end_s, self._seen
            time.sleep(0.005)

    def goes_away(self):
        os.close(self._master)
        self._master = None

    def close(self):
        if self._master is not None:
            self.goes_away()
        for file in (self.source, self.output, self._file):
            with suppress(OSError):
                file.close()


@pytest.fixture
def bench_of(watched, output, log):
    """A function that makes benches, with a force over time (s) and other equipment; they close with the test."""
    rigs = []

    def make(force_n=None, output=output, screen=watched, *, kept=None, terminal=None, tone=TONE, **more):
        sensor = None if force_n is None else force_sensor(force_n, log)
        equipment = Equipment(output, {"tone": tone}, **{"sensor": sensor, "release": False, **more})
        rigs.append(Bench(screen, equipment, texts_in("en", {}), log=kept, terminal=terminal))
        return rigs[-1]

    yield make
    for rig in rigs:
        rig.close()


@pytest.fixture
def bench(bench_of):
    return bench_of(tone=BLIP, release=True)


@pytest.fixture
def terminal():
    made = Terminal()
    yield made
    made.close()


@pytest.fixture
def kept():
    return Kept()


@pytest.fixture
def bench_with(terminal, kept, bench_of):
    return lambda force_n=None: bench_of(force_n, kept=kept, terminal=terminal.desk)


def waits_until(bench, seen):
    end_s = time.monotonic() + LONGEST_WAIT_S
    while not seen():
        assert time.monotonic() < end_s
        bench.answer(Wait(0.1))
