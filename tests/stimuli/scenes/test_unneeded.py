"""Effects that no output needs: they change no plan or result."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scene_cases import (
    ELECTROVIBRATION,
    LEVEL,
    RESTING,
    SLIDING,
    TIME_REVERSAL,
    VOLT,
    default,
    effect,
    panel,
    screen,
    small_screen,
    tuned,
    with_needs,
)

from tactometry.errors import InvalidParameter
from tactometry.experiments.scenes import names, path_of
from tactometry.stimuli.composition.effect import FingerContact
from tactometry.stimuli.scenes.explain import explanation
from tactometry.stimuli.scenes.file import load_scene
from tactometry.stimuli.scenes.scene import Scene
from tactometry.stimuli.scenes.surfaces.electrovibration import Electrovibration
from tactometry.stimuli.scenes.surfaces.hybrid import HybridScreen

PANEL = (
    "t_s", "voltage_v", "electrostatic_force_n", "peak_force_n", "friction_force_n", "skin_displacement_m",
    "slip_events_s", "channels_db", "sensation_db",
)  # fmt: skip
PLATE = (
    "peak_m", "peaks_m", "t_s", "focus_displacement_m", "x_m", "y_m", "field_m", "frames_s", "movie_m",
    "contact_displacement_m", "contact_force_n", "sound_level_dba", "energy_j", "power_w", "sensation_db",
)  # fmt: skip
BOTH = (
    *PLATE, "sliding_t_s", "electrode_voltage_v", "sliding_sensation_db",
    *(name for name in PANEL if name not in {"t_s", "voltage_v", "sensation_db"}),
)  # fmt: skip
OUTPUTS = {"electrovibration": PANEL, "time_reversal": PLATE, "hybrid": BOTH}
COMPANY = {
    "electrovibration": [effect("force_law", law="sc_layer")],
    "time_reversal": [],
    "hybrid": [effect("force_law", law="sc_layer")],
}
BARE = {
    "electrovibration": Scene(Electrovibration(5.0, 0.4, 0.05), (), ("voltage_v",), 0.05, SLIDING),
    "time_reversal": Scene(small_screen(), (), ("peak_m",), 0.1, RESTING),
    "hybrid": Scene(
        HybridScreen(Electrovibration(5.0, 0.4, 0.05), small_screen()),
        (),
        ("peak_m",),
        0.1,
        (FingerContact(2.0), FingerContact(2.0, 0.05, 0.09, 0.06)),
    ),
}
"""Slow tones: there the swing of a finger pad is the fastest thing in the scene."""


def scenes():
    """Return every surface with its smallest scene, and built-in scenes."""
    for kind, scene in BARE.items():
        yield f"bare {kind}", replace(scene, effects=tuple(COMPANY[kind]))
    for name in names():
        yield name, load_scene(path_of(name)).scene


SCENES = dict(scenes())
EVERY = [(name, kind) for name, scene in SCENES.items() for kind in scene.surface.effects]
MASKING = {
    ("time_reversal", "masking"): [effect("masking", level_db_re_threshold=25.0), effect("focus_detection")],
    ("hybrid", "cross_masking"): [
        effect("cross_masking", target="foci"), effect("focus_detection"), *with_needs("sensitivity")
    ],
}  # fmt: skip
"""Of a surface and an effect that another surface knows by other needs, or none does."""


def needs_of(kind, surface):
    if (surface, kind) in MASKING:
        return MASKING[surface, kind]
    return tuned(kind) if kind in TIME_REVERSAL else with_needs(kind) if kind in ELECTROVIBRATION else [default(kind)]


def pair(scene, kind):
    """The effects of a scene without one and with it: what shares a slot with it or acts on it is left out."""
    mine, *needs = [found for found in scene.effects if found.kind == kind] or needs_of(kind, scene.surface.kind)
    added = (mine, *needs)
    slots = {found.slot for found in added}
    barred = {name for found in added for name in (found.kind, *found.excludes)}
    company = [found for found in scene.effects if found.slot not in slots and mine.slot not in found.requires]
    company = [found for found in company if found.kind not in barred and barred.isdisjoint(found.excludes)]
    apart = [found for found in needs if mine.slot not in found.requires]
    return (*company, *apart), (*company, *needs, mine)


def requested(name, output, effects):
    scene = SCENES[name]
    return replace(scene, outputs=(output,), settings={}, contacts=scene.contacts or RESTING, effects=effects)


@cache
def plan_if_had(name, output, effects):
    try:
        return requested(name, output, effects).resolve()
    except InvalidParameter:
        return None


def unneeded(name, kind):
    """Yield each output that does not need an effect, and both plans.

    The first plan is without the effect, the second with it.
    """
    without, with_it = pair(SCENES[name], kind)
    for output in OUTPUTS[SCENES[name].surface.kind]:
        one = plan_if_had(name, output, without)
        if one is not None:
            both = requested(name, output, with_it)
            if kind in {found.kind for found in both.off()}:
                yield output, one, both.resolve()


ALWAYS = {"carrier", "dc_offset", "texture"}
"""Every output of a panel alone comes behind its voltage."""


@pytest.mark.parametrize(("name", "kind"), EVERY)
def test_unneeded_effect_leaves_plan_unchanged(name, kind):
    plans = list(unneeded(name, kind))
    found = [output for output, one, both in plans if one == both]
    assert found == [output for output, _, _ in plans]
    panel_alone = SCENES[name].surface.kind == "electrovibration"
    assert bool(found) is not (panel_alone and kind in ALWAYS)


KINDS = {"electrovibration": tuple(ELECTROVIBRATION), "time_reversal": tuple(TIME_REVERSAL)}
HEAVY = {"movie_m", "field_m", "sound_level_dba", "energy_j", "slip_events_s"}


@pytest.mark.parametrize(("side", "kind"), [(side, kind) for side in KINDS for kind in KINDS[side]])
def test_unneeded_effect_leaves_output_bytes_unchanged(side, kind):
    given = {**LEVEL, **VOLT}
    for output, one, both in unneeded(f"bare {side}", kind):
        if output in HEAVY:
            continue
        values = [np.asarray(plan.run({name: given[name] for name in plan.given})[output]) for plan in (one, both)]
        assert values[0].tobytes() == values[1].tobytes()


def test_finger_pad_and_body_leave_expected_outputs_unchanged():
    """Friction in full slip knows no motion, and nothing behind the output changes its voltage."""
    pad = [output for output, _, _ in unneeded("bare electrovibration", "finger_dynamics")]
    assert pad == ["t_s", "voltage_v", "electrostatic_force_n", "peak_force_n", "friction_force_n"]
    body = [output for output, _, _ in unneeded("bare electrovibration", "body_resistance")]
    assert body == ["t_s", "voltage_v"]


def words(scene, given):
    """The explanation but for the times that were measured."""
    lines = explanation(scene, given).splitlines()
    return [
        line[:82].rstrip() if not line.startswith("accuracy") else line.partition(", measured")[0] for line in lines
    ]


def others(lines, kinds):
    """Lines of other effects."""
    return [line for line in lines if line.partition(" ")[0] not in kinds]


@pytest.mark.parametrize(
    ("side", "kind"), [(side, kind) for side in KINDS for kind in KINDS[side] if kind not in ALWAYS]
)
def test_explanation_lists_unneeded_effect_as_off(side, kind):
    scene = SCENES[f"bare {side}"]
    output = next(output for output, _, _ in unneeded(f"bare {side}", kind))
    without, with_it = (replace(scene, outputs=(output,), effects=effects) for effects in pair(scene, kind))
    lines = words(with_it, {**LEVEL, **VOLT})
    off = next(line for line in lines if line.startswith(kind))
    assert off.split() == [kind, "off", "no", "output", "needs", "it"]
    added = {found.kind for found in with_it.effects} - {found.kind for found in without.effects}
    assert others(lines, added) == others(words(without, {**LEVEL, **VOLT}), added)


@pytest.mark.parametrize(
    ("scene", "output"),
    [
        (replace(panel(default("skin_leakage")), surface=Electrovibration(60.0, 0.05, 0.0)), "voltage_v"),
        (replace(panel(default("body_resistance")), surface=Electrovibration(60.0, 0.05, 0.0)), "voltage_v"),
        (screen(effect("movie", n_frames=400_000, span_s=1e-4), accuracy=1e-3), "focus_displacement_m"),
        (screen(effect("movie", span_s=1.0)), "peak_m"),
    ],
)
def test_unneeded_effects_are_not_refused(scene, output):
    replace(scene, outputs=(output,)).resolve()


def test_unneeded_hybrid_side_is_not_refused():
    fine = replace(BARE["hybrid"], outputs=("electrode_voltage_v",), accuracy=1e-10)
    fine.resolve()
    with pytest.raises(InvalidParameter, match="expected at most"):
        replace(fine, outputs=("peak_m",)).resolve()
