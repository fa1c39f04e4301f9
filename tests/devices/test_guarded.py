"""The guard of a driver: reports, refusals and closing."""

from pathlib import Path

import numpy as np
import pytest
from set_clock import Clock

from tactometry.devices.outputs.emission_ledger import Ledger
from tactometry.devices.outputs.guarded import Guarded
from tactometry.devices.outputs.output import NullOutput
from tactometry.errors import LimitExceeded
from tactometry.safety.limits import Limits
from tactometry.safety.load import Load
from tactometry.signal import Signal

LIMITS = Limits(100.0, duration_s=10.0, current_peak_a=1.0, duty=1.0, session_s=1e6)
LEAKY = Load("electrode", capacitance_f=1e-9, leak_resistance_ohm=1e6)


class Clipping(NullOutput):
    emits = True

    def final(self, signal):
        return Signal(np.clip(signal.samples, -50.0, 50.0), signal.rate_hz, signal.unit)


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def told(clock):
    """Guard without a load, with a list of its reports."""
    output, found = Guarded(Clipping(), LIMITS, clock=clock), []
    output.subscribe(lambda *emission: found.append(emission[1:]), found.append)
    output.open()
    return output, found


def volts(volt=10.0, duration_s=1.0):
    return Signal(np.full((1, round(1e3 * duration_s)), volt), 1e3, "V")


def test_signal_without_a_load_passes_no_charge(told):
    output, found = told
    output.play(volts())
    output.stop()
    assert found == [(1.0, 0.0), 0.0]


def test_end_of_replaced_signal_is_reported_first(clock):
    ends_c = []
    output = Guarded(Clipping(), LIMITS, LEAKY, clock)
    output.subscribe(lambda *emission: None, ends_c.append)
    output.open()
    output.play(volts())
    clock.now_s += 0.5
    output.play(volts())
    assert ends_c == pytest.approx([5e-6], rel=0.1)  # 10 V through 1 Mohm for 0.5 s


class Interrupted(Clipping):
    error = KeyboardInterrupt

    def play(self, signal):
        raise self.error


@pytest.mark.parametrize("error", [KeyboardInterrupt, SystemExit])
def test_guard_counts_signal_when_play_is_interrupted(clock, error):
    driver, found = Interrupted(), []
    driver.error = error
    output = Guarded(driver, LIMITS, LEAKY, clock)
    output.subscribe(lambda *emission: found.append(emission[2]), found.append)
    output.open()
    with pytest.raises(error):
        output.play(volts())
    clock.now_s += 0.5
    output.stop()
    assert found == pytest.approx([1e-5, 5e-6], rel=0.1)  # 10 V through 1 Mohm: all of it, and 0.5 s


def test_guard_refuses_signal_that_driver_would_clip(told):
    output, _ = told
    with pytest.raises(LimitExceeded, match="voltage_peak_v"):
        output.play(volts(101.0))


def test_closed_guard_keeps_no_file_open(tmp_path):
    output = Guarded(Clipping(), LIMITS, ledger=Ledger(tmp_path / "outputs.sqlite3"))
    output.open()
    output.play(volts())
    output.close()
    held = [str(each.readlink()) for each in Path("/proc/self/fd").iterdir() if each.is_symlink()]
    assert not any(name.startswith(str(tmp_path)) for name in held)
