"""Electrovibration scenes: laziness, stage order and accuracy."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from felt_models import felt_by
from fresh_processes import counted
from hard_cases import hard_case
from hypothesis import HealthCheck, given, settings
from scene_cases import (
    ELECTROVIBRATION,
    LEVEL,
    SLIDING,
    between_events,
    default,
    effect,
    finest_of,
    panel,
    panels,
    with_needs,
)
from soak import SOAK

from tactometry.contact import Contact
from tactometry.errors import InvalidParameter
from tactometry.signal import Signal
from tactometry.stimuli.composition.effect import FingerContact
from tactometry.stimuli.electrovibration import CoulombFriction, ElectrovibrationSensation, Sine, Skin
from tactometry.stimuli.electrovibration.attraction.contact_area import PowerLawArea
from tactometry.stimuli.electrovibration.attraction.force import electrostatic_force_n_at
from tactometry.stimuli.electrovibration.motion.friction_lag import FrictionLag
from tactometry.stimuli.electrovibration.motion.pad import Finger
from tactometry.stimuli.scenes.plan import Plan
from tactometry.stimuli.scenes.scene import Scene
from tactometry.stimuli.scenes.surfaces.electrovibration import Electrovibration

ACCURACIES = (1e-1, 1e-2, 1e-3, 1e-4)
FINEST = 1e-6


def run(scene: Scene):
    return scene.resolve().run(LEVEL)


def calls(plan: Plan) -> int:
    """Count the calls of a warm run: the fewest of five.

    The interpreter occasionally adds calls of its internals.
    """
    plan.run(LEVEL)
    return min(counted(plan, LEVEL) for _ in range(5))


# --- off costs nothing


@pytest.mark.parametrize("kind", sorted(set(ELECTROVIBRATION) - {"carrier", "texture"}))
def test_unneeded_effect_costs_no_calls(kind):
    without = panel(outputs=("voltage_v",)).resolve()
    with_it = panel(*with_needs(kind), outputs=("voltage_v",)).resolve()
    if kind == "dc_offset":
        assert calls(with_it) > calls(without)
    else:
        assert with_it.stages == without.stages
        assert calls(with_it) == calls(without)


def test_level_independent_stages_run_once():
    plan = panel(default("skin_leakage")).resolve()
    plan.prepare()
    assert len(plan._program.steps) < len(plan.stages) / 2
    first = plan.run({"level_db_re_1v": 20.0})["electrostatic_force_n"]
    np.testing.assert_allclose(plan.run({"level_db_re_1v": 40.0})["electrostatic_force_n"], 100 * first, rtol=1e-12)


def test_a_static_scene_computes_no_friction():
    off = panel(default("friction"), default("friction_lag"), outputs=("peak_force_n",))
    assert {each.kind for each in off.off()} == {"friction", "friction_lag"}


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


def test_scene_sensation_matches_observer():
    surface = Electrovibration(60.0, duration_s=1.0)
    effects = [default(k) for k in ("force_law", "skin_leakage", "contact_area", "friction", "friction_lag")]
    scene = Scene(surface, (*effects, default("sensitivity")), ("sensation_db",), 1e-3, SLIDING)
    signal: Signal = Sine(60.0).at(40.0)
    model = felt_by(ElectrovibrationSensation(friction=CoulombFriction(), lag=FrictionLag()))
    observer_db = model.sensation_db(signal, Contact(2.0, 0.05))
    assert abs(run(scene)["sensation_db"] - observer_db) < 0.1


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


def test_accuracy_is_refused_when_it_needs_many_samples():
    fine = panel(default("carrier"), default("skin_leakage"), accuracy=1e-8)
    with pytest.raises(
        InvalidParameter, match=r"accuracy: .* for 'sampling', .*\(n_samples = 4000000\); loosen the accuracy"
    ):
        fine.resolve()


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


def test_unreachable_accuracy_of_output_is_refused_with_reason():
    with pytest.raises(InvalidParameter, match=r"for 'spectrum', .*\(padding = \d+\); loosen the accuracy"):
        panel(default("friction"), default("sensitivity"), outputs=("sensation_db",), accuracy=1e-9).resolve()


# --- order and conflicts


def test_the_order_of_the_tuple_does_not_matter():
    kinds = ("skin_leakage", "air_gap", "body_resistance", "contact_area")
    first, *others = (panel(*map(default, order)).resolve() for order in itertools.permutations(kinds))
    assert all(plan == first for plan in others)


@pytest.mark.parametrize(
    ("effects", "message"),
    [
        (lambda: [default("friction"), default("dry_friction")],
         r"effects\[2\]: found 'dry_friction' with 'friction', expected only one of them .*; remove the other"),
        (lambda: [default("friction"), default("polarity"), default("friction_lag")],
         r"found 'polarity' with 'friction_lag', expected only one of them: .*; remove one of the two"),
        (lambda: [default("friction_lag")],
         r"found 'friction_lag' without an effect in slot friction, .*; add it or remove 'friction_lag'"),
        (lambda: [default("dry_friction")], r"found 'dry_friction' without an effect in slot dynamics"),
        (lambda: [effect("force_law", law="interface")],
         r"effects\[1\]: found 'force_law' with 'force_law', expected only one of them"),
    ],
)  # fmt: skip
def test_contradictory_effects_are_refused_with_fix(effects, message):
    with pytest.raises(InvalidParameter, match=message):
        panel(*effects())


def test_a_finger_at_rest_has_no_friction():
    scene = panel()
    with pytest.raises(InvalidParameter, match=r"'friction' without a sliding contact, .*speed_m_per_s above 0"):
        replace(scene, effects=(*scene.effects, default("friction")), contacts=())


def test_law_without_required_term_is_refused():
    surface = Electrovibration(60.0)
    lossy = (effect("force_law", law="total_thickness"), default("skin_leakage"))
    with pytest.raises(InvalidParameter, match=r"'total_thickness' with 'skin_leakage', .* interface or sc_layer"):
        Scene(surface, lossy, ("peak_force_n",)).resolve()


@pytest.mark.parametrize("kind", ["dc_offset", "skin_leakage", "body_resistance"])
def test_sudden_onset_is_refused_when_effect_relaxes(kind):
    scene = replace(panel(default(kind)), surface=Electrovibration(60.0, duration_s=0.05, ramp_s=0.0))
    with pytest.raises(InvalidParameter, match=rf"{kind}: .*set ramp_s of the tone above 0"):
        scene.resolve()


def test_an_output_without_its_effect_names_the_effect():
    with pytest.raises(InvalidParameter, match=r"no stage or effect for 'friction_force_n'.*; add the effect friction"):
        panel(outputs=("friction_force_n",)).resolve()
    with pytest.raises(
        InvalidParameter, match=r"no stage or effect for 'form', which .* needs.* name one of the four laws"
    ):
        Scene(Electrovibration(60.0), (), ("peak_force_n",)).resolve()


@pytest.mark.parametrize("accuracy", [0.0, -1.0, 1.5, float("nan")])
def test_an_accuracy_outside_of_its_range_is_refused(accuracy):
    with pytest.raises(InvalidParameter, match=r"Scene\.accuracy: found .*, expected a number above 0 and at most 1"):
        panel(accuracy=accuracy)


def test_custom_setting_overrides_chosen_setting():
    scene = replace(panel(outputs=("t_s",)), settings={"sampling": {"n_samples": 33}})
    assert scene.resolve().run({})["t_s"].size == 33
    for bad, message in (
        ({"sampling": {"n_sample": 3}}, r"settings\.sampling\.n_sample: .*did you mean 'n_samples'"),
        ({"samplin": {}}, r"settings\.samplin: .*did you mean 'sampling'"),
    ):
        with pytest.raises(InvalidParameter, match=message):
            replace(scene, settings=bad).resolve()
