"""Current and charge of a load, against values computed by hand."""

import math

import numpy as np
import pytest

from tactometry.errors import InvalidParameter
from tactometry.safety.load import Load
from tactometry.signal import Signal

LEAKY = Load("electrode", capacitance_f=1e-9, leak_resistance_ohm=1e6)


def volts(*samples, rate_hz=1.0):
    return Signal(np.array([samples], dtype=float), rate_hz, "V")


def test_current_adds_slope_and_leak():
    """0.1 mA charge 1 nF by 100 V in 1 ms, and 0.1 mA pass 1 Mohm."""
    assert LEAKY.current_peak_a(volts(0.0, 100.0, 100.0, rate_hz=1e3)) == pytest.approx(0.2e-3)


def test_current_of_a_weakened_signal_adds_its_rise():
    """A rise by 100 V within 10 ms draws 10 uA more in 1 nF."""
    signal = volts(0.0, 100.0, 100.0, rate_hz=1e3)
    assert LEAKY.current_peak_a(signal, rise_s=0.01) == pytest.approx(0.21e-3)


def test_charge_of_a_weakened_signal_has_one_sign():
    """1 nF stores 0.1 uC. Four triangles of 50 V s pass 0.2 mC."""
    assert LEAKY.charge_peak_c(volts(100.0, 0.0, -100.0), rise_s=0.01) == pytest.approx(1e-7 + 2e-4)


@pytest.mark.parametrize(
    ("samples", "after_s", "late_s", "passed_uc"),
    [
        ((100.0, 0.0), 0.0, 0.0, 50.0),  # the line from zero to the first sample
        ((100.0, 100.0, 0.0, -100.0, -100.0), 4.0, 0.0, 50.0),  # 200 - 150
        ((100.0, 100.0, 0.0, -100.0, -100.0), 2.0, 2.0, 350.0),  # the charge after a stop may have any sign
        ((100.0, -100.0), 0.5, 0.0, 100.0),  # 50 up to the sample before, and 50 to the one after
        ((100.0, 100.0), -5.0, 0.0, 50.0),
        ((100.0, 100.0), 50.0, 0.0, 200.0),
    ],
)
def test_stopped_charge_equals_that_of_the_samples(samples, after_s, late_s, passed_uc):
    assert 1e6 * LEAKY.passed_c(volts(*samples)).stopped_c(after_s, late_s) == pytest.approx(passed_uc)


def test_charge_has_a_value_for_each_straight_piece():
    charge = LEAKY.passed_c(volts(1.0, 2.0))
    assert charge.passed_c.shape == charge.absolute_c.shape == (1, 3)


@pytest.mark.parametrize(("leak_ohm", "fine"), [(0.5, True), (0.0, False), (-1.0, False), (math.nan, False)])
def test_leak_is_above_zero(leak_ohm, fine):
    if fine:
        assert Load("electrode", 1e-9, leak_ohm).leak_resistance_ohm == leak_ohm
    else:
        with pytest.raises(InvalidParameter, match="leak_resistance_ohm"):
            Load("electrode", 1e-9, leak_ohm)
