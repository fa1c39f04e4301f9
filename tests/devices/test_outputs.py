"""Outputs without a card: guard, files and NI task settings."""

import importlib.util
import inspect
import threading
from dataclasses import dataclass
from datetime import date
from unittest.mock import call, create_autospec

import numpy as np
import pytest
from hard_cases import exact_case
from hypothesis import given, strategies as st
from hypothesis.extra.numpy import arrays
from packed_bits import RATE_HZ, volts
from set_clock import Clock

from tactometry.devices.outputs.file import FileSettings, read_signal
from tactometry.devices.outputs.gain import Gain
from tactometry.devices.outputs.guarded import Guarded
from tactometry.devices.outputs.ni import NiSettings, connector_v, start_task
from tactometry.devices.outputs.output import Driver
from tactometry.devices.outputs.packed import PackedSettings
from tactometry.errors import DeviceFailed, InvalidParameter, LimitExceeded
from tactometry.safety.limits import Limits
from tactometry.safety.load import Load
from tactometry.signal import Signal

FINGER = Load("electrode", capacitance_f=1e-9, leak_resistance_ohm=1e7)
ONE = Gain(1.0, 1.0)
LIMITS = Limits(50.0, 60.0, current_peak_a=1e-4, duty=0.5, duty_window_s=1.0, session_s=10.0)

samples = arrays(np.float64, st.tuples(st.integers(1, 3), st.integers(1, 60)), elements=st.floats(-100, 100))
gains = st.builds(Gain, st.floats(0.01, 20), st.floats(0.1, 200))


@dataclass
class SixteenBits(Driver):
    """Driver with a gain and 16 bits that emits into a list."""

    gain: Gain = ONE
    connected: bool = True
    name: str = "sixteen bits"

    def __post_init__(self):
        self.emitted = []

    @property
    def full_scale_v(self):
        return self.gain.load_volts_per_unit

    def open(self):
        self.emitted.append("open")

    def final(self, signal):
        return self.gain.to_volts(np.trunc(self.gain.to_units(signal) * 32767) / 32767, signal.rate_hz)

    def play(self, signal):
        self.emitted.append(self.final(signal))
        return 0.0

    def stop(self):
        self.emitted.append("stop")

    def close(self):
        self.emitted.append("close")


# --- the guard


@given(samples, gains, st.floats(0.5, 100), st.floats(1e-7, 1e-3))
def test_amplified_signal_is_within_limits_at_any_gain(values, gain, voltage_peak_v, current_peak_a):
    driver = SixteenBits(gain)
    limits = Limits(voltage_peak_v, 60.0, current_peak_a=current_peak_a, duty=1.0, session_s=1e9)
    try:
        Guarded(driver, limits, FINGER).play(volts(values))
    except (LimitExceeded, DeviceFailed):
        assert driver.emitted == []
        return
    (emitted,) = driver.emitted
    assert emitted.peak <= voltage_peak_v * (1 + 1e-9)
    assert emitted.peak <= gain.load_volts_per_unit * (1 + 1e-9)
    exact_case("any signal behind any gain", against="every limit")
    steps_v = np.abs(np.diff(np.pad(emitted.samples, ((0, 0), (1, 1))), axis=1))
    assert np.all(1e-9 * RATE_HZ * steps_v <= (current_peak_a + emitted.peak / 1e7) * (1 + 1e-9))


@pytest.mark.parametrize(
    ("current_peak_a", "asked_v", "message"),
    [(1.0, 30.0, r"voltage_peak_v: found a peak of 60 V, the limit is 50 V"), (2e-5, 15.0, "current_peak_a: found a")],
)
def test_guard_checks_the_samples_of_the_converter(current_peak_a, asked_v, message):
    driver = SixteenBits()
    driver.final = lambda signal: Signal(2 * signal.samples, signal.rate_hz, "V")
    guard = Guarded(driver, Limits(50.0, 60.0, current_peak_a=current_peak_a, duty=1.0, session_s=1e9), FINGER)
    with pytest.raises(LimitExceeded, match=rf"limits\.{message}.*nothing was played"):
        guard.play(volts([[asked_v]]))
    assert driver.emitted == []


def test_guard_checks_each_signal_independently():
    guard = Guarded(
        SixteenBits(Gain(100.0, 1.0)), Limits(50.0, 60.0, current_peak_a=3e-5, duty=1.0, session_s=1e9), FINGER
    )
    guard.play(volts([[0.0, 10.0, 20.0, 10.0, 0.0]]))
    with pytest.raises(LimitExceeded, match=r"limits\.current_peak_a"):
        guard.play(volts([[0.0, 20.0, -20.0, 20.0, 0.0]]))


def test_full_scale_and_supply_allow_rounding_errors_only(tmp_path):
    assert Gain(10.0, 1.0).to_units(volts([[10.0 * (1 + 5e-13)]])).max() == 1.0
    with pytest.raises(DeviceFailed, match="found a peak of 10.005 V, expected at most 10 V"):
        Gain(10.0, 1.0).to_units(volts([[10.005]]))
    board = PackedSettings(str(tmp_path / "board"), n_channels=1, rate_hz=RATE_HZ).driver(Gain(30.0, 1.0))
    assert board.final(volts([[30.0 * (1 + 1e-10)]])).peak == 30.0
    with pytest.raises(DeviceFailed, match="found a signal of 30.0003 V, expected the 30 V of the supply"):
        board.final(volts([[30.0003]]))


@given(samples, gains)
def test_driver_refuses_signals_above_its_full_scale(values, gain):
    driver, signal = SixteenBits(gain), volts(values)
    if signal.peak > gain.load_volts_per_unit * (1 + 1e-9):
        with pytest.raises(DeviceFailed, match="the range of the device and its amplifier.*nothing was played"):
            driver.final(signal)
    elif signal.peak <= gain.load_volts_per_unit:
        assert np.all(np.abs(driver.final(signal).samples) <= np.abs(signal.samples) * (1 + 1e-12))


@pytest.mark.parametrize(
    ("limits", "load", "message"),
    [
        (None, FINGER, "found no limits, expected limits for the connected load"),
        (Limits(1.0), FINGER, "limits: found no current_peak_a or charge_peak_c, no duration_s, no duty"),
        (LIMITS, None, "found no load, expected kind and capacitance_f"),
    ],
)
def test_device_is_not_opened_without_stated_limits(limits, load, message):
    driver = SixteenBits()
    for what in (Guarded(driver, limits, load).open, lambda: Guarded(driver, limits, load).play(volts([[0.0]]))):
        with pytest.raises(LimitExceeded, match=f"{message}.*nothing was played"):
            what()
    assert driver.emitted == []


def test_duty_and_session_count_stopped_signals():
    """The session begins when its output is opened."""
    driver, clock = SixteenBits(Gain(50.0, 1.0)), Clock()
    output = Guarded(driver, LIMITS, FINGER, clock)
    clock.now_s = 100.0
    output.open()
    half = volts(np.zeros((1, 400)))
    output.play(half)
    clock.now_s = 100.5
    with pytest.raises(LimitExceeded, match="limits.duty: found signals during 0.8"):
        output.play(half)
    clock.now_s = 100.05
    output.stop()
    clock.now_s = 100.5
    output.play(half)
    clock.now_s = 109.7
    with pytest.raises(LimitExceeded, match="limits.session_s: found a session of 10.1 s"):
        output.play(half)
    assert driver.emitted.count("open") == 1


# --- calibrations


@pytest.mark.parametrize(
    ("measured", "message"),
    [
        (Gain(1.0, 1.0, date(2026, 1, 1), "A", 30), "of 2026-01-01, 59 days old, expected at most 30"),
        (Gain(1.0, 1.0, date(2026, 2, 28), "A", 0), "of 2026-02-28, 1 day old, expected at most 0"),
        (Gain(1.0, 1.0, date(2027, 1, 1), "A", 30), "which is in the future, expected a date up to 2026-"),
        (Gain(1.0, 1.0, None, "A", 30), "found max_age_days without measured_on"),
    ],
)
def test_outdated_gain_is_a_failed_device(measured, message):
    with pytest.raises(DeviceFailed, match=f"^output.gain: .*{message}.*nothing was played"):
        measured.check_age("output.gain", date(2026, 3, 1))
    Gain(1.0, 1.0, date(2026, 1, 1), "A", 59).check_age("output.gain", date(2026, 3, 1))


# --- files


@pytest.mark.parametrize("form", ["npz", "wav"])
@given(values=samples)
def test_file_contains_exactly_the_played_signal(tmp_path_factory, form, values):
    folder = tmp_path_factory.mktemp("played")
    for sign in (1, -1):
        output = FileSettings(str(folder), form).driver(Gain(1.0, 1.0))
        output.open()
        output.play(volts(sign * values))
    assert [path.name for path in sorted(folder.iterdir())] == [f"0001.{form}", f"0002.{form}"]
    assert read_signal(folder / f"0001.{form}").digest() == volts(values).digest()
    assert read_signal(folder / f"0002.{form}").digest() == volts(-values).digest()


def test_wav_file_refuses_fractional_rates(tmp_path):
    output = FileSettings(str(tmp_path), "wav").driver(Gain(1.0, 1.0))
    with pytest.raises(DeviceFailed, match="found a rate of 0.5 Hz, expected a whole number for WAV"):
        output.final(Signal(np.zeros((1, 2)), 0.5, "V"))


def test_files_are_numbered_and_never_overwritten(tmp_path):
    folder = tmp_path / "new" / "played"
    output = FileSettings(str(folder)).driver(Gain(1.0, 1.0))
    output.open()
    for voltage_v in (1.0, 2.0):
        output.play(Signal(np.array([[voltage_v]]), 44_100.5, "V"))
    assert [read_signal(path).peak for path in sorted(folder.iterdir())] == [1.0, 2.0]
    assert output.facts() == {"n_files": 2}
    (folder / "0003.npz").write_bytes(b"another's")
    with pytest.raises(DeviceFailed, match=r"0003\.npz: cannot write \(File exists\), expected a new file"):
        output.play(volts([[3.0]]))
    assert (folder / "0003.npz").read_bytes() == b"another's"


def test_read_signal_names_an_invalid_file(tmp_path):
    (tmp_path / "x.npz").write_bytes(b"no archive")
    np.savez(tmp_path / "y.npz", rate_hz=1.0)
    for name in ("x.npz", "y.npz"):
        with pytest.raises(InvalidParameter, match=f"{name}: cannot be read as a signal"):
            read_signal(tmp_path / name)


# --- NI: settings and calls against the signatures of the library; not tested on a device

NI = NiSettings(("Dev1/ao0", "Dev1/ao1"), RATE_HZ, range_v=10.0, idle_at_zero=True, onboard_memory=True)


@given(arrays(np.float64, (2, 30), elements=st.floats(-200, 200)))
def test_ni_task_ends_at_zero_within_its_range(values):
    played_v = connector_v(NI, Gain(10.0, 20.0), volts(values))
    assert played_v.shape == (2, 31)
    assert not np.any(played_v[:, -1])
    assert np.allclose(played_v[:, :-1] * 20.0, values, rtol=1e-12)
    assert np.all(np.abs(played_v) <= NI.range_v)


def test_ni_refuses_voltages_beyond_its_range():
    with pytest.raises(DeviceFailed, match="found 9 V at the connector, expected at most the range of 5 V"):
        connector_v(NiSettings(("a",), 1e3, range_v=5.0), Gain(10.0, 20.0), volts([[180.0]]))


needs_nidaqmx = pytest.mark.skipif(importlib.util.find_spec("nidaqmx") is None, reason="no nidaqmx: extra ni")


@pytest.fixture
def task(monkeypatch):
    """Mock task with the library's signatures."""
    import nidaqmx

    made = create_autospec(nidaqmx.Task, instance=True)
    made.ao_channels = create_autospec(nidaqmx.task.collections.AOChannelCollection, instance=True)
    made.timing = create_autospec(nidaqmx.task.Timing, instance=True)
    made.__enter__.return_value = made
    monkeypatch.setattr(nidaqmx, "Task", lambda: made)
    return made


@needs_nidaqmx
def test_ni_stop_ends_task_then_writes_zeros(task):
    output = NI.driver(Gain(10.0, 20.0))
    output.open()
    output.play(volts([[1.0, 2.0], [3.0, 4.0]]))
    task.reset_mock()
    output.stop()
    told = [(name, args) for name, args, _ in task.method_calls if name in ("close", "write")]
    assert told == [("close", ()), ("write", ([0.0, 0.0],))]
    output.stop()
    assert task.close.call_count == 1


@needs_nidaqmx
def test_ni_stop_returns_when_driver_hangs(task):
    hangs, output = threading.Event(), NI.driver(Gain(10.0, 20.0))
    output.open()
    output.play(volts([[1.0, 2.0], [3.0, 4.0]]))
    task.close.side_effect = hangs.wait
    with pytest.raises(DeviceFailed, match="^ni Dev1/ao0,Dev1/ao1: it hangs and did not end within 0.1 s: switch its"):
        output.stop()
    hangs.set()


@needs_nidaqmx
def test_closed_ni_output_plays_nothing(task):
    output = NI.driver(Gain(10.0, 20.0))
    for leave in (lambda: None, output.close):
        leave()
        with pytest.raises(DeviceFailed, match="found a closed output, expected an open one; nothing was played"):
            output.play(volts([[1.0], [2.0]]))
        assert not task.start.called
        output.open()
    output.play(volts([[1.0], [2.0]]))
    assert task.start.call_count == 1


@needs_nidaqmx
def test_ni_calls_fit_the_library_signatures(task):
    import nidaqmx
    from nidaqmx.constants import AcquisitionType, AOIdleOutputBehavior

    start_task(connector_v(NI, Gain(10.0, 20.0), volts([[1.0, 2.0], [3.0, 4.0]])), NI)
    timing = task.timing.cfg_samp_clk_timing.call_args.kwargs
    assert timing == {"rate": RATE_HZ, "sample_mode": AcquisitionType.FINITE, "samps_per_chan": 3}
    assert inspect.signature(nidaqmx.task.Timing.cfg_samp_clk_timing).parameters.keys() >= timing.keys()
    added = task.ao_channels.add_ao_voltage_chan
    assert added.call_args == call("Dev1/ao0,Dev1/ao1", min_val=-10.0, max_val=10.0)
    channel = added.return_value
    assert channel.ao_idle_output_behavior == AOIdleOutputBehavior.ZERO_VOLTS
    assert channel.ao_use_only_on_brd_mem is True
    assert not np.any(task.write.call_args.args[0][:, -1])
    assert [name for name, _, _ in task.method_calls if name in ("write", "start")] == ["write", "start"]


@needs_nidaqmx
def test_missing_ni_driver_is_reported():
    with pytest.raises(DeviceFailed, match="NI-DAQmx refused .*nothing was played"):
        NI.driver(Gain(1.0, 1.0)).open()
