"""Scenes for the tests: one effect after the other, and hypothesis's own."""

from collections.abc import Mapping

from hypothesis import strategies as st

from tactometry.stimuli.scenes.effect import Effect, Touch
from tactometry.stimuli.scenes.effects import EFFECTS
from tactometry.stimuli.scenes.scene import Scene
from tactometry.stimuli.scenes.surfaces.electrovibration import Electrovibration
from tactometry.target import resolve

SLIDING = (Touch(2.0, speed_m_per_s=0.05),)
LEVEL = {"level_db_re_1v": 40.0}

ELECTROVIBRATION: Mapping[str, tuple[dict[str, object], tuple[str, ...], str]] = {
    "carrier": ({"carrier_hz": 600.0}, (), "electrostatic_force_n"),
    "dc_offset": ({"ratio": 0.5}, (), "electrostatic_force_n"),
    "texture": ({"period_m": 1e-3}, (), "electrostatic_force_n"),
    "body_resistance": ({"resistance_ohm": 1e5}, (), "electrostatic_force_n"),
    "skin_leakage": ({}, (), "electrostatic_force_n"),
    "air_gap": ({"gap_m": 1e-6}, (), "electrostatic_force_n"),
    "contact_area": ({}, (), "electrostatic_force_n"),
    "polarity": ({"positive_share": 0.5}, (), "electrostatic_force_n"),
    "friction": ({}, (), "friction_force_n"),
    "friction_lag": ({}, ("friction",), "friction_force_n"),
    "dry_friction": ({}, ("finger_dynamics",), "friction_force_n"),
    "finger_dynamics": ({}, ("friction",), "skin_displacement_m"),
    "sensitivity": ({}, ("friction",), "sensation_db"),
}
"""Of each effect that can be on or off: its values, what it needs beside it, an output that it changes or brings."""


def effect(kind: str, **values: object) -> Effect:
    made: Effect = resolve(EFFECTS[kind])(**values)
    return made


def default(kind: str) -> Effect:
    if kind == "force_law":
        return effect("force_law", law="sc_layer")
    return effect(kind, **ELECTROVIBRATION[kind][0])


def panel(*effects: Effect, outputs: tuple[str, ...] = ("electrostatic_force_n",), accuracy: float = 0.01) -> Scene:
    """A tone of 60 Hz for 50 ms under a sliding finger, in the sc_layer law."""
    surface = Electrovibration(60.0, duration_s=0.05, ramp_s=0.01)
    return Scene(surface, (effect("force_law", law="sc_layer"), *effects), outputs, accuracy, SLIDING)


def with_needs(kind: str) -> list[Effect]:
    return [default(name) for name in (kind, *ELECTROVIBRATION[kind][1])]


RAMPED = {"dc_offset", "skin_leakage", "body_resistance"}
SPECTRAL = {"carrier", "dc_offset", "texture"}
"""Effects that multiply the sinusoids, and with their square the size of an exact motion's exponentials."""


@st.composite
def panels(draw: st.DrawFn, outputs: tuple[str, ...]) -> tuple[Electrovibration, tuple[Effect, ...], tuple[str, ...]]:
    """A surface, effects that go together in any order, and those outputs."""
    free = st.sets(
        st.sampled_from(
            ["carrier", "dc_offset", "texture", "body_resistance", "skin_leakage", "air_gap", "contact_area"]
        ),
        max_size=3,
    )
    chosen = draw(free)
    surface = Electrovibration(
        draw(st.floats(20.0, 300.0)),
        duration_s=draw(st.floats(0.03, 0.06)),
        ramp_s=draw(st.sampled_from([0.005, 0.01] if RAMPED & chosen else [0.0, 0.005])),
        insulator_thickness_m=draw(st.floats(5e-7, 1e-5)),
    )
    kinds = ["force_law", *sorted(chosen)]
    lifted = [["friction", "friction_lag"], ["friction", "finger_dynamics"]] if len(SPECTRAL & chosen) < 2 else []
    kinds += draw(
        st.sampled_from([["friction"], ["friction", "polarity"], ["dry_friction", "finger_dynamics"], *lifted])
    )
    return surface, tuple(default(kind) for kind in draw(st.permutations(kinds))), outputs
