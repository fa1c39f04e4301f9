"""Stick and slip, against a closed form and a solver with events."""

import numpy as np
import pytest
from examples import examples
from hard_cases import hard_case
from hypothesis import given, strategies as st
from scipy.integrate import solve_ivp

from tactometry.errors import InvalidParameter
from tactometry.stimuli.electrovibration import Finger, Sine, Skin, Square, StickSlip, Trapezoid, stick_slip
from tactometry.stimuli.electrovibration.attraction.force import ForceForm, force_form
from tactometry.stimuli.electrovibration.motion import power_series, stick_slip as sticking
from tactometry.stimuli.electrovibration.motion.dry_friction import DryFriction
from tactometry.stimuli.electrovibration.motion.stick_slip import Travel
from tactometry.stimuli.electrovibration.skin.relaxation import Solution
from tactometry.stimuli.electrovibration.waveforms.pieces import Pieces, straight

FINGER, FRICTION = Finger(damping_n_s_per_m=0.0466), DryFriction(0.6, 0.5, gated=False)
"""A pad that rings, so that it sticks and slips again and again."""
LAYER = force_form("sc_layer", Skin(), 1e-4)
STRONG = ForceForm(LAYER.relaxations, 500 * LAYER.newton_per_v2)
QUIET = straight([0, 1.0], [0, 0])
SINE = Sine(frequency_hz=60.0, ramp_s=0.0, duration_s=0.1).pieces(46.0)
SQUARE = Square(frequency_hz=60.0, ramp_s=0.0, duration_s=0.1).pieces(30.0)
TRAPEZOID = Trapezoid(rise_s=1e-3, high_s=7e-3, fall_s=2e-3, low_s=6e-3, duration_s=0.1).pieces(46.0)
T_S = np.linspace(0, 0.1, 401)


def run(pieces: Pieces = SINE, t_s: np.ndarray = T_S, form: ForceForm = STRONG, **changes) -> StickSlip:
    arguments = {"finger": FINGER, "friction": FRICTION, "force_n": 0.5, "travel": Travel(0.05)}
    return stick_slip(t_s, pieces, form, **{**arguments, **changes})


def test_period_of_stick_and_slip_in_closed_form() -> None:
    finger, speed = Finger(damping_n_s_per_m=0.0), 0.05
    motion = run(QUIET, np.linspace(0, 1, 11), finger=finger, force_n=1.0)
    omega = np.sqrt(finger.stiffness_n_per_m / finger.mass_kg)
    half_swing_m = (0.6 - 0.5) / finger.stiffness_n_per_m
    first_s = 0.6 / finger.stiffness_n_per_m / speed
    slip_s = 2 * (np.pi - np.arctan(half_swing_m * omega / speed)) / omega
    lengths_s = np.diff(motion.events_s)
    assert motion.events_s[0] == pytest.approx(first_s, rel=1e-13)
    np.testing.assert_allclose(lengths_s[::2], slip_s, rtol=1e-12)
    np.testing.assert_allclose(lengths_s[1::2], 2 * half_swing_m / speed, rtol=1e-12)
    assert motion.event_directions.tolist() == [1.0, 0.0] * (len(motion.events_s) // 2) + [1.0] * (
        len(motion.events_s) % 2
    )


def test_whole_numbers_and_columns_are_not_compiled_anew() -> None:
    """Compiling for another argument type took seconds."""
    starts_s, flat = np.array([0.0, 0.05]), np.zeros(2)
    by_columns = Pieces(starts_s, 0.1, flat, flat, np.array([60.0, 90.0]), np.ones((2, 2), np.complex128, order="F"))
    run(force_n=1.0)
    run(by_columns, force_n=1)
    assert len(power_series._flow_entry.signatures) == 1


def leg(pieces: Pieces, form: ForceForm, travel: Travel, force_n: float, way: int, start: list[float], stop: float):
    """Solve stick (way 0) or slip adaptively up to the next event.

    Starts at (time, stretch, rate) and ends at `stop` at the latest.
    """
    m, c, k = FINGER.mass_kg, FINGER.damping_n_s_per_m, FINGER.stiffness_n_per_m
    solved, before_stop = Solution(pieces, form.relaxations), np.nextafter(stop, 0)

    def load_n(t: float) -> float:
        return force_n + form.newton_per_v2 * float(solved.at(min(t, before_stop))) ** 2

    def speed(t: float) -> float:
        return travel.speed_m_per_s + travel.acceleration_m_per_s2 * t

    def slope(t: float, y: np.ndarray) -> list[float]:
        push_n = m * travel.acceleration_m_per_s2 + way * 0.5 * load_n(t)
        slipping = [y[1], (push_n - c * y[1] - k * y[0]) / m]
        return slipping if way else [speed(t), travel.acceleration_m_per_s2]

    def event(t: float, y: np.ndarray) -> float:
        if way:
            return way * (speed(t) - y[1]) + (1e-9 if t < start[0] + 1e-5 else 0)
        return 0.6 * load_n(t) - abs(k * y[0] + c * speed(t))

    event.terminal, event.direction = True, -1
    if way == 0 and event(start[0], start[1:]) < -1e-9:
        return None
    return solve_ivp(
        slope, (start[0], stop), start[1:], method="DOP853", events=event, rtol=1e-11, atol=1e-14,
        max_step=5e-4, dense_output=True,
    )  # fmt: skip


def reference(
    pieces: Pieces, travel: Travel, force_n: float, form: ForceForm = STRONG
) -> tuple[np.ndarray, np.ndarray]:
    """Return stretch at `T_S` and event times from an adaptive solver.

    The solver restarts at events and at the starts of pieces.
    """
    c, k = FINGER.damping_n_s_per_m, FINGER.stiffness_n_per_m
    time, s, rate, way = 0.0, 0.0, travel.speed_m_per_s, 0
    found_m, events_s = np.zeros(len(T_S)), []
    stops = np.array([*pieces.starts_s[1:], pieces.end_s])
    while time < pieces.end_s:
        stop = stops[stops > time * (1 + 1e-14)].min()
        speed = travel.speed_m_per_s + travel.acceleration_m_per_s2 * time
        r = leg(pieces, form, travel, force_n, way, [time, s, rate], stop)
        if r is not None:
            until = r.t_events[0][0] if r.t_events[0].size else stop
            inside = (time <= T_S) & (until >= T_S)
            found_m[inside] = r.sol(T_S[inside])[0] if inside.any() else 0
            time, (s, rate) = until, r.sol(until)
            speed = travel.speed_m_per_s + travel.acceleration_m_per_s2 * time
        if r is None or time < stop:
            way = 0 if way else int(np.sign(k * s + c * speed))
            rate = speed
            events_s.append(time)
    return found_m, np.array(events_s)


@pytest.mark.parametrize(
    ("pieces", "travel"),
    [(SINE, Travel(0.05)), (TRAPEZOID, Travel(0.1)), (SQUARE, Travel(0.1)), (SINE, Travel(-0.15, 3.0))],
    ids=["sine", "trapezoid", "square", "through zero"],
)
def test_events_and_motion_against_an_adaptive_solver(pieces: Pieces, travel: Travel) -> None:
    motion = run(pieces, travel=travel)
    expected_m, events_s = reference(pieces, travel, 0.5)
    assert len(motion.events_s) >= 4
    size_m = np.abs(expected_m).max()
    hard_case("events of stick and slip (s)", motion.events_s - events_s, 0, 1e-9, against="DOP853 at 1e-12", floor=1)
    moved = (motion.stretch_m - expected_m) / size_m
    hard_case("motion of stick and slip", moved, 0, 1e-9, against="DOP853 at 1e-12", floor=1)


@pytest.mark.parametrize("tau_s", [1e-9, 1e-5, 1.0, 1e3])
@pytest.mark.parametrize("body_ohm", [0.0, 1e4])
def test_motion_matches_adaptive_solver_at_any_time_constant(tau_s: float, body_ohm: float) -> None:
    skin = Skin(corneum_resistivity_ohm_m=2e4 * tau_s / Skin().tau_s, body_resistance_ohm=body_ohm)
    layer = force_form("sc_layer", skin, 1e-4)
    peak_v = np.abs(Solution(SINE, layer.relaxations).at(np.linspace(0, 0.1, 1000))).max()
    form = ForceForm(layer.relaxations, 0.3 / peak_v**2)
    motion = run(SINE, form=form)
    expected_m, events_s = reference(SINE, Travel(0.05), 0.5, form)
    assert len(motion.events_s) >= 4
    np.testing.assert_allclose(motion.events_s, events_s, rtol=0, atol=1e-9)
    moved = (motion.stretch_m - expected_m) / np.abs(expected_m).max()
    hard_case("stick and slip, tau of 1 ns to 1000 s", moved, 0, 1e-9, against="DOP853 at 1e-12", floor=1)


@pytest.mark.parametrize("tau_s", [1e-5, 1e-4])
def test_settled_slope_force_matches_adaptive_solver(tau_s: float) -> None:
    layer = force_form("sc_layer", Skin(corneum_resistivity_ohm_m=2e4 * tau_s / Skin().tau_s), 1e-4)
    slopes = Trapezoid(rise_s=0.02, high_s=0.0, fall_s=0.03, low_s=0.0, duration_s=0.1).pieces(46.0)
    peak_v = np.abs(Solution(slopes, layer.relaxations).at(np.linspace(0, 0.1, 1000))).max()
    form = ForceForm(layer.relaxations, 0.5 / peak_v**2)
    motion = run(slopes, form=form, force_n=0.2, travel=Travel(0.1))
    expected_m, events_s = reference(slopes, Travel(0.1), 0.2, form)
    assert len(motion.events_s) >= 2
    np.testing.assert_allclose(motion.events_s, events_s, rtol=0, atol=1e-9)
    np.testing.assert_allclose(motion.stretch_m, expected_m, rtol=0, atol=1e-9 * np.abs(expected_m).max())


@pytest.mark.parametrize("pieces", [SINE, SQUARE, TRAPEZOID])
def test_motion_is_independent_of_output_times(pieces: Pieces) -> None:
    coarse, fine = run(pieces, T_S[::40]), run(pieces, np.linspace(0, 0.1, 8001))
    np.testing.assert_allclose(fine.events_s, coarse.events_s, rtol=0, atol=1e-13)
    np.testing.assert_allclose(fine.stretch_m[::800], coarse.stretch_m, rtol=0, atol=1e-15)


@given(
    speed=st.floats(-0.2, 0.2), force_n=st.floats(0.01, 2.0), mu=st.floats(0.1, 0.9), more=st.floats(0, 0.5),
    gated=st.booleans(),
)  # fmt: skip
@examples(60)
def test_stick_slip_friction_obeys_its_limits(
    speed: float, force_n: float, mu: float, more: float, gated: bool
) -> None:
    friction = DryFriction(mu + more, mu, gated)
    motion = run(friction=friction, force_n=force_n, travel=Travel(speed))
    load_n = force_n + motion.electrostatic_n
    slips = motion.direction != 0
    expected_n = motion.direction[slips] * mu * load_n[slips]
    np.testing.assert_allclose(motion.lateral_n[slips], expected_n, rtol=1e-12)
    static_n = (mu + more) * (force_n if gated else load_n)
    bearable_n = np.maximum(static_n, mu * load_n) if gated else static_n
    assert (np.abs(motion.lateral_n) <= bearable_n * (1 + 1e-9))[~slips].all()
    np.testing.assert_allclose(motion.stretch_m_per_s[~slips], speed, atol=1e-15)
    ahead = motion.direction * (speed - motion.stretch_m_per_s)
    assert (ahead[slips] >= -1e-9).all()


def test_zero_speed_has_no_effect_at_any_voltage() -> None:
    motion = run(travel=Travel(0.0))
    assert motion.events_s.size == 0
    assert not motion.lateral_n.any()
    assert motion.electrostatic_n.any()


def test_speed_of_a_nanometre_per_second_only_stretches() -> None:
    motion = run(travel=Travel(1e-9))
    assert motion.events_s.size == 0
    np.testing.assert_allclose(motion.stretch_m, 1e-9 * T_S, rtol=1e-12)


def test_speed_through_zero_turns_the_slip_round() -> None:
    motion = run(QUIET, np.linspace(0, 1, 2001), travel=Travel(0.1, -0.2), force_n=0.2)
    assert set(motion.event_directions.tolist()) == {-1.0, 0.0, 1.0}
    signs = motion.event_directions[motion.event_directions != 0]
    assert (np.diff(signs) <= 0).all()


def test_normal_force_0_without_voltage_has_no_friction() -> None:
    motion = run(QUIET, force_n=0.0, friction=DryFriction(0.5, 0.5, gated=False))
    assert np.abs(motion.lateral_n).max() == 0


def test_zero_normal_force_leaves_friction_of_voltage() -> None:
    motion = run(SINE, force_n=0.0)
    assert (np.abs(motion.lateral_n) <= 0.6 * motion.electrostatic_n + 1e-15).all()
    assert motion.lateral_n.any()


def test_normal_force_of_1_kilonewton_sticks() -> None:
    motion = run(SINE, force_n=1000.0)
    assert motion.events_s.size == 0
    hard_case("finger that 1 kN holds", motion.stretch_m, 0.05 * T_S, 1e-12, against="the way of the screen")


def test_chatter_at_a_kilohertz_stays_exact() -> None:
    chatter = Square(frequency_hz=1000.0, ramp_s=0.0, duration_s=0.1).pieces(34.0)
    motion = run(chatter, force_n=0.2, travel=Travel(0.1))
    again = run(chatter, T_S[::100], force_n=0.2, travel=Travel(0.1))
    assert motion.events_s.size > 20
    hard_case("chatter at 1 kHz (m)", again.stretch_m, motion.stretch_m[::100], 1e-13, against="other times", floor=1)


def test_gated_voltage_does_not_increase_sticking() -> None:
    constant = straight([0, 1.0], [50, 50])
    lossless = ForceForm(force_form("sc_layer", Skin(corneum_resistivity_ohm_m=np.inf), 1e-4).relaxations, 1e-3)
    breaks_s = [
        float(
            stick_slip(
                [1.0], constant, lossless, finger=FINGER, friction=DryFriction(0.6, 0.3, gated), force_n=1.0,
                travel=Travel(0.01),
            ).events_s[0]
        )
        for gated in (False, True)
    ]  # fmt: skip
    load_n = 1.0 + 1e-3 * (50 * Skin().k) ** 2
    k, c = FINGER.stiffness_n_per_m, FINGER.damping_n_s_per_m
    limits_n = [0.6 * load_n, max(0.6, 0.3 * load_n)]
    np.testing.assert_allclose(breaks_s, [(limit - c * 0.01) / k / 0.01 for limit in limits_n], rtol=1e-12)


def test_too_many_events_stop_with_their_time() -> None:
    with pytest.raises(
        InvalidParameter, match=r"too many changes between stick and slip \(n_events_max, 3, is reached\)"
    ):
        run(n_events_max=3)


def test_finger_is_refused_when_series_needs_many_steps(monkeypatch) -> None:
    monkeypatch.setattr(sticking, "N_STEPS_MAX", 20_000)  # as many as take milliseconds, for one that slips
    light = Finger(mass_kg=1e-15, stiffness_n_per_m=1e7, damping_n_s_per_m=0.0)
    with pytest.raises(InvalidParameter, match=r"more than 2e\+04 steps of the series at .* up to 1e\+11 rad/s\)"):
        run(finger=light)


@pytest.mark.parametrize("speed_m_per_s", [1e-12, 1e-9, 1e-7, 1e-5])
def test_slow_finger_sticks_without_extra_steps(monkeypatch, speed_m_per_s: float) -> None:
    """Published mass falls with speed, as does the decay time in slip."""
    monkeypatch.setattr(sticking, "N_STEPS_MAX", 20_000)
    finger = Finger.at_speed(speed_m_per_s)
    motion = run(finger=finger, travel=Travel(speed_m_per_s))
    assert motion.events_s.size == 0
    hard_case("finger of 1 pm/s that sticks (m)", motion.stretch_m, speed_m_per_s * T_S, 1e-12, against="the way")
    lateral_n = finger.stiffness_n_per_m * speed_m_per_s * T_S + finger.damping_n_s_per_m * speed_m_per_s
    assert motion.lateral_n == pytest.approx(lateral_n, rel=1e-12)


def test_stuck_skin_accelerates_with_finger() -> None:
    motion = run(QUIET, friction=DryFriction(), force_n=100.0, travel=Travel(0.01, 0.3))
    assert not motion.direction.any()
    np.testing.assert_array_equal(motion.stretch_m_per_s2, 0.3)
