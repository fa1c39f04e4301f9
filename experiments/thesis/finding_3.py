"""Finding 3: effects of frequency and force on thresholds.

Electrovibration thresholds are lowest at 240 Hz, and force lowers only those above 240 Hz.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from tactometry.contact import Contact
from tactometry.stimuli.electrovibration.attraction.force import LAWS
from tactometry.stimuli.scenes.file import scene_of
from tactometry.stimuli.scenes.surfaces.electrovibration import tone

from . import force_spread
from .reproduction import Number, Origin

FREQUENCIES_HZ = (60.0, 120.0, 180.0, 240.0, 320.0, 480.0)
FORCES_N = (0.5, 3.0)
BELOW_HZ, ABOVE_HZ = (60.0, 120.0, 240.0), 480.0
BEST_HZ = 240.0
LIMITED_DB, MORE_DB = 1.0, 0.01
DEFAULT_NAME, AS_STATED = "default", "sine instead of a carrier"
CHOSEN_INPUTS = frozenset({"carrier", "dc_offset"})
"""Inputs that were chosen for the frequency at which their force vibrates."""
STIFFER = "stiffness of the skin as F^(2/3)"
FORCE_IS_PUT_IN = ("area that no force changes", "friction coefficient as F^(-1/3)", STIFFER)
"""Variants that assume the influence of force, or were chosen for it."""
LEVEL_DB, SPEED_M_PER_S, DURATION_S, ACCURACY = 30.0, 0.05, 0.5, 5e-4
RAMP_S = 0.05
LAW = "sc_layer"
Effects = Mapping[str, Mapping[str, Any]]
DEFAULT: Effects = {
    "carrier": {},
    "skin_leakage": {},
    "contact_area": {},
    "force_law": {"law": LAW},
    "friction": {},
    "friction_lag": {},
    "sensitivity": {},
}
"""The scene of the built-in study: a square-root carrier under a finger of Hertz's area at a fixed force."""


def variants() -> dict[str, Effects]:
    """Return the default, and variants without or with a changed effect."""

    def without(*kinds: str, **others: Any) -> Effects:
        return {kind: table for kind, table in DEFAULT.items() if kind not in kinds} | others

    resistive = {"resistance_ohm": 1e4}
    return {
        DEFAULT_NAME: DEFAULT,
        AS_STATED: without("carrier"),
        "sine and a constant of its peak": without("carrier", dc_offset={"ratio": 1.0}),
        "the same, no leakage": without("carrier", "skin_leakage", dc_offset={"ratio": 1.0}),
        "no leakage": without("skin_leakage"),
        **{
            f"force law {law}, no leakage": without("skin_leakage", force_law={"law": law})
            for law in LAWS
            if law != LAW
        },
        "force law interface": without(force_law={"law": "interface"}),
        "force law interface, air gap of 10 um": without(force_law={"law": "interface"}, air_gap={"gap_m": 1e-5}),
        "area that no force changes": without(contact_area={"exponent": 0.0}),
        "area as F^(2/3)": without(contact_area={"exponent": 2 / 3}),
        "friction coefficient as F^(-1/3)": without(friction={"load_exponent": -1 / 3}),
        "no lag of friction": without("friction_lag"),
        "body resistance of 10 kohm": without(body_resistance=resistive),
        "sine, body resistance of 10 kohm": without("carrier", body_resistance=resistive),
        STIFFER: without(skin_mobility={"stiffness_exponent": 2 / 3}),
        "a pulp that only its damping holds": without(skin_mobility={"stiffness_n_per_m": 1.0, "mass_kg": 0.0}),
        "a pad that slides": without("friction_lag", finger_dynamics={}),
        "the same, damped by 0.05 N s/m": without("friction_lag", finger_dynamics={"damping_n_s_per_m": 0.05}),
        "three channels instead of one threshold": without("sensitivity", receptors={}),
        "area summed by Pacini": without("sensitivity", receptors={}, summation={}),
        "a fixed fraction of the load is detected": without(weber_fraction={}),
    }


def numbers() -> list[Number]:
    compared = [number for name, effects in variants().items() for number in _comparison(name, effects)]
    built_in_db = {f_hz: thresholds_db(DEFAULT, f_hz, [1.0])[0] for f_hz in force_spread.FREQUENCIES_HZ}
    return [*compared, *force_spread.numbers(built_in_db), *_sticking()]


def _comparison(name: str, effects: Effects) -> Iterator[Number]:
    low_n, high_n = FORCES_N
    low_db, high_db = np.transpose([thresholds_db(effects, f_hz, FORCES_N) for f_hz in FREQUENCIES_HZ])
    levels_db = dict(zip(FREQUENCIES_HZ, low_db.tolist(), strict=True))
    changes_db = dict(zip(FREQUENCIES_HZ, (high_db - low_db).round(6).tolist(), strict=True))
    below_db, above_db = [changes_db[f_hz] for f_hz in BELOW_HZ], changes_db[ABOVE_HZ]

    best_hz = min(levels_db, key=lambda f_hz: levels_db[f_hz])
    origin: Origin = "assumed" if effects.keys() & CHOSEN_INPUTS else "derived"
    best = Number("lowest threshold at", name, best_hz, "Hz", origin, is_variant=name not in (DEFAULT_NAME, AS_STATED))
    yield replace(best, stated="240 Hz", holds=best_hz == BEST_HZ)

    span = f"from {low_n:g} to {high_n:g} N"
    change = replace(best, value=0.0, unit="dB", origin="assumed" if name in FORCE_IS_PUT_IN else "derived")
    for f_hz, change_db in zip(BELOW_HZ, below_db, strict=True):
        yield replace(change, quantity=f"{span}, {f_hz:g} Hz", value=change_db)
    largest_db = max(below_db, key=abs)
    limited = replace(change, stated="limited influence", holds=abs(largest_db) <= LIMITED_DB)
    yield replace(limited, quantity=f"{span}, largest to {BEST_HZ:g} Hz", value=largest_db)
    falls = above_db < min(*below_db, 0.0) - MORE_DB
    lowered = replace(change, stated="falls, more than up to 240 Hz", holds=falls)
    yield replace(lowered, quantity=f"{span}, {ABOVE_HZ:g} Hz", value=above_db)


def _sticking() -> Iterator[Number]:
    """Yield levels of a finger that sticks and slips, gated or not."""
    sliding = {kind: table for kind, table in DEFAULT.items() if kind not in ("friction", "friction_lag")}
    for name, gated in (("gated", True), ("not gated", False)):
        effects = sliding | {"dry_friction": {"gated": gated}, "finger_dynamics": {}}
        for force_n, felt_db in zip(FORCES_N, felt_levels_db(effects, BEST_HZ, FORCES_N), strict=True):
            quantity = f"felt at {LEVEL_DB:g} dB re 1 V, {BEST_HZ:g} Hz, {force_n:g} N"
            part = "A finger that sticks before it slips"
            yield Number(quantity, name, round(felt_db, 3), "dB", "derived", is_variant=True, part=part)


def thresholds_db(effects: Effects, frequency_hz: float, forces_n: Sequence[float]) -> list[float]:
    """Return the level (dB re 1 V peak) felt at 0 dB, at each force.

    Attraction is quadratic: 1 dB of voltage is 2 dB of force.
    """
    return [LEVEL_DB - felt_db / 2 for felt_db in felt_levels_db(effects, frequency_hz, forces_n)]


def felt_levels_db(effects: Effects, frequency_hz: float, forces_n: Sequence[float]) -> list[float]:
    """Return the sensation level (dB) of 30 dB re 1 V at each force."""
    sine = {"frequency_hz": frequency_hz, "duration_s": DURATION_S, "ramp_s": RAMP_S}
    table = {
        "outputs": ["sensation_db"],
        "accuracy": ACCURACY,
        "surface": {"kind": "electrovibration", **sine},
        "contacts": [{"force_n": 1.0, "speed_m_per_s": SPEED_M_PER_S}],
        "effects": [{"kind": kind, **values} for kind, values in effects.items()],
    }
    scene = scene_of(table).scene
    waveform = tone(**sine)
    makers: list[Any] = [effect for effect in scene.effects if effect.in_signal]
    for maker in makers:
        waveform = maker(waveform)
    signal = waveform.at(LEVEL_DB)
    contacts = (Contact(force_n, SPEED_M_PER_S) for force_n in forces_n)
    return [scene.sensation(signal, contact) for contact in contacts]
