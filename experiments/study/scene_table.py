"""The table `[scene]`, which replaces the default scene of a stimulus.

A study states what is played in `[stimulus]` and who touches it in `[touch]`; the scene holds what is between them.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Final

from tactometry.arguments.require import expect
from tactometry.config.strict import build, build_kind, check_keys
from tactometry.errors import rewording
from tactometry.loading import resolve
from tactometry.protocols.tasks.touch import Sliding, Touch
from tactometry.stimuli.composition.effect import Effect, Surface
from tactometry.stimuli.scenes.effects import EFFECTS
from tactometry.stimuli.scenes.scene import SENSATION, Scene
from tactometry.stimuli.scenes.surfaces import SURFACES

from ..scenes import path_of
from .felt_scene import FeltScene, felt
from .procedure_table import without

SUCH_AS: Final = {
    "electrovibration": "electrovibration-panel",
    "time_reversal": "a4-screen",
    "hybrid": "hybrid-screen",
}
TONE: Final = ("frequency_hz", "duration_s", "ramp_s")
SILENT: Final = {"kind": "electrovibration", "frequency_hz": 1.0}
"""The tone of a panel, whose place is taken by what is played."""
Parts = tuple[dict[str, Any], tuple[Effect, ...]]


@dataclass(frozen=True)
class SceneTable:
    """Physics between the stimulus and the skin.

    Parameters
    ----------
    name : str
        Built-in scene or scene file that supplies surface and effects.
    surface : mapping
        ``kind`` and the keys of a scene's surface, without those of the tone.
    effects : tuple of mapping
        Effects as in a scene file, with at least a force law, friction and a threshold.
    accuracy : float
        Relative error of the amplitude that is felt; 0.05 is 0.4 dB.
    """

    name: str = ""
    surface: dict[str, Any] = field(default_factory=dict)
    effects: tuple[dict[str, Any], ...] = ()
    accuracy: float = 0.05

    def __post_init__(self) -> None:
        both = f"{self.name!r} beside surface or effects"
        expect(not (self.name and (self.surface or self.effects)), "SceneTable.name", both, "one of the two")
        expect(0 < self.accuracy <= 1, "SceneTable.accuracy", self.accuracy, "above 0 and at most 1")


def felt_scene(table: Mapping[str, Any], surface: str, stimulus: Any, touch: Touch) -> FeltScene:
    """Build the scene of a table on a surface, under a stimulus and touch.

    Raises
    ------
    InvalidParameter
        If the table holds what a scene does not know, no scene plays such a stimulus, or it gives no sensation so
        accurately under this touch: one sentence that opens with the key.
    """
    expected = "another kind; remove [scene]: what is felt or read of it stands in [sensation]"
    expect(surface in PLAYED, "scene", "a table with a stimulus that no scene plays", expected)
    read = build(SceneTable, table, "scene")
    stated, effects = _parts_of_scene(read.name, surface) if read.name else _parts_of_table(read, surface)
    rests = surface == "electrovibration" and not isinstance(touch, Sliding)
    expect(not rests, "touch.kind", "'press' with a [scene]", "'slide': friction is felt in motion")
    with rewording(_in_study):
        played = PLAYED[surface](stated, stimulus, "surface")
        scene = Scene(played, effects, (SENSATION,), read.accuracy, played.touches)
        scene.felt().resolve()
        return felt(scene)


def _panel(stated: Mapping[str, Any], stimulus: Any, where: str) -> Any:
    """Build an electrode with layers stated as in a scene file."""
    for name in TONE:
        expect(name not in stated, f"{where}.{name}", "what [stimulus] states", "it there alone; remove it")
    panel: Any = build_kind({**SILENT, **stated, "duration_s": stimulus.duration_s}, where, SURFACES)
    return panel.played()


def _plate(stated: Mapping[str, Any], stimulus: Any, where: str) -> Any:
    """Build a plate from the stimulus, with the places of the fingers."""
    shared = {name: getattr(stimulus, name) for name in ("setup", "places") if hasattr(stimulus, name)}
    touched = "played_plates:PlayedFingers" if "places" in shared else "played_plates:PlayedTimeReversal"
    played = resolve(f"tactometry.stimuli.scenes.surfaces.{touched}")
    return build(played, without(stated, "kind"), where, **shared)


def _both(stated: Mapping[str, Any], stimulus: Any, where: str) -> Surface:
    """Build a plate with an electrode."""
    check_keys(stated, ("kind", "electrovibration", "time_reversal"), where)
    panel = _panel(stated.get("electrovibration", {}), stimulus, f"{where}.electrovibration")
    from tactometry.stimuli.scenes.surfaces.played_plates import PlayedHybrid

    return PlayedHybrid(panel, _plate(stated.get("time_reversal", {}), stimulus, f"{where}.time_reversal"))


PLAYED: Final[Mapping[str, Callable[[Mapping[str, Any], Any, str], Surface]]] = {
    "electrovibration": _panel,
    "time_reversal": _plate,
    "hybrid": _both,
}
"""By the kind of a surface, how it comes from the table `surface` and a stimulus."""


def _parts_of_table(read: SceneTable, surface: str) -> Parts:
    """Return the surface and effects of the table itself."""
    kind = read.surface.get("kind", surface)
    where = "where levels of a factor are played on several, state each as [variants.FACTOR.LEVEL.scene]"
    expect(kind == surface, "scene.surface.kind", repr(kind), f"{surface!r}, which the stimulus is played on; {where}")
    effects = tuple(build_kind(table, f"scene.effects[{n}]", EFFECTS) for n, table in enumerate(read.effects))
    for n, effect in enumerate(effects):
        changes = f"{effect.kind!r}, which changes what is played or on what"
        known = effect.kind in resolve(SURFACES[surface]).effects
        expect(
            not (known and effect.in_signal), f"scene.effects[{n}]", changes, "what [stimulus] states alone; remove it"
        )
    return read.surface, effects


def _parts_of_scene(name: str, surface: str) -> Parts:
    """Return the surface and effects of a built-in scene or a scene file.

    Parts that the stimulus states are left out.
    """
    from tactometry.stimuli.scenes.file import load_scene  # imports what its effects need

    with rewording(lambda words: words.replace("FILE", "scene.name", 1)):
        path = path_of(name)
    scene = load_scene(path).scene
    of = getattr(scene.surface, surface, scene.surface)  # of a hybrid screen the side that is played on
    kind = of.kind
    expected = f"one on {surface!r}, such as {SUCH_AS[surface]!r}"
    expect(kind == surface, "scene.name", f"{name!r}, a scene on {kind!r}", expected)
    levels = tuple(output for output in scene.outputs if output.endswith(SENSATION)) or (SENSATION,)
    with rewording(_in_study):
        idle = replace(scene, outputs=levels).off()
    on_it = (one for one in scene.effects if one.kind in of.effects)
    return _stated(of), tuple(one for one in on_it if not one.in_signal and one not in idle)


def _stated(surface: Surface) -> dict[str, Any]:
    """Return the values of a surface that the stimulus leaves open."""
    if surface.kind == "hybrid":
        return {"electrovibration": _stated(vars(surface)["electrovibration"])}
    return without(vars(surface), *TONE) if surface.kind == "electrovibration" else {}


def _in_study(refusal: str) -> str:
    words = refusal.removeprefix("Scene.")
    return f"scene.{words}" if words.startswith(("effects", "accuracy", "surface")) else f"scene: {words}"
