"""Scenes for tests: one per effect, and random ones."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from hypothesis import strategies as st

from tactometry.errors import InvalidParameter
from tactometry.loading import resolve
from tactometry.stimuli.composition.effect import Effect, FingerContact
from tactometry.stimuli.scenes.effects import EFFECTS
from tactometry.stimuli.scenes.scene import Scene
from tactometry.stimuli.scenes.surfaces.electrovibration import Electrovibration
from tactometry.stimuli.scenes.surfaces.hybrid import HybridScreen
from tactometry.stimuli.scenes.surfaces.time_reversal import TimeReversal

SLIDING = (FingerContact(2.0, speed_m_per_s=0.05),)
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
    "skin_mobility": ({"stiffness_n_per_m": 500.0}, ("sensitivity", "friction"), "sensation_db"),
    "weber_fraction": ({}, ("sensitivity", "friction"), "sensation_db"),
    "sensitivity": ({}, ("friction",), "sensation_db"),
    "receptors": ({}, ("friction",), "sensation_db"),
    "summation": ({}, ("receptors", "friction"), "sensation_db"),
    "masking": ({"level_db_re_threshold": 25.0}, ("sensitivity", "friction"), "sensation_db"),
}
"""Optional effects: values, required effects, and an output that each one changes or adds."""


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
    sticks = ("slip_events_s",) if "dry_friction" in kinds else ()
    return surface, tuple(default(kind) for kind in draw(st.permutations(kinds))), (*outputs, *sticks)


def between_events(t_s, event_s, at_s):
    """Return a mask of times in steps without an onset of slip or stick."""
    return ~np.isin(np.searchsorted(t_s, at_s, side="right"), np.searchsorted(t_s, event_s, side="right"))


RESTING = (FingerContact(2.0),)
VOLT = {"voltage_v": 30.0}

TIME_REVERSAL: Mapping[str, tuple[dict[str, object], tuple[str, ...], str]] = {
    "edges": ({"boundary": "CCCC"}, (), "focus_displacement_m"),
    "shear": ({}, (), "focus_displacement_m"),
    "attenuation": ({"tau_s": 2e-3, "exponent": 0.5}, (), "focus_displacement_m"),
    "patches": ({"side_m": 8e-3}, (), "focus_displacement_m"),
    "foci": ({"x_m": (0.09,), "y_m": (0.03,)}, (), "peaks_m"),
    "temperature_drift": ({"kelvin": 20.0}, (), "focus_displacement_m"),
    "amplifier": ({"cutoff_hz": 10e3}, (), "focus_displacement_m"),
    "audible_filter": ({"cutoff_hz": 8e3, "flank_hz": 1e3}, (), "focus_displacement_m"),
    "one_bit": ({}, (), "focus_displacement_m"),
    "sigma_delta": ({"order": 1}, (), "focus_displacement_m"),
    "pulse_width": ({"carrier_hz": 15e3}, (), "focus_displacement_m"),
    "repetition": ({"duration_s": 15e-3}, (), "focus_displacement_m"),
    "finger_load": ({}, (), "contact_displacement_m"),
    "lift_off": ({}, ("finger_load",), "contact_force_n"),
    "movie": ({"n_frames": 3, "span_s": 1e-4}, (), "movie_m"),
    "airborne_sound": ({}, ("attenuation",), "sound_level_dba"),
    "drive_energy": ({}, (), "energy_j"),
    "focus_detection": ({}, (), "sensation_db"),
}
"""As `ELECTROVIBRATION`; an output ``focus_displacement_m`` is one that the plate has without the effect."""


def tuned(kind: str) -> list[Effect]:
    return [effect(name, **TIME_REVERSAL[name][0]) for name in (kind, *TIME_REVERSAL[kind][1])]


def small_screen(**changes: object) -> TimeReversal:
    """60 modes, 8 transducers, 3 ms."""
    values: dict[str, object] = {
        "length_m": 0.12, "width_m": 0.09, "n_transducers": 8, "focus_x_m": 0.05, "focus_y_m": 0.04,
        "f_max_hz": 15e3, "flank_hz": 3e3, "rate_hz": 60e3, "reversal_s": 3e-3, "after_s": 1e-3,
    }  # fmt: skip
    return TimeReversal(**(values | changes))  # type: ignore[arg-type]


def screen(*effects: Effect, outputs: tuple[str, ...] = ("peak_m",), accuracy: float = 0.01) -> Scene:
    """The small screen under a finger at rest."""
    return Scene(small_screen(), effects, outputs, accuracy, RESTING)


@st.composite
def screens(draw: st.DrawFn, outputs: tuple[str, ...]) -> Scene:
    """Plates, places, emissions and effects that go together, in any order."""
    length_m, width_m = draw(st.floats(0.08, 0.3)), draw(st.floats(0.08, 0.2))
    tau_s = draw(st.floats(1e-3, 5e-3))
    band_hz = draw(st.floats(15e3, 40e3))
    surface = TimeReversal(
        length_m=length_m,
        width_m=width_m,
        thickness_m=draw(st.floats(0.7e-3, 2e-3)),
        n_transducers=draw(st.integers(2, 16)),
        focus_x_m=length_m * draw(st.floats(0.2, 0.8)),
        focus_y_m=width_m * draw(st.floats(0.2, 0.8)),
        f_max_hz=band_hz,
        flank_hz=0.1 * band_hz,
        rate_hz=4 * band_hz,
        reversal_s=tau_s * draw(st.floats(0.7, 2.5)),
        after_s=1e-3,
    )
    kinds = draw(st.sets(st.sampled_from(["shear", "patches", "amplifier", "audible_filter", "finger_load"])))
    kinds -= {"shear"} if "finger_load" in kinds else set()
    kinds |= draw(st.sampled_from([set(), {"one_bit"}, {"sigma_delta"}]))
    chosen = [effect(kind, **TIME_REVERSAL[kind][0]) for kind in sorted(kinds)]
    chosen.append(effect("attenuation", tau_s=tau_s))
    return Scene(
        surface, tuple(draw(st.permutations(chosen))), outputs, 1e-2, (FingerContact(draw(st.floats(0.2, 4.0))),)
    )


FOCUSED = ("focus_displacement_m", "peak_m", "contact_force_n")
RUBBED = ("electrostatic_force_n", "friction_force_n")


@st.composite
def hybrids(draw: st.DrawFn) -> Scene:
    """A random panel on a random plate, with a finger at rest and one that slides."""
    rested = draw(screens(FOCUSED))
    tone, rubbed, slid = draw(panels(RUBBED))
    plate = rested.surface
    assert isinstance(plate, TimeReversal)
    x_m, y_m = (side * draw(st.floats(0.2, 0.8)) for side in (plate.length_m, plate.width_m))
    slides = FingerContact(draw(st.floats(0.2, 4.0)), 0.05, x_m, y_m)
    borne = FOCUSED if rested.find("load") else FOCUSED[:-1]
    return replace(
        rested,
        surface=HybridScreen(tone, plate),
        effects=(*rested.effects, *rubbed),
        outputs=("t_s", *borne, "sliding_t_s", *slid),
        contacts=tuple(draw(st.permutations((*rested.contacts, slides)))),
    )


def finest_of(scene: Scene, *accuracies: float) -> Scene:
    return next(finest for finest in (replace(scene, accuracy=value) for value in accuracies) if not refusal(finest))


def refusal(scene: Scene) -> str:
    try:
        scene.resolve()
    except InvalidParameter as refused:
        return str(refused)
    return ""
