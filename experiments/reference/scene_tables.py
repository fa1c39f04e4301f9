"""The tables of a scene file, and of the file of a plate."""

from collections.abc import Iterator, Mapping
from typing import Final

from tactometry.stimuli.scenes.effects import EFFECTS
from tactometry.stimuli.scenes.surfaces import SURFACES

from .key_table import KeyTable, Values

_SURFACES: Final[Mapping[str, Values]] = {
    "electrovibration": {"frequency_hz": 240.0},
    "hybrid": {"electrovibration": {"frequency_hz": 240.0}},
}
_EFFECTS: Final[Mapping[str, Values]] = {
    "dc_offset": {"ratio": 0.5},
    "texture": {"period_m": 1e-3},
    "body_resistance": {"resistance_ohm": 1e4},
    "air_gap": {"gap_m": 1e-6},
    "force_law": {"law": "sc_layer"},
    "polarity": {"positive_share": 0.5},
    "masking": {"level_db_re_threshold": 25.0},
    "edges": {"boundary": "FFFF"},
    "attenuation": {"tau_s": 3.5e-3},
    "foci": {"x_m": [0.2], "y_m": [0.1]},
    "temperature_drift": {"kelvin": 10.0},
    "pulse_width": {"carrier_hz": 1e5},
    "cross_masking": {"target": "foci"},
}
_SCENE: Final[Values] = {
    "outputs": ["voltage_v", "t_s"],
    "surface": {"kind": "electrovibration", "frequency_hz": 240.0},
}
_OF_SCENE: Final[Values] = {
    "effects": [{"kind": "force_law", "law": "sc_layer"}],
    "contacts": [{"force_n": 1.0, "speed_m_per_s": 0.05}],
    "given": {"level_db_re_1v": 40.0},
    "settings": {"sampling": {"rate_hz": 20e3}},
}
_PLATE: Final[Values] = {
    "length_m": 0.297, "width_m": 0.210, "thickness_m": 1.1e-3, "youngs_modulus_pa": 64e9, "poisson_ratio": 0.2,
    "density_kg_per_m3": 2230.0, "boundary": "FFFF",
}  # fmt: skip


def scene_tables() -> Iterator[KeyTable]:
    """The file itself, its surface, the fingers on it and each effect."""
    composed = "tactometry.stimuli.composition.effect:FingerContact"
    place = {"x_m": 0.1, "y_m": 0.1}
    read = "tactometry.stimuli.scenes.file:SceneTables"
    yield KeyTable("scene", "", read, example=_SCENE, samples=_OF_SCENE)
    for kind, target in SURFACES.items():
        yield KeyTable(f"scene.surface.{kind}", "[surface]", target, kind, example=_SURFACES.get(kind, {}))
    yield KeyTable("scene.contacts", "[[contacts]]", composed, example={"force_n": 1.0}, samples=place)
    yield from (_effect(kind, target) for kind, target in EFFECTS.items())


def _effect(kind: str, target: str) -> KeyTable:
    name, samples = f"scene.effects.{kind}", {"n_frames": 60}
    return KeyTable(name, "[[effects]]", target, kind, example=_EFFECTS.get(kind, {}), samples=samples)


def plate_tables() -> Iterator[KeyTable]:
    """The file of a plate."""
    plate = "tactometry.stimuli.time_reversal.plate"
    yield KeyTable("plate", "", f"{plate}.plate:Plate", example=_PLATE, also=("plate.glass",))
    yield KeyTable("plate.glass", "", f"{plate}.glass:NamedGlass", example={"glass": "Borofloat 33"})
