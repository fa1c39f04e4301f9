"""Waveforms: their samples, exact pieces, frequencies of force, and carriers by the width of pulses."""

import numpy as np
import pytest
from felt_models import felt_by
from hypothesis import given, strategies as st

from tactometry.contact import Contact
from tactometry.errors import LimitExceeded
from tactometry.stimuli.electrovibration import (
    AmplitudeModulated,
    PulseTrain,
    Sine,
    Skin,
    Square,
    Step,
    Trapezoid,
    Triangle,
    electrostatic_force_n,
)
from tactometry.stimuli.electrovibration.attraction.offset import WithOffset
from tactometry.stimuli.electrovibration.sensation import ElectrovibrationSensation
from tactometry.stimuli.electrovibration.waveforms.amplitude_modulated import of_supply
from tactometry.stimuli.electrovibration.waveforms.pieces import Pieces, straight
from tactometry.stimuli.electrovibration.waveforms.sampled import Sampled
from tactometry.stimuli.electrovibration.waveforms.waveform import Waveform
from tactometry.stimuli.perception.detection import components

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


SUPPLY_V = 100.0


def pulsed(**fields):
    return of_supply(AmplitudeModulated(**{"frequency_hz": 120.0, "duration_s": 0.2, **fields}), 250e3, SUPPLY_V)


@given(st.floats(26.0, 42.0), st.floats(20.0, 400.0), st.sampled_from(["square_root", "full", "suppressed_carrier"]))
def test_pulsed_carrier_energy_error_is_below_half_sample(level, frequency_hz, modulation):
    stimulus = pulsed(frequency_hz=frequency_hz, modulation=modulation)
    requested, made = stimulus.waveform.at(level).samples[0], stimulus.at(level).samples[0]
    assert set(np.unique(made)) == {-SUPPLY_V, 0.0, SUPPLY_V}
    zeros = np.flatnonzero(np.diff(np.sign(requested)))
    ahead = np.cumsum(made**2 - requested**2)[zeros] / SUPPLY_V**2
    assert np.abs(ahead).max() <= 0.5 + 1e-6
    assert np.all(made * requested >= 0)


@pytest.mark.parametrize("level", [28.0, 34.0, 36.0, 40.0])
def test_it_feels_as_the_carrier_does(level):
    """Within 0.6 dB: steep flanks lose less through the skin than a sine does."""
    stimulus, model, contact = pulsed(duration_s=0.5), felt_by(ElectrovibrationSensation()), Contact(1.0, 0.05)
    asked_db, made_db = (model.sensation_db(each.at(level), contact) for each in (stimulus.waveform, stimulus))
    assert made_db == pytest.approx(asked_db, abs=0.6)


def test_levels_above_supply_are_refused_with_fix():
    assert (pulsed().level_unit, pulsed().duration_s) == ("dB re 1 V", 0.2)
    with pytest.raises(
        LimitExceeded, match="found an effective voltage of 141.. V, above the 100 V of the supply; low"
    ):
        pulsed().at(46.0)
    with pytest.raises(LimitExceeded, match="level: found 9.998 V, expected at least 17.89 V, which pulses of 1 s"):
        pulsed(ramp_s=0.0).at(20.0)


RAMPED = [
    Sine(frequency_hz=60.0, phase_rad=0.3),
    Square(frequency_hz=60.0),
    Square(frequency_hz=60.0, duty=0.3),
    AmplitudeModulated(frequency_hz=60.0),
    AmplitudeModulated(frequency_hz=60.0, modulation="full"),
    AmplitudeModulated(frequency_hz=60.0, modulation="suppressed_carrier"),
    *(
        PulseTrain(frequency_hz=60.0, width_s=2e-3, polarity=p)
        for p in ("positive", "negative", "biphasic", "alternating")
    ),
    WithOffset(Sine(frequency_hz=60.0), ratio=0.5),
    WithOffset(Square(frequency_hz=60.0), ratio=-2.0),
]
PLAIN = [
    Triangle(frequency_hz=60.0, ramp_s=0.0),
    Trapezoid(rise_s=1e-3, high_s=4e-3, fall_s=2e-3, low_s=5e-3),
    Trapezoid(rise_s=0.0, high_s=4e-3, fall_s=2e-3, low_s=0.0, low_ratio=-1.0),
    Sampled((0.0, 1.0, -3.0, 2.0, 0.0), rate_hz=100.0),
    WithOffset(Triangle(frequency_hz=60.0, ramp_s=0.0), ratio=0.2),
    WithOffset(Step(onset_s=0.1, duration_s=0.5), ratio=0.2),
]
STEPS = [Step(duration_s=0.5), Step(onset_s=0.1, rise_s=0.05, fall_s=0.2, duration_s=0.5)]


def away_from_jumps(waveform: Waveform, pieces: Pieces) -> np.ndarray:
    """Sample times further than 1e-9 s from every start of a piece."""
    rate_hz = waveform.at(0.0).rate_hz
    t_s = np.arange(waveform.at(0.0).samples.shape[1]) / rate_hz
    return t_s[np.abs(t_s[:, None] - pieces.starts_s[None, :]).min(axis=1) > 1e-9]


@pytest.mark.parametrize("waveform", [*RAMPED, *PLAIN, *STEPS])
def test_the_exact_voltage_equals_the_samples(waveform: Waveform) -> None:
    pieces, signal = waveform.pieces(20.0), waveform.at(20.0)
    t_s = away_from_jumps(waveform, pieces)
    samples = signal.samples[0, np.round(t_s * signal.rate_hz).astype(int)]
    # The samples' ramp off mirrors the one on: it ends on the last sample, half a sample before the
    # exact end.
    tolerance_v = 10.0 * np.pi / 2 / signal.rate_hz / 0.05 if waveform in RAMPED else 1e-9
    early = t_s < signal.duration_s - 0.05
    np.testing.assert_allclose(pieces.at(t_s)[early], samples[early], rtol=0, atol=1e-8)
    np.testing.assert_allclose(pieces.at(t_s), samples, rtol=0, atol=tolerance_v)


@pytest.mark.parametrize("waveform", [*RAMPED, *PLAIN, *STEPS])
def test_neither_samples_nor_exact_voltage_pass_the_peak(waveform: Waveform) -> None:
    assert waveform.at(20.0).peak <= 10.0
    pieces = waveform.pieces(20.0)
    dense_s = np.linspace(0, pieces.end_s, 100_003)
    assert 9.0 <= np.abs(pieces.at(dense_s)).max() <= 10.0 * (1 + 1e-12)


@pytest.mark.parametrize("waveform", RAMPED)
def test_force_frequency_is_lowest_line_of_force(waveform: Waveform) -> None:
    lossless = isinstance(waveform, WithOffset)
    skin = Skin(corneum_resistivity_ohm_m=np.inf if lossless else 2e4)
    assert lowest_force_hz(waveform, skin) == pytest.approx(waveform.force_frequency_hz, abs=1.1)


def lowest_force_hz(waveform: Waveform, skin: Skin) -> float:
    signal = waveform.at(0.0)
    force_n = electrostatic_force_n(signal.samples[0], rate_hz=signal.rate_hz, skin=skin, area_m2=1e-4, law="sc_layer")
    parts = components(force_n, signal.rate_hz)
    return float(parts.frequencies_hz[parts.amplitudes > 0.05 * parts.amplitudes.max()].min())


@pytest.mark.parametrize(
    ("waveform", "ratio", "force_hz"),
    [
        (Sine(frequency_hz=60.0), 0.0, 120.0),
        (Sine(frequency_hz=60.0), 0.5, 60.0),
        (AmplitudeModulated(frequency_hz=240.0), 0.5, 240.0),
        (Square(frequency_hz=60.0), -1.0, 60.0),
        (Step(duration_s=0.5), 0.5, 0.0),
    ],
)
def test_offset_adds_voltage_frequency_to_force(waveform: Waveform, ratio: float, force_hz: float) -> None:
    assert WithOffset(waveform, ratio).force_frequency_hz == force_hz


@pytest.mark.parametrize("frequency_hz", [5.0, 10.0, 60.0])
@pytest.mark.parametrize("duration_s", [0.47, 0.5])
@pytest.mark.parametrize("ratio", [0.0, 0.5])
def test_a_ramp_is_a_raised_cosine_of_any_length(frequency_hz: float, duration_s: float, ratio: float) -> None:
    tone = WithOffset(Sine(frequency_hz=frequency_hz, duration_s=duration_s, ramp_s=0.05, phase_rad=0.4), ratio)
    t_s = np.linspace(0, duration_s, 1001)
    ramp = np.sin(np.pi / 2 * np.clip(np.minimum(t_s, duration_s - t_s) / 0.05, 0, 1)) ** 2
    plain_v = 10 * (np.sin(2 * np.pi * frequency_hz * t_s + 0.4) + ratio) / (1 + ratio)
    np.testing.assert_allclose(tone.pieces(20.0).at(t_s), ramp * plain_v, rtol=0, atol=1e-12)


def test_after_its_end_a_voltage_stays() -> None:
    pieces = Sine(frequency_hz=60.0, duration_s=0.104, ramp_s=0.0).pieces(20.0)
    assert pieces.at(0.104) != 0
    np.testing.assert_array_equal(pieces.at([0.105, 3.0]), pieces.at(0.104))


def test_offset_samples_never_exceed_peak() -> None:
    tone = Sine(frequency_hz=50.0, rate_hz=1000.0, duration_s=0.1, ramp_s=0.0, phase_rad=np.pi / 2)
    levels = (20.0, 13.0, 7.3, 40.0)
    peaks = [(WithOffset(tone, r).at(x).peak, 10 ** (x / 20)) for r in np.linspace(-3, 3, 121) for x in levels]
    assert all(found <= highest for found, highest in peaks)


@pytest.mark.parametrize("frequency_hz", [0.3, 60.0, 123.0])
@pytest.mark.parametrize("duty", [0.1, 0.3, 0.5, 0.9])
def test_all_periods_of_a_square_have_the_same_samples(frequency_hz: float, duty: float) -> None:
    square = Square(frequency_hz, duration_s=50 / frequency_hz, ramp_s=0.0, rate_hz=20 * frequency_hz, duty=duty)
    n_high = round(20 * duty)
    expected = np.tile(np.r_[np.ones(n_high), -np.ones(20 - n_high)], 50)
    np.testing.assert_array_equal(square.at(0.0).samples[0], expected)


SHORT = {"rate_hz": 192_000.0, "ramp_s": 0.0, "duration_s": 0.1}


@pytest.mark.parametrize(
    "waveform",
    [
        Square(frequency_hz=1234.5, band_limited=True, **SHORT),
        Triangle(frequency_hz=1234.5, band_limited=True, **SHORT),
        PulseTrain(frequency_hz=1234.5, width_s=1e-4, band_limited=True, **SHORT),
    ],
)
def test_band_limited_waveform_contains_harmonics_only(waveform: Square) -> None:
    assert highest_between_harmonics(waveform) < 1e-5
    assert waveform.at(0.0).peak <= 1.0


def test_the_plain_square_does_alias() -> None:
    assert highest_between_harmonics(Square(frequency_hz=1234.5, **SHORT)) > 1e-4


def highest_between_harmonics(waveform: Square) -> float:
    signal = waveform.at(0.0)
    window = np.blackman(signal.samples.shape[1])
    spectrum = np.abs(np.fft.rfft(signal.samples[0] * window)) / window.sum()
    f_hz = np.fft.rfftfreq(signal.samples.shape[1], 1 / signal.rate_hz)
    distance_hz = np.abs(f_hz - 1234.5 * np.round(f_hz / 1234.5))
    return float(spectrum[distance_hz > 300].max())


@pytest.mark.parametrize("waveform", [Square(frequency_hz=1.0, duty=0.3), Triangle(frequency_hz=1.0)])
def test_fourier_coefficients_equal_the_integral(waveform: Square | Triangle) -> None:
    n = 200_000
    phase = (np.arange(n) + 0.5) / n
    integral = [np.mean(waveform.corners.at(phase) * np.exp(-2j * np.pi * k * phase)) for k in (1, 2, 5)]
    np.testing.assert_allclose(waveform.corners.harmonics([1, 2, 5]), integral, atol=1e-8)


def test_symmetric_trapezoid_doubles_force_frequency() -> None:
    both = Trapezoid(rise_s=1e-3, high_s=4e-3, fall_s=1e-3, low_s=4e-3, low_ratio=-1.0)
    one = Trapezoid(rise_s=1e-3, high_s=4e-3, fall_s=1e-3, low_s=4e-3)
    assert (both.voltage_frequency_hz, both.force_frequency_hz) == pytest.approx((100.0, 200.0))
    almost = Trapezoid(rise_s=1e-3, high_s=4e-3, fall_s=1e-3, low_s=4e-3, low_ratio=-0.95)
    assert one.force_frequency_hz == almost.force_frequency_hz == pytest.approx(100.0)


def test_zero_length_line_is_jump_and_pieces_split() -> None:
    pieces = straight([0, 1, 1, 3], [0, 2, -1, 1])
    dense = np.linspace(0, 3, 31)
    np.testing.assert_allclose(pieces.split_at([0.3, 1.0, 2.2, 9.0]).at(dense), pieces.at(dense), atol=1e-15)
    assert pieces.jumps_v().tolist() == [0.0, -3.0]


def test_alternating_pulses_change_sign_at_pulse_frequency() -> None:
    train = PulseTrain(frequency_hz=50.0, width_s=1e-3, duration_s=0.1, ramp_s=0.0, polarity="alternating")
    samples = train.at(0.0).samples[0]
    starts = np.flatnonzero(np.diff(np.abs(samples), prepend=0) > 0)
    assert starts.tolist() == [0, 400, 800, 1200, 1600]
    assert samples[starts].tolist() == [1.0, -1.0, 1.0, -1.0, 1.0]
    assert (train.voltage_frequency_hz, train.force_frequency_hz) == (25.0, 50.0)


def test_a_step_falls_before_its_end() -> None:
    samples = Step(fall_s=0.2, duration_s=0.4, rate_hz=10.0).at(20.0).samples[0]
    np.testing.assert_allclose(samples, [10.0, 10.0, 10.0, 5.0])
