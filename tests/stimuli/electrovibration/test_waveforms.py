"""Sine and amplitude-modulated carrier: levels, ramps, frequencies, clear errors."""

import numpy as np
import pytest

from tactometry.stimuli.electrovibration import AmplitudeModulated, Sine

STIMULI = [
    Sine(frequency_hz=60.0),
    Sine(frequency_hz=333.3, ramp_s=0.0, phase_rad=1.0, duration_s=0.01),
    *(AmplitudeModulated(frequency_hz=60.0, modulation=m) for m in ("square_root", "full", "suppressed_carrier")),
]


@pytest.mark.parametrize("stimulus", STIMULI)
def test_a_signal_is_one_channel_of_volts(stimulus: Sine | AmplitudeModulated) -> None:
    signal = stimulus.at(20.0)
    assert stimulus.level_unit == "dB re 1 V"
    assert signal.samples.shape == (1, round(stimulus.duration_s * stimulus.rate_hz))
    assert (signal.rate_hz, signal.unit) == (stimulus.rate_hz, "V")


def test_a_level_in_volt_is_the_peak() -> None:
    assert Sine(frequency_hz=50.0, level_unit="V").at(7.0).peak == pytest.approx(7.0, rel=1e-12)


def test_ramps_are_raised_cosines_from_zero() -> None:
    stimulus = Sine(frequency_hz=5000.0, rate_hz=20_000.0, phase_rad=0.0)
    steady = Sine(frequency_hz=5000.0, rate_hz=20_000.0, phase_rad=0.0, ramp_s=0.0)
    ramped, plain = stimulus.at(0.0).samples[0], steady.at(0.0).samples[0]
    odd = np.arange(1, 1000, 2)
    np.testing.assert_allclose(ramped[odd] / plain[odd], np.sin(np.pi * odd / 2000) ** 2, atol=1e-9)
    np.testing.assert_array_equal(ramped[1000:19000], plain[1000:19000])
    assert ramped[0] == ramped[-1] == 0


@pytest.mark.parametrize(
    ("modulation", "expected"),
    [("square_root", [0.25, 0.25, 0.0]), ("full", [0.1875, 0.25, 0.0625]), ("suppressed_carrier", [0.25, 0.0, 0.25])],
)
def test_components_of_the_squared_carrier_below_its_frequency(modulation: str, expected: list[float]) -> None:
    stimulus = AmplitudeModulated(frequency_hz=100.0, modulation=modulation, ramp_s=0.0)
    spectrum = np.abs(np.fft.rfft(stimulus.at(0.0).samples[0] ** 2)) / 20_000
    found = spectrum[[0, 100, 200]] * [1, 2, 2]
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_components_of_a_squared_sine_with_and_without_offset() -> None:
    tone_v = Sine(frequency_hz=100.0, ramp_s=0.0).at(0.0).samples[0]
    for offset_v, expected in ((0.0, [0.5, 0.0, 0.5]), (0.5, [0.75, 1.0, 0.5])):
        spectrum = np.abs(np.fft.rfft((tone_v + offset_v) ** 2)) / tone_v.size
        np.testing.assert_allclose(spectrum[[0, 100, 200]] * [1, 2, 2], expected, atol=1e-12)
