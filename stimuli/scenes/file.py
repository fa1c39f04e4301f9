"""Scene files in TOML, read strictly; errors begin with the key path."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from tactometry.config.quantity import as_si
from tactometry.config.strict import build, build_kind, check_keys, convert
from tactometry.config.toml import errors_in, read_table
from tactometry.errors import Gathered, InvalidParameter

from ..composition.effect import Effect, FingerContact
from .effects import EFFECTS
from .scene import Scene
from .surfaces import SURFACES

T = TypeVar("T")


@dataclass(frozen=True)
class SceneFile:
    """Content of a scene file: title, scene and values of the runs."""

    title: str
    scene: Scene
    given: Mapping[str, float]


@dataclass(frozen=True)
class SceneTables:
    """Tables of a scene file: outputs, surface, effects and contacts.

    Parameters
    ----------
    outputs : tuple of str
        Names of the quantities to compute.
    surface : mapping
        ``kind`` of the surface, and its keys.
    title : str
        Title of the figures.
    accuracy : float
        Relative error of the outputs.
    effects : tuple of mapping
        ``kind`` of each effect, and its keys; other effects are not computed.
    contacts : tuple of mapping
        Fingers on the surface.
    given : mapping of str to float
        Values of the quantities that each run needs.
    settings : mapping
        Settings by stage, which replace those chosen for the accuracy.
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
    """Read the scene of a file.

    Raises `InvalidFile` if the file cannot be read or is not TOML, if a key is unknown, missing or of another type, or
    if the scene is invalid. The message begins with the file and the key path.
    """
    path = Path(path)
    table = read_table(path, "a scene file")
    with errors_in(path):
        return scene_of(table)


def scene_of(table: Mapping[str, object]) -> SceneFile:
    """Build the scene of the tables of a scene file.

    >>> tone = {"kind": "electrovibration", "frequency_hz": "240 Hz"}
    >>> scene_of({"outputs": ["voltage_v"], "surface": tone}).scene.surface.frequency_hz
    240.0
    """
    mistakes = Gathered()
    stated = as_si(dict(table), "", mistakes)
    with mistakes.part():
        tables = build(SceneTables, stated, "")
    with mistakes.part():
        surface, effects, contacts = _parts(stated)
    mistakes.end()
    try:
        scene = Scene(surface, effects, tables.outputs, tables.accuracy, contacts, tables.settings or {})
    except InvalidParameter as error:
        raise InvalidParameter(str(error).removeprefix("Scene.")) from None

    given = tables.given or {}
    check_keys(given, scene.surface.given, "given", "quantity")
    return SceneFile(tables.title, scene, convert(dict[str, float], given, "given"))


def _parts(stated: Mapping[str, Any]) -> tuple[Any, tuple[Effect, ...], tuple[FingerContact, ...]]:
    """Build the surface, effects and contacts of a scene."""
    mistakes, surface = Gathered(), None
    if isinstance(stated.get("surface"), Mapping):
        with mistakes.part():
            surface = build_kind(stated["surface"], "surface", SURFACES)
    effects = _all_of(stated, "effects", lambda table, path: build_kind(table, path, EFFECTS), mistakes)
    contacts = _all_of(stated, "contacts", partial(build, FingerContact), mistakes)
    mistakes.end()
    return surface, effects, contacts


def _all_of(
    stated: Mapping[str, Any], key: str, made: Callable[[Mapping[str, Any], str], T], found: Gathered
) -> tuple[T, ...]:
    parts: list[T] = []
    tables = stated.get(key)
    for n, table in enumerate(tables if isinstance(tables, list) else ()):
        if isinstance(table, Mapping):
            with found.part():
                parts.append(made(table, f"{key}[{n}]"))
    return tuple(parts)
