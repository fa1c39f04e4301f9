"""Scene files: TOML, read strictly; an error opens with the key path."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tactometry.config.quantity import as_si
from tactometry.config.strict import build, build_kind, check_keys, convert
from tactometry.config.toml import errors_in, read_table
from tactometry.errors import InvalidParameter

from ..composition.effect import Effect, FingerContact
from .effects import EFFECTS
from .scene import Scene
from .surfaces import SURFACES


@dataclass(frozen=True)
class SceneFile:
    """What a scene file holds: a title, the scene, and the values that a run is given."""

    title: str
    scene: Scene
    given: Mapping[str, float]


@dataclass(frozen=True)
class SceneTables:
    """The physics between an output and the skin: what is computed, on which surface, with which effects.

    Parameters
    ----------
    outputs : tuple of str
        What is computed, by name.
    surface : mapping
        ``kind`` of surface, and its keys.
    title : str
        What figures call it.
    accuracy : float
        Relative error of the outputs.
    effects : tuple of mapping
        ``kind`` of each effect, and its keys; what is not named is not computed.
    contacts : tuple of mapping
        The fingers on it.
    given : mapping of str to float
        Values of the quantities that a run is given.
    settings : mapping
        By stage, settings in place of those that the accuracy chooses.
    """

    outputs: tuple[str, ...]
    surface: dict[str, Any]
    title: str = ""
    accuracy: float = Scene.accuracy
    effects: tuple[dict[str, Any], ...] = ()
    contacts: tuple[dict[str, Any], ...] = ()
    given: dict[str, float] | None = None
    settings: dict[str, dict[str, float | int | str]] | None = None


def load_scene(path: str | Path) -> SceneFile:
    """The scene of a file.

    Raises
    ------
    InvalidFile
        If it cannot be read, is not TOML, a key is unknown, missing or of another type, or the scene cannot be; the
        sentence opens with the file and the key path.
    """
    path = Path(path)
    table = read_table(path, "a scene file")
    with errors_in(path):
        return scene_of(table)


def scene_of(table: Mapping[str, object]) -> SceneFile:
    """The scene of a table as a file holds it.

    >>> tone = {"kind": "electrovibration", "frequency_hz": "240 Hz"}
    >>> scene_of({"outputs": ["voltage_v"], "surface": tone}).scene.surface.frequency_hz
    240.0
    """
    tables = build(SceneTables, as_si(dict(table), ""), "")
    scene = _scene(tables)
    given = tables.given or {}
    check_keys(given, scene.surface.given, "given", "quantity")
    return SceneFile(tables.title, scene, convert(dict[str, float], given, "given"))


def _scene(tables: SceneTables) -> Scene:
    surface, effects = build_kind(tables.surface, "surface", SURFACES), _all_of(tables.effects)
    contacts = tuple(build(FingerContact, touch, f"contacts[{n}]") for n, touch in enumerate(tables.contacts))
    try:
        return Scene(surface, effects, tables.outputs, tables.accuracy, contacts, tables.settings or {})
    except InvalidParameter as error:
        raise InvalidParameter(str(error).removeprefix("Scene.")) from None


def _all_of(tables: tuple[dict[str, Any], ...]) -> tuple[Effect, ...]:
    return tuple(build_kind(table, f"effects[{n}]", EFFECTS) for n, table in enumerate(tables))
