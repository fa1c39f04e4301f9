"""Ramps, checks and look-up of a signal before an output plays it."""

import io

import catalogue
import numpy as np
import pytest
from hypothesis import given, strategies as st
from hypothesis.extra.numpy import arrays

from tactometry.devices.outputs.file import FileSettings, read_signal
from tactometry.devices.outputs.gain import Gain
from tactometry.devices.outputs.guarded import Guarded
from tactometry.devices.outputs.output import NullOutput, with_ramps
from tactometry.errors import DeviceFailed, InvalidParameter, LimitExceeded
from tactometry.observers.finger import SimulatedFinger
from tactometry.rigs.bench import Bench
from tactometry.rigs.console import Console
from tactometry.rigs.device_rig import Equipment
from tactometry.rigs.emitter import Emitter
from tactometry.rigs.pages.page import Display
from tactometry.rigs.simulated import SimulatedRig
from tactometry.rigs.texts import texts_in
from tactometry.safety.limits import Limits
from tactometry.session.request import Play
from tactometry.signal import Signal

RATE_HZ = 1000.0
samples = arrays(np.float64, st.tuples(st.integers(1, 3), st.integers(1, 60)), elements=st.floats(-100, 100))


@given(samples, st.just(0.0) | st.floats(1e-18, 0.05))
def test_ramps_only_attenuate_and_end_at_zero(values, ramp_s):
    signal = Signal(values, RATE_HZ, "V")
    ramped = with_ramps(signal, ramp_s)
    assert ramped.samples.shape == signal.samples.shape
    assert np.all(np.abs(ramped.samples) <= np.abs(signal.samples))
    if ramped is not signal:
        assert not np.any(ramped.samples[:, [0, -1]])


@given(samples)
def test_ramps_leave_signals_with_zero_ends_unchanged(values):
    values[:, [0, -1]] = 0.0
    signal = Signal(values, RATE_HZ, "V")
    assert with_ramps(signal, 0.01) is signal


def test_ramps_leave_the_middle_unchanged():
    ramped = with_ramps(Signal(np.ones((1, 100)), RATE_HZ, "V"), 0.01).samples[0]
    assert np.array_equal(ramped[10:-10], np.ones(80))
    assert np.allclose(ramped[:10], np.sin(np.pi / 2 * np.arange(10) / 10) ** 2)
    assert np.array_equal(ramped, ramped[::-1])


@pytest.mark.parametrize("ramp_s", [-1.0, float("nan"), float("inf")])
def test_ramps_require_finite_duration(ramp_s):
    with pytest.raises(InvalidParameter, match=r"with_ramps\.ramp_s: found .*expected"):
        with_ramps(ONE_VOLT, ramp_s)


ONE_VOLT = Signal(np.ones((2, 10)), RATE_HZ, "V")


@pytest.mark.parametrize(
    ("driver", "limits", "error", "message"),
    [
        (NullOutput(), None, LimitExceeded, "output 'null': found no limits, .*nothing was played"),
        (NullOutput(), Limits(0.9), LimitExceeded, "nothing was played"),
        (NullOutput(n_channels=1), Limits(2.0), DeviceFailed, "with n_channels 2, expected 1; .*nothing was"),
        (NullOutput(rate_hz=500.0), Limits(2.0), DeviceFailed, "with rate_hz 1000, expected 500; state this rate_hz"),
        (NullOutput(n_channels=3), Limits(2.0), DeviceFailed, "with n_channels 2, expected 3; name one output channel"),
        (NullOutput(rate_hz=2000.0), Limits(2.0), DeviceFailed, "with rate_hz 1000, expected 2000; .*nothing was"),
    ],
)
def test_guard_refuses_signals_the_output_cannot_play(driver, limits, error, message):
    with pytest.raises(error, match=message):
        Guarded(driver, limits).check(ONE_VOLT)


class Steps:
    """A stimulus that neither begins nor ends at zero."""

    unit = "V"

    def at(self, level):
        return Signal(np.full((1, 100), level), RATE_HZ, "V")


def test_emitter_applies_ramps(tmp_path):
    output = Guarded(FileSettings(str(tmp_path)).driver(Gain(1.0, 1.0)), Limits(2.0))
    emitter = Emitter({"steps": Steps()}, output, None, ramp_s=0.01)
    output.open()
    emitter.emit(emitter.final("steps", 1.0))
    emitted = read_signal(tmp_path / "0001.npz").samples
    assert np.array_equal(emitted, with_ramps(Steps().at(1.0), 0.01).samples)
    assert not emitted[:, [0, -1]].any()


BANK = {"tone": catalogue.AnyStimulus()["any"]}
TIGHT = Limits(1e-6)


def bench(limits):
    output = Guarded(NullOutput(), Limits(1000.0))
    return Bench(Display(), Equipment(output, BANK, limits), texts_in("en", {}))


def console(limits):
    return Console(catalogue.silent(BANK, limits), texts_in("en", {}), io.StringIO(), io.StringIO())


def simulated(limits):
    return SimulatedRig(
        BANK, limits, sensation=None, observer=None, finger=SimulatedFinger(), rng_of=lambda n: None, decisions={}
    )


@pytest.mark.parametrize("rig_with", [bench, console, simulated])
def test_every_rig_suggests_nearest_stimulus_name(rig_with):
    with pytest.raises(InvalidParameter, match="stimulus: found 'tome', expected one of tone; did you mean 'tone'?"):
        rig_with(Limits(1000.0)).answer(Play("tome", 20.0, 1.0))


@pytest.mark.parametrize("rig_with", [bench, console, simulated])
def test_every_rig_enforces_study_limits(rig_with):
    with pytest.raises(LimitExceeded, match=r"limits\.voltage_peak_v: .*nothing was played"):
        rig_with(TIGHT).answer(Play("tone", 20.0, 1.0))
