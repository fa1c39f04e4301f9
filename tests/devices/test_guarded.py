"""The guard of a driver: reports, refusals, peaks between samples, and closing."""

from pathlib import Path

import numpy as np
import pytest
from packed_bits import RATE_HZ, volts as volts_of
from set_clock import Clock

from tactometry.devices.outputs.audio import AudioSettings
from tactometry.devices.outputs.emission_ledger import Ledger
from tactometry.devices.outputs.file import FileSettings
from tactometry.devices.outputs.gain import Gain
from tactometry.devices.outputs.guarded import Guarded
from tactometry.devices.outputs.ni import NiSettings
from tactometry.devices.outputs.output import NullOutput, NullSettings
from tactometry.devices.outputs.packed import PackedSettings
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
def reported(clock):
    """Guard without a load, with a list of its reports."""
    output, found = Guarded(Clipping(), LIMITS, clock=clock), []
    output.subscribe(lambda *emission: found.append(emission[1:]), found.append)
    output.open()
    return output, found


def volts(volt=10.0, duration_s=1.0):
    return Signal(np.full((1, round(1e3 * duration_s)), volt), 1e3, "V")


def test_signal_without_a_load_passes_no_charge(reported):
    output, found = reported
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


def test_guard_refuses_signal_that_driver_would_clip(reported):
    output, _ = reported
    with pytest.raises(LimitExceeded, match="voltage_peak_v"):
        output.play(volts(101.0))


def test_closed_guard_keeps_no_file_open(tmp_path):
    output = Guarded(Clipping(), LIMITS, ledger=Ledger(tmp_path / "outputs.sqlite3"))
    output.open()
    output.play(volts())
    output.close()
    held = [str(each.readlink()) for each in Path("/proc/self/fd").iterdir() if each.is_symlink()]
    assert not any(name.startswith(str(tmp_path)) for name in held)


FINGER = Load("electrode", capacitance_f=1e-9, leak_resistance_ohm=1e7)
TIGHT = Limits(50.0, 60.0, current_peak_a=1.0, duty=1.0, session_s=1e9)
QUARTER_RATE = 50.0 * np.sqrt(2) * np.sin(np.pi / 2 * np.arange(4000) + np.pi / 4) * np.hanning(4000)
"""Its samples reach 50 V, and its course between them 70.7 V."""
CARD = Gain(10.0, 10.0)


@pytest.mark.parametrize(
    ("settings", "refused"),
    [
        (AudioSettings(RATE_HZ, "card"), True),
        (NiSettings(("Dev1/ao0",), RATE_HZ), True),
        (NiSettings(("Dev1/ao0",), RATE_HZ, reconstruction_filter=False), False),
        (FileSettings("folder"), False),
        (NullSettings(), False),
    ],
)
def test_guard_refuses_peaks_between_samples_of_a_filter(settings, refused):
    driver = settings.driver(CARD)
    guard = Guarded(driver, TIGHT, FINGER)
    if not refused:
        guard.check(volts_of(QUARTER_RATE[None]))
        return
    with pytest.raises(
        LimitExceeded, match=r"voltage_peak_v: found between two samples.*70\.71.* V, the limit is 50 V"
    ):
        guard.check(volts_of(QUARTER_RATE[None]))


def test_one_bit_output_has_no_peaks_between_samples(tmp_path):
    bits = np.where(np.random.default_rng(0).random((1, 500)) < 0.5, 50.0, -50.0)
    board = PackedSettings(str(tmp_path / "board"), 1, RATE_HZ).driver(Gain(50.0, 1.0))
    Guarded(board, TIGHT, FINGER).check(volts_of(bits))
    card = AudioSettings(RATE_HZ, "card").driver(CARD)
    with pytest.raises(LimitExceeded, match="between two samples"):
        Guarded(card, TIGHT, FINGER).check(volts_of(bits))
