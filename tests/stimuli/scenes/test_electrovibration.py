"""Electrovibration scenes: laziness, stage order and accuracy."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hard_cases import hard_case
from hypothesis import HealthCheck, given, settings
from scene_cases import ELECTROVIBRATION, LEVEL, between_events, default, effect, finest_of, panel, panels, with_needs
from soak import SOAK

from tactometry.stimuli.composition.effect import FingerContact
from tactometry.stimuli.electrovibration import Sine, Skin
from tactometry.stimuli.electrovibration.attraction.contact_area import PowerLawArea
from tactometry.stimuli.electrovibration.attraction.force import electrostatic_force_n_at
from tactometry.stimuli.electrovibration.motion.pad import Finger
from tactometry.stimuli.scenes.scene import Scene
from tactometry.stimuli.scenes.surfaces.electrovibration import Electrovibration

ACCURACIES = (1e-1, 1e-2, 1e-3, 1e-4)
FINEST = 1e-6


def run(scene: Scene):
    return scene.resolve().run(LEVEL)


# --- off costs nothing


def test_level_independent_stages_run_once():
    plan = panel(default("skin_leakage")).resolve()
    plan.prepare()
    assert len(plan._program.steps) < len(plan.stages) / 2
    first = plan.run({"level_db_re_1v": 20.0})["electrostatic_force_n"]
    np.testing.assert_allclose(plan.run({"level_db_re_1v": 40.0})["electrostatic_force_n"], 100 * first, rtol=1e-12)


# --- each effect changes what it is meant to change


@pytest.mark.parametrize("kind", sorted(ELECTROVIBRATION))
def test_active_effect_changes_or_adds_its_output(kind):
    _, needs, output = ELECTROVIBRATION[kind]
    on = run(panel(*with_needs(kind), outputs=(output,)))[output]
    assert np.all(np.isfinite(on))
    if output == "electrostatic_force_n":
        without = run(panel(*(default(name) for name in needs), outputs=(output,)))[output]
        assert on.shape != without.shape or np.abs(on - without).max() > 1e-3 * without.max()


def test_scene_force_matches_physics():
    scene = panel(default("skin_leakage"), default("contact_area"), outputs=("t_s", "electrostatic_force_n"))
    got = run(scene)
    pieces = Sine(60.0, duration_s=0.05, ramp_s=0.01).pieces(40.0)
    area_m2 = float(PowerLawArea().area_m2(2.0))
    expected = electrostatic_force_n_at(got["t_s"], pieces, skin=Skin(), area_m2=area_m2, law="sc_layer")
    off = (got["electrostatic_force_n"] - expected) / expected.max()
    hard_case("force of a scene", off, 0, 1e-12, against="the exact solution", floor=1)


def test_a_scene_without_losses_is_a_divider():
    got = run(panel(outputs=("voltage_v", "electrostatic_force_n")))
    skin = Skin(corneum_resistivity_ohm_m=float("inf"))
    newton_per_v2 = got["electrostatic_force_n"].max() / (skin.k * got["voltage_v"]).max() ** 2
    np.testing.assert_allclose(
        got["electrostatic_force_n"], newton_per_v2 * (skin.k * got["voltage_v"]) ** 2, atol=1e-12
    )


def test_texture_scales_force_along_path():
    texture, outputs = default("texture"), ("t_s", "electrostatic_force_n")
    fine = panel(texture, outputs=outputs, accuracy=1e-4)
    got = run(fine)
    plain = run(panel(outputs=outputs, accuracy=1e-4))
    without = np.interp(got["t_s"], plain["t_s"], plain["electrostatic_force_n"])
    share = (1 + np.cos(2 * np.pi * 0.05 * got["t_s"] / 1e-3)) / 2
    np.testing.assert_allclose(texture.force_share(0.05 * got["t_s"]), share, atol=1e-12)
    np.testing.assert_allclose(got["electrostatic_force_n"], without * share, atol=2e-4 * without.max())


# --- the tolerance is kept


def error_of(got, reference, output: str) -> float:
    """Return the largest error of straight lines over the peak.

    Jumps are left out; the error of a level is a ratio.
    """
    if output == "sensation_db":
        return abs(10 ** ((got[output] - reference[output]) / 20) - 1)
    if np.ndim(got[output]) == 0:
        return abs(got[output] / reference[output] - 1)
    off = np.abs(np.interp(reference["t_s"], got["t_s"], got[output]) - reference[output])
    jumps = got.get("slip_events_s", ()) if output == "friction_force_n" else ()
    return float(off[between_events(got["t_s"], jumps, reference["t_s"])].max() / np.abs(reference[output]).max())


@pytest.mark.parametrize("kind", sorted(ELECTROVIBRATION))
def test_accuracy_is_met_and_looser_accuracy_costs_less(kind):
    output = ELECTROVIBRATION[kind][2]
    scene = panel(*with_needs(kind), outputs=(output,) if output == "sensation_db" else ("t_s", output))
    finest = 2e-6 if output == "sensation_db" else FINEST
    reference = run(replace(scene, accuracy=finest))
    costs = []
    for accuracy in ACCURACIES:
        plan = replace(scene, accuracy=accuracy).resolve()
        true = error_of(plan.run(LEVEL), reference, output)
        assert true <= plan.error <= accuracy
        assert plan.error <= 10 * max(true, accuracy / 10)
        costs.append(plan.n_operations)
    assert costs == sorted(costs)
    assert costs[0] < costs[-1]


FORCES = ("t_s", "electrostatic_force_n", "friction_force_n", "peak_force_n")
JERK = (
    Electrovibration(20.0, duration_s=0.03125, ramp_s=0.005, insulator_thickness_m=5e-7),
    tuple(default(kind) for kind in ("force_law", "air_gap", "skin_leakage", "friction")),
    FORCES,
)
"""A skin so lossy that the end of a ramp shows in its force."""
KINKED = (
    Electrovibration(63.0, duration_s=0.03125, ramp_s=0.005),
    tuple(default(kind) for kind in ("force_law", "carrier", "dc_offset", "friction")),
    FORCES,
)
"""A constant that shows the kinks of an envelope."""


@pytest.mark.parametrize(("case", "accuracy"), [(JERK, 1e-3), (KINKED, 1e-4)], ids=["jerk", "kinks"])
def test_accuracy_is_met_at_ramp_ends_and_kinks(case, accuracy):
    scene = Scene(*case, accuracy, (FingerContact(0.5, 0.05),))
    reference = run(replace(scene, settings={"sampling": {"n_samples": 100_001}}))
    assert error_of(run(scene), reference, "electrostatic_force_n") <= accuracy


@given(panels(outputs=FORCES))
@settings(max_examples=100 if SOAK else 5, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_random_scenes_keep_their_accuracy(case):
    surface, effects, outputs = case
    scene = Scene(surface, effects, outputs, 1e-2, (FingerContact(0.5, 0.05),))
    finest = finest_of(scene, *((3e-5, 9e-5) if SOAK else (3e-4,)))
    reference = run(finest)
    for accuracy in ACCURACIES if SOAK else ACCURACIES[:3]:
        got = run(replace(scene, accuracy=accuracy))
        for output in outputs[1:4]:
            error = error_of(got, reference, output) / (accuracy + finest.accuracy)
            hard_case("random scenes, in parts of the accuracy asked for", error, 0, 1.0, against="finer", floor=1)


@pytest.mark.parametrize(("frequency_hz", "ramp_s"), [(20.0, 0.0), (60.0, 0.01)])
def test_stick_slip_events_are_exact(frequency_hz, ramp_s):
    ringing = effect("finger_dynamics", damping_n_s_per_m=0.05)  # else it slips once, and slides on
    effects = (effect("force_law", law="sc_layer"), default("dry_friction"), ringing)
    outputs = ("t_s", "slip_events_s", "friction_force_n", "skin_displacement_m")
    surface = Electrovibration(frequency_hz, duration_s=0.2, ramp_s=ramp_s)
    scene = Scene(surface, effects, outputs, contacts=(FingerContact(0.5, 0.05),))
    reference = run(replace(scene, accuracy=1e-5))
    assert reference["slip_events_s"].size >= 4
    for accuracy in ACCURACIES:
        got = run(replace(scene, accuracy=accuracy))
        np.testing.assert_allclose(got["slip_events_s"], reference["slip_events_s"], rtol=1e-9)
        for output in outputs[2:]:
            assert error_of(got, reference, output) <= accuracy


def test_voltage_does_not_hold_a_stuck_finger():
    """Slip starts when the pad bears the static friction of the load."""
    pad, force_n, speed_m_per_s = Finger.at_speed(0.05), 0.5, 0.05
    at_rest_n = 0.6 * force_n - pad.damping_n_s_per_m * speed_m_per_s
    law = effect("force_law", law="sc_layer")
    surface, touch = Electrovibration(60.0, duration_s=0.2), FingerContact(force_n, speed_m_per_s)
    for level in (-40.0, 50.0):
        slips_s = []
        for friction in (default("dry_friction"), effect("dry_friction", gated=False)):
            scene = Scene(surface, (law, friction, default("finger_dynamics")), ("slip_events_s",), contacts=(touch,))
            slips_s.append(scene.resolve().run({"level_db_re_1v": level})["slip_events_s"][0])
        assert slips_s[0] == pytest.approx(at_rest_n / (pad.stiffness_n_per_m * speed_m_per_s), rel=1e-9)
    assert slips_s[1] > 1.01 * slips_s[0]


# --- order and conflicts


def test_the_order_of_the_tuple_does_not_matter():
    kinds = ("skin_leakage", "air_gap", "body_resistance", "contact_area")
    first, *others = (panel(*map(default, order)).resolve() for order in itertools.permutations(kinds))
    assert all(plan == first for plan in others)
