"""A sliding finger, against a 50-digit sum of exponentials."""

import mpmath as mp
import numpy as np
import pytest
from hard_cases import hard_case

from tactometry.stimuli.electrovibration import (
    AmplitudeModulated,
    CoulombFriction,
    Finger,
    Sine,
    Skin,
    Square,
    Step,
    Trapezoid,
    sliding,
)
from tactometry.stimuli.electrovibration.attraction.force import ForceForm, force_form
from tactometry.stimuli.electrovibration.motion.friction_lag import FrictionLag, lagged_friction_n
from tactometry.stimuli.electrovibration.motion.skin_mobility import SkinMobility
from tactometry.stimuli.electrovibration.skin.relaxation import Solution
from tactometry.stimuli.electrovibration.waveforms.pieces import Pieces, straight
from tactometry.stimuli.scenes.effects.finger_dynamics import FingerDynamics

FINGER, FRICTION = Finger(), CoulombFriction(0.5)
AREA_M2 = 1e-4
T_S = np.linspace(0, 0.05, 289)[1:]
STEP = Step(duration_s=0.05).pieces(40.0)
TRAPEZOID = Trapezoid(rise_s=1e-3, high_s=5e-3, fall_s=1e-3, low_s=5e-3, duration_s=0.05).pieces(40.0)
SINE = Sine(frequency_hz=240.0, ramp_s=0.0, duration_s=0.05).pieces(40.0)
TAUS_S = [1e-9, 1e-6, 1e-4, 5e-3, 1.0, 1e3]


def form_of(tau_s: float, law: str = "sc_layer", **changes: float) -> ForceForm:
    return force_form(law, Skin(corneum_resistivity_ohm_m=2e4 * tau_s / Skin().tau_s, **changes), AREA_M2)


def reference_m(pieces: Pieces, form: ForceForm, t_s: np.ndarray) -> list[float]:
    """Return the deflection by the force of each piece in 50 digits.

    Each force is a sum of complex exponentials.
    """
    with mp.workdps(50):
        m, c, k = (mp.mpf(x) for x in (FINGER.mass_kg, FINGER.damping_n_s_per_m, FINGER.stiffness_n_per_m))
        root = mp.sqrt(mp.mpc(c**2 - 4 * m * k))
        modes = [(-c + root) / (2 * m), (-c - root) / (2 * m)]
        mu = mp.mpf(0.5) * mp.mpf(form.newton_per_v2)
        rates = [mp.mpf(r) for r in form.relaxations.rates_per_s]
        gains = [mp.mpf(g) for g in form.relaxations.gains]
        x, v = mp.mpf(0), mp.mpf(0)
        y = [mp.mpf(0)] * len(rates)
        before, found = mp.mpf(0), []
        ends = [*pieces.starts_s[1:], pieces.end_s]
        for i, (first, last) in enumerate(zip(pieces.starts_s, ends, strict=True)):
            start, end = mp.mpf(first), mp.mpf(last)
            s, f = mp.mpf(pieces.slopes_v_per_s[i]), [2j * mp.pi * mp.mpf(f) for f in pieces.frequencies_hz]
            turned = [mp.mpc(a) * mp.exp(w * start) for a, w in zip(pieces.harmonics_v[i], f, strict=True)]
            now = mp.mpf(pieces.offsets_v[i]) + sum(a.real for a in turned)
            terms: list[tuple] = []
            for n, (gain, rate) in enumerate(zip(gains, rates, strict=True)):
                y[n] += now - before
                forced = [(gain * s / rate, mp.mpf(0))]
                for a, w in zip(turned, f, strict=True):
                    h = gain * w / (w + rate) * a / 2
                    forced += [(h, w), (mp.conj(h), mp.conj(w))]
                terms += [(gain * y[n] - sum(a for a, _ in forced), -rate), *forced]
                y[n] = sum(a * mp.exp(p * (end - start)) for a, p in terms[-len(forced) - 1 :]) / gain
            squares = [(mu * a * b, p + q) for a, p in terms for b, q in terms]
            forced_x = [(a / (m * p**2 + c * p + k), p) for a, p in squares]
            x0, v0 = x - sum(a for a, _ in forced_x), v - sum(a * p for a, p in forced_x)
            free = [((v0 - modes[1] * x0) / (modes[0] - modes[1]), modes[0])]
            free.append((x0 - free[0][0], modes[1]))
            motion = [*forced_x, *free]
            here = t_s[(t_s > first) & (t_s <= last)]
            found += [float(mp.re(sum(a * mp.exp(p * (mp.mpf(t) - start)) for a, p in motion))) for t in here]
            x, v = (mp.re(sum(a * p**o * mp.exp(p * (end - start)) for a, p in motion)) for o in (0, 1))
            before = mp.mpf(pieces.offsets_v[i]) + s * (end - start)
            before += sum((a * mp.exp(w * (end - start))).real for a, w in zip(turned, f, strict=True))
        return found


@pytest.mark.parametrize("tau_s", TAUS_S)
@pytest.mark.parametrize("pieces", [STEP, TRAPEZOID, SINE], ids=["step", "trapezoid", "sine"])
def test_deflection_against_50_digits(pieces: Pieces, tau_s: float) -> None:
    form = form_of(tau_s)
    t_s = T_S[::16]
    motion = sliding(t_s, pieces, form, finger=FINGER, friction=FRICTION, force_n=1e-15)
    expected_m = np.array(reference_m(pieces, form, t_s))
    found_m = motion.deflection_m - 0.5e-15 / FINGER.stiffness_n_per_m
    size_m = np.abs(expected_m).max()
    hard_case("sliding finger, any tau", (found_m - expected_m) / size_m, 0, 1e-11, against="50 digits", floor=1)


def test_body_resistance_against_50_digits() -> None:
    form = form_of(3e-4, body_resistance_ohm=1e4)
    t_s = T_S[::16]
    unloaded = sliding(t_s, TRAPEZOID, form, finger=FINGER, friction=FRICTION, force_n=0.0)
    loaded = sliding(t_s, TRAPEZOID, form, finger=FINGER, friction=FRICTION, force_n=1.0)
    expected_m = np.array(reference_m(TRAPEZOID, form, t_s))
    found_m = loaded.deflection_m - 0.5 / FINGER.stiffness_n_per_m
    tolerance_m = 1e-11 * np.abs(expected_m).max()
    np.testing.assert_allclose(found_m, expected_m, rtol=0, atol=tolerance_m + 5e-19)
    np.testing.assert_allclose(unloaded.deflection_m, expected_m, rtol=0, atol=tolerance_m)


@pytest.mark.parametrize("law", ["sc_layer", "interface", "total_thickness", "parallel_plate"])
@pytest.mark.parametrize(
    "pieces",
    [
        Square(frequency_hz=100.0, duration_s=0.05, ramp_s=0.01).pieces(40.0),
        AmplitudeModulated(frequency_hz=100.0, duration_s=0.05, ramp_s=0.01).pieces(40.0),
        straight([0, 0.01, 0.01, 0.05], [10, 60, -20, 30]),
    ],
    ids=["square", "carrier", "lines"],
)
def test_the_motion_obeys_newton(law: str, pieces: Pieces) -> None:
    t_s = np.linspace(0, 0.05, 40_001)
    motion = sliding(t_s, pieces, form_of(3e-4, law), finger=FINGER, friction=FRICTION, force_n=1.0)
    middle = (motion.deflection_m[2:] - motion.deflection_m[:-2]) / (t_s[2:] - t_s[:-2])
    smooth = np.abs(t_s[1:-1, None] - pieces.starts_s).min(axis=1) > 5e-6
    scale = np.abs(motion.speed_m_per_s).max()
    np.testing.assert_allclose(middle[smooth], motion.speed_m_per_s[1:-1][smooth], atol=2e-4 * scale)
    balance_n = (
        FINGER.mass_kg * motion.acceleration_m_per_s2
        + FINGER.damping_n_s_per_m * motion.speed_m_per_s
        + FINGER.stiffness_n_per_m * motion.deflection_m
    )
    np.testing.assert_allclose(balance_n, motion.lateral_n, rtol=1e-12)


def test_force_form_matches_force_of_its_law() -> None:
    motion = sliding(T_S, SINE, form_of(3e-4), finger=FINGER, friction=FRICTION, force_n=2.0)
    force_n = form_of(3e-4).newton_per_v2 * Solution(SINE, form_of(3e-4).relaxations).at(T_S) ** 2
    np.testing.assert_allclose(motion.lateral_n, 0.5 * (2.0 + force_n), rtol=1e-14)


def test_lag_of_a_step_is_an_exponential() -> None:
    lag, lossless = FrictionLag(), form_of(np.inf)
    found_n = lagged_friction_n(T_S, STEP, lossless, lag=lag, friction=FRICTION, force_n=1.0, speed_m_per_s=0.05)
    final_n = 0.5 * lossless.newton_per_v2 * (100 * lossless.relaxations.dc_gain) ** 2
    expected_n = 0.5 + final_n * -np.expm1(-2 * np.pi * 690 * T_S)
    np.testing.assert_allclose(found_n, expected_n, rtol=1e-12)


def test_no_lag_effect_at_rest() -> None:
    found_n = lagged_friction_n(
        T_S, STEP, form_of(1e-3), lag=FrictionLag(), friction=FRICTION, force_n=1.0, speed_m_per_s=0.0
    )
    assert not found_n.any()


def test_published_growth_of_a_finger_with_speed() -> None:
    slow, fast = Finger.at_speed(0.02), Finger.at_speed(0.1)
    assert (fast.mass_kg - slow.mass_kg) * 1e3 == pytest.approx(2.584)
    assert fast.stiffness_n_per_m - slow.stiffness_n_per_m == pytest.approx(323.2)
    assert slow.damping_n_s_per_m == fast.damping_n_s_per_m


def test_a_pad_is_damped_as_the_skin_is() -> None:
    """Overshoot after a step: exp(-pi z/sqrt(1 - z^2)), damping ratio z."""
    t_s, finger = np.linspace(0, 0.1, 10_001), Finger.at_speed(0.1)
    lossless = force_form("sc_layer", Skin(corneum_resistivity_ohm_m=np.inf), AREA_M2)
    held = straight([0, 0.1], [100.0, 100.0])
    deflection_m = sliding(t_s, held, lossless, finger=finger, friction=FRICTION, force_n=0.5).deflection_m
    ratio = SkinMobility().damping_n_s_per_m / (2 * np.sqrt(4040 * 3.23e-2) * 0.1)
    overshoot = np.exp(-np.pi * ratio / np.sqrt(1 - ratio**2))
    swing_m = deflection_m - deflection_m[0]
    assert swing_m.max() / swing_m[-1] - 1 == pytest.approx(overshoot, rel=1e-3)
    assert Finger().damping_n_s_per_m == FingerDynamics().damping_n_s_per_m == SkinMobility().damping_n_s_per_m


@pytest.mark.parametrize("force_n", [1e-3, 0.5, 3.0, 100.0])
def test_skin_moves_as_a_pad_of_its_stiffness_and_damping_at_a_force(force_n: float) -> None:
    """A steady sine of voltage moves the pad at twice its frequency."""
    skin = SkinMobility(stiffness_exponent=1.0, damping_exponent=0.5)
    pad = Finger(skin.mass_kg, 1000.0 * force_n, 1.5 * force_n**0.5)
    form = force_form("parallel_plate", Skin(), AREA_M2)
    t_s = 1 + np.arange(4096) / 4096 / 30  # one period of the force, after the transient
    pieces = Sine(frequency_hz=15.0, ramp_s=0.0, duration_s=1.1).pieces(20.0)
    moved = sliding(t_s, pieces, form, finger=pad, friction=FRICTION, force_n=force_n)
    lines = [abs(np.fft.rfft(course)[1]) for course in (moved.deflection_m, moved.lateral_n)]
    assert lines[0] / lines[1] == pytest.approx(float(skin.gain_m_per_n(30.0, force_n)), rel=1e-6)


def test_skin_that_no_force_changes_is_the_same_at_all_forces() -> None:
    skin = SkinMobility()
    assert skin.under(0.0) is skin
    np.testing.assert_array_equal(skin.gain_m_per_n([0.0, 1e5], 1e-9), skin.gain_m_per_n([0.0, 1e5], 100.0))


def test_skin_of_one_exponent_without_mass_scales_with_the_force() -> None:
    skin = SkinMobility(mass_kg=0.0, stiffness_exponent=0.4, damping_exponent=0.4)
    f_hz = np.array([0.0, 30.0, 480.0, 1e5])
    np.testing.assert_allclose(skin.gain_m_per_n(f_hz, 100.0) * 100.0**0.4, skin.gain_m_per_n(f_hz, 1.0), rtol=1e-12)


def test_almost_uniform_times_are_not_treated_as_uniform() -> None:
    form = force_form("interface", Skin(), AREA_M2)
    even_s = np.linspace(0, 0.05, 51)[1:-1]
    jitter_s = even_s * (1 + 3e-5 * np.sin(np.arange(even_s.size)))

    def deflection_m(t_s: np.ndarray) -> np.ndarray:
        return sliding(t_s, SINE, form, finger=FINGER, friction=FRICTION, force_n=0.01).deflection_m

    together = deflection_m(jitter_s)
    alone = [deflection_m(np.array([t_s]))[0] for t_s in jitter_s]
    np.testing.assert_allclose(together, alone, rtol=1e-11)
