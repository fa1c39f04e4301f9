"""Claims about electrovibration, checked against force and motion."""

import re

import numpy as np
import pytest

from tactometry.stimuli.electrovibration import CoulombFriction, Finger, Layer, Sine, Skin, Step, sliding, stick_slip
from tactometry.stimuli.electrovibration.attraction.force import LAWS, electrostatic_force_n_at, force_form
from tactometry.stimuli.electrovibration.attraction.offset import WithOffset
from tactometry.stimuli.electrovibration.motion.dry_friction import DryFriction
from tactometry.stimuli.electrovibration.motion.friction_lag import FrictionLag, lagged_friction_n
from tactometry.stimuli.electrovibration.motion.stick_slip import Travel

P0, AREA_M2 = Skin(), 1e-4
FORM = force_form("sc_layer", P0, AREA_M2)
PIECES = Sine(frequency_hz=60.0, ramp_s=0.0, duration_s=0.1).pieces(40.0)
T_S = np.linspace(0, 0.1, 401)
TONE = WithOffset(Sine(frequency_hz=60.0), ratio=0.5)
SKINS = [
    P0,
    Skin(body_resistance_ohm=1e4),
    Skin(body_resistance_ohm=1e6),
    Skin(tissue=Layer(5e-3, 1e4, 2.0)),
    Skin(gap_m=2e-6, body_resistance_ohm=1e5),
]


def remarked_s(remark: str) -> float:
    found = re.search(r"\((\S+) ms\)", remark)
    assert found is not None
    return 1e-3 * float(found[1])


def force_after_a_step_n(skin: Skin, law: str, t_s) -> np.ndarray:
    pieces = Step(duration_s=100.0, rate_hz=10.0).pieces(40.0)
    return electrostatic_force_n_at(t_s, pieces, skin=skin, area_m2=AREA_M2, law=law)


@pytest.mark.parametrize("skin", SKINS)
def test_offset_force_vanishes_when_remark_says_blocked(skin: Skin) -> None:
    remark = TONE.remark(skin, "sc_layer", AREA_M2)
    assert remark is not None
    assert "leaves less than 1 % of the offset's force" in remark
    after_s = remarked_s(remark)
    peak_n = force_after_a_step_n(skin, "sc_layer", np.linspace(0, after_s, 5001)).max()
    left_n = force_after_a_step_n(skin, "sc_layer", after_s * np.array([1.0, 1.5, 3.0]))
    assert (left_n < 0.01 * peak_n).all()
    assert force_after_a_step_n(skin, "sc_layer", 0.2 * after_s) > 0.01 * peak_n


@pytest.mark.parametrize("skin", SKINS)
def test_offset_force_settles_when_remark_says_kept(skin: Skin) -> None:
    remark = TONE.remark(skin, "interface", AREA_M2)
    assert remark is not None
    assert "yields the offset's full force" in remark
    after_s = remarked_s(remark)
    t_s = after_s * np.array([0.0, 0.2, 1.0, 50.0])
    start_n, early_n, then_n, last_n = force_after_a_step_n(skin, "interface", np.minimum(t_s, 99.0))
    assert start_n < 0.95 * last_n
    assert early_n < then_n
    assert then_n == pytest.approx(last_n, rel=0.02)


@pytest.mark.parametrize("law", LAWS)
def test_constant_force_is_unchanged_without_remark(law: str) -> None:
    skin = P0 if law in ("total_thickness", "parallel_plate") else Skin(corneum_resistivity_ohm_m=np.inf)
    assert TONE.remark(skin, law) is None
    assert WithOffset(Sine(frequency_hz=60.0), ratio=0.0).remark(P0, law) is None
    first_n, last_n = force_after_a_step_n(skin, law, [1e-6, 50.0])
    assert first_n == pytest.approx(last_n, rel=1e-12)
    assert first_n > 0


def slid(friction: CoulombFriction, force_n: float):
    return sliding(T_S, PIECES, FORM, finger=Finger(), friction=friction, force_n=force_n)


def lagged_n(lag: FrictionLag, friction: CoulombFriction, force_n: float, speed_m_per_s: float = 0.05, t_s=T_S):
    return lagged_friction_n(
        t_s, PIECES, FORM, lag=lag, friction=friction, force_n=force_n, speed_m_per_s=speed_m_per_s
    )


@pytest.mark.parametrize("friction", [CoulombFriction(0.5), CoulombFriction(0.5, load_exponent=1.0)])
def test_unloaded_friction_is_limit_of_small_load(friction: CoulombFriction) -> None:
    np.testing.assert_allclose(slid(friction, 0.0).lateral_n, slid(friction, 1e-14).lateral_n, rtol=0, atol=1e-13)
    without_n, small_n = (lagged_n(FrictionLag(), friction, force_n) for force_n in (0.0, 1e-14))
    np.testing.assert_allclose(without_n, small_n, rtol=0, atol=1e-13)


def test_slip_friction_matches_coulomb_friction_without_load() -> None:
    stuck_or_slipping = stick_slip(
        T_S,
        PIECES,
        FORM,
        finger=Finger(),
        friction=DryFriction(0.5, 0.5, gated=False),
        force_n=0.0,
        travel=Travel(10.0),
    )
    slips = stuck_or_slipping.direction == 1
    assert slips.sum() > 100
    expected_n = slid(CoulombFriction(0.5), 0.0).lateral_n
    np.testing.assert_allclose(stuck_or_slipping.lateral_n[slips], expected_n[slips], rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize(("force_n", "mu"), [(0.5, 0.5 * 0.5**-0.3), (1.0, 0.5), (3.0, 0.5 * 3**-0.3)])
def test_the_coefficient_depends_on_the_load_in_every_friction(force_n: float, mu: float) -> None:
    friction = CoulombFriction(0.5, load_exponent=-0.3)
    motion = slid(friction, force_n)
    expected_n = mu * (force_n + motion.electrostatic_n)
    np.testing.assert_allclose(motion.lateral_n, expected_n, rtol=1e-13)
    np.testing.assert_allclose(friction.modulation_n(0.01, force_n), mu * 0.01, rtol=1e-13)
    assert lagged_n(FrictionLag(), friction, force_n)[0] == pytest.approx(mu * force_n, rel=1e-13)


def test_lag_corner_is_linear_in_speed() -> None:
    lag = FrictionLag(slope_hz_per_m_per_s=1000.0, intercept_hz=200.0, floor_hz=150.0)
    assert lag.cutoff_hz(0.1) == pytest.approx(300.0)
    assert lag.gain(300.0, 0.1) == pytest.approx(np.sqrt(0.5))
    assert FrictionLag(1000.0, 200.0, 250.0).cutoff_hz(0.01) == 250.0


def test_stretched_finger_breaks_away_sooner() -> None:
    finger, quiet = Finger(), Step(duration_s=0.1).pieces(-6000.0)

    def breaks_away_s(stretch_m: float) -> float:
        travel = Travel(0.05, stretch_m=stretch_m)
        arguments = {"finger": finger, "friction": DryFriction(0.6, 0.5, gated=False), "force_n": 0.5, "travel": travel}
        motion = stick_slip(T_S, quiet, FORM, **arguments)
        assert motion.stretch_m[0] == stretch_m
        return float(motion.events_s[0])

    hold_m = (0.6 * 0.5 - finger.damping_n_s_per_m * 0.05) / finger.stiffness_n_per_m
    for stretch_m in (0.0, 0.5e-3, -0.5e-3):
        assert breaks_away_s(stretch_m) == pytest.approx((hold_m - stretch_m) / 0.05, rel=1e-12)


def swept_n(corner_hz: float, t_s) -> np.ndarray:
    """Return the lagged friction of a sine in `sc_layer`.

    The squared exponentials are written out, and each is lagged on its own.
    """
    (gain,), (decay_per_s,) = FORM.relaxations.gains, FORM.relaxations.rates_per_s
    rate_per_s, omega = 2 * np.pi * corner_hz, 2 * np.pi * 60.0
    response = gain * 1j * omega / (1j * omega + decay_per_s)
    rates = np.array([1j * omega, -1j * omega, -decay_per_s])
    heights = 100.0 * np.array([response / 2j, -np.conj(response) / 2j, -response.imag])
    sums, products = np.add.outer(rates, rates).ravel(), np.outer(heights, heights).ravel()
    moving = np.exp(np.outer(t_s, sums)) - np.exp(-rate_per_s * np.asarray(t_s))[:, None]
    return 0.5 * FORM.newton_per_v2 * (moving @ (products * rate_per_s / (sums + rate_per_s))).real


@pytest.mark.parametrize("corner_hz", [1e2, 1e4, 1e6, 1e8, 9.9e9])
def test_accepted_friction_lag_is_exact(corner_hz: float) -> None:
    t_s = np.linspace(0, 0.1, 101)
    found_n = lagged_n(FrictionLag(0.0, 0.0, corner_hz), CoulombFriction(), 0.0, t_s=t_s)
    expected_n = swept_n(corner_hz, t_s)
    np.testing.assert_allclose(found_n, expected_n, rtol=0, atol=1e-9 * expected_n.max())
