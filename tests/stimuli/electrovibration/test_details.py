"""Details that mutation testing showed to be untested elsewhere."""

import numpy as np
import pytest

from tactometry.signal import Signal
from tactometry.stimuli.electrovibration import (
    CoulombFriction,
    Finger,
    Noise,
    PulseTrain,
    Sine,
    Skin,
    Step,
    Velvet,
    sliding,
    stick_slip,
)
from tactometry.stimuli.electrovibration.attraction.contact_area import PowerLawArea, TableArea
from tactometry.stimuli.electrovibration.attraction.force import force_form
from tactometry.stimuli.electrovibration.motion.dry_friction import DryFriction
from tactometry.stimuli.electrovibration.motion.stick_slip import Travel
from tactometry.stimuli.electrovibration.skin.relaxation import Relaxations
from tactometry.stimuli.electrovibration.textures.texture import Region
from tactometry.stimuli.electrovibration.waveforms.pieces import straight
from tactometry.stimuli.scenes.stages.record import recorded

AREA_M2, FINGER = 1e-4, Finger()


@pytest.mark.parametrize("gap_m", [1e-7, 5e-6])
def test_gap_skin_share_and_time_constant_match_stack(gap_m: float) -> None:
    skin = Skin(gap_m=gap_m)
    found = skin.relaxations(AREA_M2)
    assert found.gains[0] == pytest.approx(skin.k, rel=1e-13)
    assert 1 / found.rates_per_s[0] == pytest.approx(skin.tau_s, rel=1e-13)


def test_infinite_relaxation_rate_passes_no_sample() -> None:
    assert not Relaxations((1.0,), (np.inf,)).sampled(np.array([5.0, 1.0, -3.0]), 1e3).any()


def test_stuck_skin_accelerates_with_finger() -> None:
    motion = stick_slip(
        np.linspace(0, 0.1, 11), straight([0, 1.0], [0, 0]), force_form("sc_layer", Skin(), AREA_M2), finger=FINGER,
        friction=DryFriction(), force_n=100.0, travel=Travel(0.01, 0.3),
    )  # fmt: skip
    assert not motion.direction.any()
    np.testing.assert_array_equal(motion.stretch_m_per_s2, 0.3)


def test_area_table_starts_at_zero_force() -> None:
    table = TableArea((0.2, 1.5), (0.5e-4, 1.5e-4))
    np.testing.assert_allclose(table.area_m2([0.0, 0.1, 0.2]), [0.0, 0.25e-4, 0.5e-4], atol=1e-18)


def test_a_constant_area_is_none_without_force() -> None:
    np.testing.assert_array_equal(PowerLawArea(exponent=0.0).area_m2([0.0, 1.0]), [0.0, 1e-4])


def test_a_region_ends_at_both_of_its_edges() -> None:
    share = Region(0.01, 0.03).force_share([0.0, 0.01, 0.02, 0.03, 0.04])
    np.testing.assert_array_equal(share, [0.0, 1.0, 1.0, 0.0, 0.0])


def test_second_reversal_starts_from_current_pile() -> None:
    velvet = Velvet(with_pile=0.2, against_pile=1.0, tuft_depth=0.0, reversal_m=2e-3)
    path_m = np.r_[np.linspace(0, 0.05, 501), np.linspace(0.05, 0.049, 11)[1:], np.linspace(0.049, 0.06, 111)[1:]]
    share = velvet.force_share_along(path_m)
    turned = 1 - 0.8 * np.exp(-0.5)
    assert share[510] == pytest.approx(turned, rel=1e-9)
    np.testing.assert_allclose(share[511:], 0.2 + (turned - 0.2) * np.exp(-(path_m[511:] - 0.049) / 2e-3), rtol=1e-9)


def test_pause_does_not_turn_velvet_pile() -> None:
    back_m, velvet = np.linspace(0.05, 0.03, 201), Velvet(tuft_depth=0.0)
    path_m = np.r_[0.0, 0.05, back_m]
    waiting_m = np.r_[path_m[:50], np.full(7, path_m[49]), path_m[50:]]
    found = np.delete(velvet.force_share_along(waiting_m), np.s_[50:57])
    np.testing.assert_allclose(found, velvet.force_share_along(path_m), rtol=1e-14)


def test_noise_has_no_line_at_0() -> None:
    assert Noise.drawn(1e-9, 100.0, 0.1, rng=np.random.default_rng(1)).lines_per_m[0] == pytest.approx(10.0)


@pytest.mark.parametrize("n", [8, 9, 400, 401])
def test_doubled_rate_keeps_original_samples(n: int) -> None:
    voltage_v = np.random.default_rng(n).normal(size=n)
    finer = recorded(Signal(voltage_v[None], 20e3, "V"), share=1e-4)
    found_v, rate_hz = finer.voltage_v, finer.rate_hz
    assert (found_v.size, rate_hz) == (2 * n, 40e3)
    np.testing.assert_allclose(found_v[::2], voltage_v, atol=1e-12)


def test_alternating_pulses_change_sign_at_pulse_frequency() -> None:
    train = PulseTrain(frequency_hz=50.0, width_s=1e-3, duration_s=0.1, ramp_s=0.0, polarity="alternating")
    samples = train.at(0.0).samples[0]
    starts = np.flatnonzero(np.diff(np.abs(samples), prepend=0) > 0)
    assert starts.tolist() == [0, 400, 800, 1200, 1600]
    assert samples[starts].tolist() == [1.0, -1.0, 1.0, -1.0, 1.0]
    assert (train.voltage_frequency_hz, train.force_frequency_hz) == (25.0, 50.0)


def test_almost_uniform_times_are_not_treated_as_uniform() -> None:
    pieces, form = (
        Sine(frequency_hz=240.0, ramp_s=0.0, duration_s=0.05).pieces(40.0),
        force_form("interface", Skin(), AREA_M2),
    )
    even_s = np.linspace(0, 0.05, 51)[1:-1]
    jitter_s = even_s * (1 + 3e-5 * np.sin(np.arange(even_s.size)))

    def deflection_m(t_s: np.ndarray) -> np.ndarray:
        return sliding(t_s, pieces, form, finger=FINGER, friction=CoulombFriction(), force_n=0.01).deflection_m

    together = deflection_m(jitter_s)
    alone = [deflection_m(np.array([t_s]))[0] for t_s in jitter_s]
    np.testing.assert_allclose(together, alone, rtol=1e-11)


def test_a_step_falls_before_its_end() -> None:
    samples = Step(fall_s=0.2, duration_s=0.4, rate_hz=10.0).at(20.0).samples[0]
    np.testing.assert_allclose(samples, [10.0, 10.0, 10.0, 5.0])
