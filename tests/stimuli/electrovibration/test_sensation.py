"""Sensation levels of samples: model thresholds, contact and cache."""

from dataclasses import replace

import numpy as np
import pytest
from felt_models import felt_by
from scene_cases import effect
from scipy.optimize import brentq

from tactometry.contact import Contact
from tactometry.experiments.study.felt_scene import FeltScene
from tactometry.signal import Signal
from tactometry.stimuli.composition.effect import FingerContact
from tactometry.stimuli.electrovibration import (
    AmplitudeModulated,
    CoulombFriction,
    ElectrovibrationSensation,
    Sine,
    Skin,
)
from tactometry.stimuli.electrovibration.attraction.contact_area import PowerLawArea
from tactometry.stimuli.electrovibration.motion.friction_lag import FrictionLag
from tactometry.stimuli.scenes.scene import Scene
from tactometry.stimuli.scenes.stages.record import recorded
from tactometry.stimuli.scenes.surfaces.electrovibration import Electrovibration

MODEL = felt_by(ElectrovibrationSensation())
LAW = effect("force_law", law="sc_layer")
NO_LAG = felt_by(ElectrovibrationSensation(lag=None))
TOUCH = Contact(force_n=1.5, speed_m_per_s=0.05)
OCTAVES_HZ = [15, 30, 60, 120, 240, 480, 960, 1920]


def threshold_db(stimulus: Sine | AmplitudeModulated, model: FeltScene, touch: Contact = TOUCH) -> float:
    return float(brentq(lambda level: model.sensation_db(stimulus.at(level), touch), -20, 120, xtol=1e-6))


def sine(frequency_hz: float) -> Sine:
    return Sine(frequency_hz=frequency_hz)


def carrier(frequency_hz: float) -> AmplitudeModulated:
    return AmplitudeModulated(frequency_hz=frequency_hz, carrier_hz=8_000.0, rate_hz=64_000.0)


def threshold_force_n(frequency_hz: float) -> float:
    """Return the friction amplitude at threshold.

    Written out: the threshold of Meissner or Pacini, then the pulp as a phasor.
    """
    meissner_db, pacini_db = 28 - 5 * np.log2(frequency_hz / 3), -20 + 12 * abs(np.log2(250 / frequency_hz))
    skin_m = 1e-6 * 10 ** ((min(meissner_db, pacini_db) if frequency_hz <= 100 else pacini_db) / 20)
    omega = 2 * np.pi * frequency_hz
    return float(skin_m * abs(1000.0 + 1.5j * omega - 0.15e-3 * omega**2))


@pytest.mark.parametrize("frequency_hz", OCTAVES_HZ[:5])
def test_thresholds_of_sines_are_those_of_the_displaced_skin(frequency_hz: int) -> None:
    """The force has twice the frequency; a leaky corneum passes w tau."""
    omega_tau = 2 * np.pi * frequency_hz * 315.209086e-6
    high_pass = omega_tau / np.hypot(1, omega_tau)
    of_one_volt_n = 0.5 * (1e-4 * 1.5 ** (1 / 3)) * 1.10677348e-1 * (0.438202247 * high_pass) ** 2 / 2
    expected_db = 10 * np.log10(threshold_force_n(2 * frequency_hz) / of_one_volt_n)
    assert threshold_db(sine(frequency_hz), NO_LAG) == pytest.approx(expected_db, abs=0.05)


@pytest.mark.parametrize("frequency_hz", OCTAVES_HZ[1:6])
def test_thresholds_of_carriers_are_those_of_the_displaced_skin(frequency_hz: int) -> None:
    """Relative to 240 Hz, with the carrier far above any leakage."""
    found_db = threshold_db(carrier(frequency_hz), NO_LAG) - threshold_db(carrier(240.0), NO_LAG)
    expected_db = 10 * np.log10(threshold_force_n(frequency_hz) / threshold_force_n(240.0))
    assert found_db == pytest.approx(expected_db, abs=0.05)


@pytest.mark.parametrize("frequency_hz", [960.0, 1920.0])
def test_vibration_outside_all_channels_is_not_felt(frequency_hz: float) -> None:
    assert MODEL.sensation_db(carrier(frequency_hz).at(46.0), TOUCH) < -60


@pytest.mark.parametrize("corner_hz", [500.0, 1000.0])
@pytest.mark.parametrize(("kind", "best_hz"), [(sine, 120), (carrier, 240)])
def test_the_best_frequency_stays_with_a_lag(kind, best_hz: int, corner_hz: float) -> None:
    model = felt_by(ElectrovibrationSensation(lag=FrictionLag(slope_hz_per_m_per_s=0.0, floor_hz=corner_hz)))
    thresholds_db = [threshold_db(kind(f), model) for f in OCTAVES_HZ[1:5]]
    assert OCTAVES_HZ[1:5][int(np.argmin(thresholds_db))] == best_hz


def test_reference_force_applies_at_250_hz() -> None:
    by_force = felt_by(ElectrovibrationSensation(reference_force_n=threshold_force_n(250.0)))
    signal = carrier(120.0).at(40.0)
    assert by_force.sensation_db(signal, TOUCH) == pytest.approx(MODEL.sensation_db(signal, TOUCH), abs=1e-9)


@pytest.mark.parametrize(
    ("law", "voltage_v"), [("parallel_plate", 1.05), ("interface", 0.89), ("total_thickness", 19.8), ("sc_layer", 30.8)]
)
def test_each_force_law_has_its_own_threshold_voltage(law: str, voltage_v: float) -> None:
    """The values are those in docs/reference/electrovibration.md."""
    found_db = threshold_db(AmplitudeModulated(frequency_hz=240.0), felt_by(ElectrovibrationSensation(law=law)))
    assert 10 ** (found_db / 20) == pytest.approx(voltage_v, rel=0.01)


@pytest.mark.parametrize("force_n", [0.5, 1.5, 3.0])
def test_all_carriers_of_the_study_stay_below_200_volt(force_n: float) -> None:
    touch = Contact(force_n, 0.05)
    levels_db = [
        threshold_db(AmplitudeModulated(frequency_hz=f), MODEL, touch) for f in (30, 60, 120, 180, 240, 320, 480)
    ]
    assert max(levels_db) < 20 * np.log10(200)
    assert int(np.argmin(levels_db)) == 4


def test_some_sines_of_the_study_lie_above_200_volt() -> None:
    assert threshold_db(sine(60.0), MODEL) > 20 * np.log10(200) > threshold_db(sine(120.0), MODEL)


@pytest.mark.parametrize(("criterion", "expected_db"), [("absolute", -2.0069), ("fraction", 4.0137)])
def test_threshold_against_force_by_either_criterion(criterion: str, expected_db: float) -> None:
    stimulus = AmplitudeModulated(frequency_hz=240.0)
    model = felt_by(ElectrovibrationSensation(criterion=criterion))
    high_db, low_db = (threshold_db(stimulus, model, Contact(force_n, 0.05)) for force_n in (2.0, 0.5))
    assert high_db - low_db == pytest.approx(expected_db, abs=5e-4)


@pytest.mark.parametrize("touch", [Contact(1.5, 0.0), Contact(0.0, 0.05), Contact(0.0, 0.0)])
def test_sensation_is_absent_at_rest_or_without_contact(touch: Contact) -> None:
    assert MODEL.sensation_db(sine(120.0).at(40.0), touch) == -np.inf


@pytest.mark.parametrize("model", [MODEL, NO_LAG])
def test_sensation_goes_smoothly_to_nothing_at_rest(model) -> None:
    """Sensation is proportional to speed far below the slip speed."""
    speeds_m_per_s = np.geomspace(1e-12, 1e-5, 8)
    signal = sine(120.0).at(40.0)
    levels_db = np.array([model.sensation_db(signal, Contact(1.5, speed)) for speed in speeds_m_per_s])
    assert np.diff(levels_db) == pytest.approx(20.0, abs=1e-3)
    assert levels_db[0] < -100


@pytest.mark.parametrize("speed_m_per_s", [1e-4, 0.05])
@pytest.mark.parametrize(("frequency_hz", "ramp_s"), [(30.0, 0.02), (60.0, 0.05), (120.0, 0.05), (240.0, 0.05)])
def test_short_ramped_tone_matches_its_scene(frequency_hz, ramp_s, speed_m_per_s) -> None:
    tone = {"frequency_hz": frequency_hz, "duration_s": 0.1, "ramp_s": ramp_s, "carrier_hz": 2000.0}
    signal = AmplitudeModulated(**tone, rate_hz=64e3).at(30.0)
    carrier_effect = effect("carrier", carrier_hz=tone.pop("carrier_hz"))
    felt = carrier_effect, LAW, effect("contact_area"), effect("friction"), effect("sensitivity")
    touch = FingerContact(1.5, speed_m_per_s)
    scene = Scene(Electrovibration(**tone), felt, ("sensation_db",), 1e-3, (touch,))
    by_scene_db = scene.resolve().run({"level_db_re_1v": 30.0})["sensation_db"]
    lossless = felt_by(ElectrovibrationSensation(lag=None, skin=Skin(corneum_resistivity_ohm_m=float("inf"))))
    assert lossless.sensation_db(signal, Contact(1.5, speed_m_per_s)) == pytest.approx(by_scene_db, abs=0.1)


@pytest.mark.parametrize("frequency_hz", [6_000.0, 9_900.0])
def test_fast_sine_force_does_not_alias(frequency_hz: float) -> None:
    coarse, fine = (Sine(frequency_hz=frequency_hz, rate_hz=rate_hz).at(40.0) for rate_hz in (20e3, 200e3))
    assert MODEL.sensation_db(coarse, TOUCH) < 0
    assert MODEL.sensation_db(fine, TOUCH) < 0


@pytest.mark.parametrize("n_more", [0, 1])
@pytest.mark.parametrize("carrier_hz", [2_000.0, 7_000.0, 9_700.0])
def test_carrier_sensation_is_independent_of_rate(carrier_hz: float, n_more: int) -> None:
    duration_s, tone = 1.0 + n_more / 20e3, AmplitudeModulated(frequency_hz=240.0, modulation="full")
    levels_db = [
        MODEL.sensation_db(replace(tone, carrier_hz=carrier_hz, rate_hz=r, duration_s=duration_s).at(20.0), TOUCH)
        for r in (20e3, 200e3)
    ]
    assert levels_db[0] == pytest.approx(levels_db[1], abs=0.1)


def test_weak_fast_tone_does_not_alias() -> None:
    t_s = [np.arange(round(rate_hz)) / rate_hz for rate_hz in (20e3, 200e3)]
    volts = [40 * np.sin(2 * np.pi * 3_000 * t) + 4 * np.sin(2 * np.pi * 9_875 * t) for t in t_s]
    coarse, fine = (Signal(v[None, :], v.size, "V") for v in volts)
    assert max(MODEL.sensation_db(coarse, TOUCH), MODEL.sensation_db(fine, TOUCH)) < -100


def test_silence_is_not_felt() -> None:
    assert MODEL.sensation_db(Signal(np.zeros((1, 1000)), 20e3, "V"), TOUCH) == -np.inf


def test_sensation_is_independent_of_call_order() -> None:
    levels_db = np.linspace(0, 40, 7)
    touches = [Contact(f, v) for f in (0.5, 3.0) for v in (0.02, 0.1)]
    once = {(x, t): MODEL.sensation_db(carrier(120.0).at(x), t) for x in levels_db for t in touches}
    again = {(x, t): MODEL.sensation_db(carrier(120.0).at(x), t) for t in touches[::-1] for x in levels_db[::-1]}
    assert once == again


def test_body_resistance_makes_area_dependence_nonlinear() -> None:
    touches = [Contact(0.5, 0.05), Contact(3.0, 0.05)]
    shifts_db = [
        np.diff([model.sensation_db(carrier(240.0).at(20.0), touch) for touch in touches])[0]
        for model in (NO_LAG, felt_by(ElectrovibrationSensation(skin=Skin(body_resistance_ohm=2e4), lag=None)))
    ]
    assert shifts_db[0] == pytest.approx(20 / 3 * np.log10(6), abs=1e-9)
    assert shifts_db[1] < shifts_db[0] - 0.5


def test_friction_and_area_act_as_factors() -> None:
    signal = carrier(240.0).at(20.0)
    rough = felt_by(ElectrovibrationSensation(friction=CoulombFriction(1.0)))
    wide = felt_by(ElectrovibrationSensation(area=PowerLawArea(area_at_1n_m2=2e-4)))
    for model in (rough, wide):
        gain_db = model.sensation_db(signal, TOUCH) - MODEL.sensation_db(signal, TOUCH)
        assert gain_db == pytest.approx(20 * np.log10(2), abs=1e-9)


def test_lag_at_240_hz_with_a_corner_of_500_hz() -> None:
    lag = FrictionLag(slope_hz_per_m_per_s=0.0, floor_hz=500.0)
    assert float(lag.gain(240.0, 0.05)) == pytest.approx(0.901523, abs=5e-7)


def test_corner_rises_by_1104_hz_from_20_to_100_mm_per_s() -> None:
    lag = FrictionLag()
    assert lag.cutoff_hz(0.1) - lag.cutoff_hz(0.02) == pytest.approx(1104.0)


@pytest.mark.parametrize("n", [8, 9, 400, 401])
def test_doubled_rate_keeps_original_samples(n: int) -> None:
    voltage_v = np.random.default_rng(n).normal(size=n)
    finer = recorded(Signal(voltage_v[None], 20e3, "V"), share=1e-4)
    found_v, rate_hz = finer.voltage_v, finer.rate_hz
    assert (found_v.size, rate_hz) == (2 * n, 40e3)
    np.testing.assert_allclose(found_v[::2], voltage_v, atol=1e-12)
