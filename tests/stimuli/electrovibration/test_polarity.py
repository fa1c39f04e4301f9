"""Polarity asymmetry of the force, off by default."""

import numpy as np
import pytest
from corneum_closed_form import corneum_voltage_v
from felt_models import felt_by
from hypothesis import given, strategies as st

from tactometry.contact import Contact
from tactometry.experiments.study.felt_scene import FeltScene
from tactometry.stimuli.electrovibration import ElectrovibrationSensation, PulseTrain, Skin, electrostatic_force_n
from tactometry.stimuli.electrovibration.attraction.force import LAWS, electrostatic_force_n_at
from tactometry.stimuli.electrovibration.attraction.polarity import Polarity

P0, AREA_M2, RATE_HZ = Skin(), 1e-4, 2e4
TOUCH = Contact(force_n=1.5, speed_m_per_s=0.05)


def pulses(polarity: str) -> PulseTrain:
    return PulseTrain(frequency_hz=120.0, width_s=1e-3, duration_s=0.5, polarity=polarity)


def force_n(voltage_v: np.ndarray, law: str = "sc_layer", **changes) -> np.ndarray:
    return electrostatic_force_n(voltage_v, rate_hz=RATE_HZ, skin=P0, area_m2=AREA_M2, law=law, **changes)


@pytest.mark.parametrize("law", LAWS)
def test_force_ignores_voltage_sign_by_default(law: str) -> None:
    voltage_v = pulses("positive").at(40.0).samples[0]
    np.testing.assert_array_equal(force_n(voltage_v, law), force_n(-voltage_v, law))
    np.testing.assert_array_equal(force_n(voltage_v, law, polarity=Polarity(1.0)), force_n(voltage_v, law))


@given(share=st.floats(0, 2))
def test_polarity_share_scales_positive_half_only(share: float) -> None:
    voltage_v = pulses("biphasic").at(40.0).samples[0]
    layer_v, plain_n = corneum_voltage_v(voltage_v, RATE_HZ, P0, AREA_M2), force_n(voltage_v)
    found_n = force_n(voltage_v, polarity=Polarity(share))
    assert (layer_v > 0).any()
    assert (layer_v < 0).any()
    np.testing.assert_array_equal(found_n[layer_v > 0], share * plain_n[layer_v > 0])
    np.testing.assert_array_equal(found_n[layer_v <= 0], plain_n[layer_v <= 0])


def test_samples_and_pieces_have_the_same_asymmetry() -> None:
    train = PulseTrain(frequency_hz=120.0, width_s=1e-3, duration_s=0.1, ramp_s=0.0, polarity="negative")
    t_s = np.linspace(0, 0.09, 1001)
    plain_n, found_n = (
        electrostatic_force_n_at(t_s, train.pieces(40.0), skin=P0, area_m2=AREA_M2, law="sc_layer", polarity=p)
        for p in (None, Polarity(0.25))
    )
    ratio = found_n[plain_n > 0] / plain_n[plain_n > 0]
    assert set(np.round(ratio, 12)) == {0.25, 1.0}


def test_positive_pulses_feel_weaker_when_polarity_is_set() -> None:
    def felt_db(polarity: str, model: FeltScene) -> float:
        return model.sensation_db(pulses(polarity).at(30.0), TOUCH)

    models = ElectrovibrationSensation(), ElectrovibrationSensation(polarity=Polarity(0.5))
    even, asymmetric = map(felt_by, models)
    assert felt_db("positive", even) == pytest.approx(felt_db("negative", even), abs=1e-9)
    positive_db, negative_db, biphasic_db = (felt_db(p, asymmetric) for p in ("positive", "negative", "biphasic"))
    assert positive_db < min(negative_db, biphasic_db) - 0.2
