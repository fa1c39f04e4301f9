"""Pairs of effects that a study may combine."""

from collections.abc import Iterator
from math import log10

import pytest
from scene_cases import ELECTROVIBRATION, TIME_REVERSAL, effect

from tactometry.contact import Contact
from tactometry.errors import InvalidParameter
from tactometry.loading import resolve
from tactometry.stimuli.composition.effect import Effect
from tactometry.stimuli.electrovibration import AmplitudeModulated
from tactometry.stimuli.hybrid import Hybrid
from tactometry.stimuli.scenes.effects import EFFECTS, OF_ELECTROVIBRATION, OF_TIME_REVERSAL
from tactometry.stimuli.scenes.scene import SENSATION, Scene
from tactometry.stimuli.scenes.surfaces.electrovibration import PlayedElectrovibration
from tactometry.stimuli.scenes.surfaces.played_plates import PlayedHybrid, PlayedTimeReversal
from tactometry.stimuli.time_reversal.stimulus.focus_train import FocusTrain
from tactometry.stimuli.time_reversal.stimulus.setup import Setup

SETUP = Setup(n_transducers=4, modes_to_hz=22e3, rate_hz=50e3)
FOCUS = FocusTrain(SETUP, f_max_hz=20e3, duration_s=0.1, voltage_max_v=2e3)
TONE = AmplitudeModulated(120.0, duration_s=0.1, ramp_s=0.01, rate_hz=50e3)
TOUCH = Contact(1.5, 0.05)
OTHER = {
    "force_law": {"law": "interface"},
    "body_resistance": {"resistance_ohm": 1e5},
    "friction": {"coefficient": 0.8},
    "weber_fraction": {"reference_n": 2.0},
    "sensitivity": {"reference_m": 2e-7},
    "receptors": {"reference_m": 2e-7},
    "focus_detection": {"reference_m": 8e-6},
}
"""Values that a level differs by from that of the defaults."""
VALUES = {kind: case[0] for kind, case in (ELECTROVIBRATION | TIME_REVERSAL).items()} | OTHER
PANEL, PLATE = PlayedElectrovibration(duration_s=TONE.duration_s), PlayedTimeReversal(SETUP)
BOTH = PlayedHybrid(PANEL, PLATE)
SIGNALS = {PANEL.kind: TONE.at(40.0), PLATE.kind: FOCUS.at(20.0), BOTH.kind: Hybrid(FOCUS, TONE, 20.0).at(20.0)}
LEAST = {
    PANEL.kind: (effect("force_law", law="sc_layer"), effect("friction"), effect("sensitivity")),
    PLATE.kind: (effect("focus_detection"),),
}
UNFELT = {"movie", "drive_energy"}
"""What reads the plate beside what is felt of it: told as what no output needs."""


def kinds(of_surface) -> list[str]:
    return [kind for kind in of_surface if not resolve(EFFECTS[kind]).in_signal]


def level_db(surface, *stated: Effect) -> float:
    """Return the level of the smallest scene with these effects."""
    slots = {one.slot for one in stated}
    threshold = "sensitivity" if "receptors" in slots else "receptors" if "summation" in slots else ""
    added = (effect("receptors"),) if threshold == "receptors" and "receptors" not in slots else ()
    least = LEAST[PANEL.kind] + LEAST[PLATE.kind] if surface is BOTH else LEAST[surface.kind]
    kept = (one for one in least if one.slot not in slots and not (threshold and one.kind == "sensitivity"))
    scene = Scene(surface, (*kept, *added, *stated), (SENSATION,), 0.05, surface.touches)
    assert {one.kind for one in scene.felt().off()} == UNFELT & {one.kind for one in stated}
    return scene.sensation(SIGNALS[surface.kind], TOUCH)


def pairs() -> Iterator[object]:
    for surface, of_surface in ((PANEL, OF_ELECTROVIBRATION), (PLATE, OF_TIME_REVERSAL)):
        for first in kinds(of_surface):
            yield pytest.param(surface, first, kinds(of_surface), id=first)


def felt(surface, *stated: Effect) -> float | str:
    """Return the level, or the message of the refusal."""
    try:
        return level_db(surface, *stated)
    except InvalidParameter as refused:
        return str(refused)


@pytest.mark.parametrize(("surface", "first", "others"), [*pairs()])
def test_effect_pair_is_felt_or_refused(surface, first, others) -> None:
    for second in others[others.index(first) + 1 :]:
        stated = [effect(kind, **VALUES[kind]) for kind in (first, second)]
        both = felt(surface, *stated)
        if isinstance(both, str):
            assert ": found " in both
            assert ", expected " in both
            continue
        for one, other in (stated, stated[::-1]):
            assert (felt(surface, one) == both) == (other.kind in UNFELT), (first, second)


@pytest.mark.parametrize("of_plate", ["finger_load", "focus_detection"])
def test_hybrid_sides_feel_their_own_effects(of_plate) -> None:
    on_plate = effect(of_plate, **VALUES[of_plate])
    plate_db = level_db(PLATE, on_plate)
    for kind in ("weber_fraction", "air_gap", "body_resistance", "finger_dynamics", "receptors"):
        on_panel = effect(kind, **VALUES[kind])
        assert level_db(BOTH, on_plate, on_panel) == pytest.approx(max(plate_db, level_db(PANEL, on_panel)), abs=1e-6)


def test_weber_fraction_applies_with_dynamics_and_lag() -> None:
    """Weber's law had no effect when applied before the pad moved."""
    for kind in ("finger_dynamics", "friction_lag"):
        once_db, twice_db = (level_db(PANEL, effect(kind), effect("weber_fraction", reference_n=n)) for n in (1.0, 2.0))
        assert twice_db - once_db == pytest.approx(20 * log10(2), abs=1e-9)
