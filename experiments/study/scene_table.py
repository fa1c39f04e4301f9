"""The table `[scene]`: the physics between a stimulus and a simulated skin, in place of the default formula.

A study states what is played in `[stimulus]` and who touches it in `[touch]`; the scene holds what is between them.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

from tactometry.arguments.require import expect
from tactometry.config.strict import build, build_kind
from tactometry.contact import Contact
from tactometry.errors import nearest, rewording
from tactometry.protocols.tasks.touch import Sliding, Touch
from tactometry.signal import Signal
from tactometry.stimuli.composition.effect import Effect
from tactometry.stimuli.electrovibration.waveforms.kinds import WAVEFORMS
from tactometry.stimuli.scenes.effects import EFFECTS
from tactometry.stimuli.scenes.file import load_scene
from tactometry.stimuli.scenes.scene import SENSATION, Scene
from tactometry.stimuli.scenes.surfaces import SURFACES

from ..scenes import names, path_of

KIND: Final = "electrovibration"
TONE: Final = ("frequency_hz", "duration_s", "ramp_s")
SILENT: Final = {"frequency_hz": 1.0}
"""The tone of a panel, whose place is taken by what is played."""


@dataclass(frozen=True)
class SceneTable:
    """What lies between the stimulus and the skin.

    Parameters
    ----------
    name : str
        A built-in scene, whose surface and effects are taken.
    surface : mapping
        ``kind`` and the keys of a scene's surface, without those of the tone.
    effects : tuple of mapping
        As in a scene file; a law of force, friction and a threshold at least.
    accuracy : float
        Relative error of the amplitude that is felt; 0.05 is 0.4 dB.
    """

    name: str = ""
    surface: dict[str, Any] = field(default_factory=dict)
    effects: tuple[dict[str, Any], ...] = ()
    accuracy: float = 0.05

    def __post_init__(self) -> None:
        known = f"one of {', '.join(names())}{nearest(self.name, names())}"
        expect(not self.name or self.name in names(), "SceneTable.name", repr(self.name), known)
        both = f"{self.name!r} beside surface or effects"
        expect(not (self.name and (self.surface or self.effects)), "SceneTable.name", both, "one of the two")
        expect(0 < self.accuracy <= 1, "SceneTable.accuracy", self.accuracy, "above 0 and at most 1")


@dataclass(frozen=True, eq=False)
class FeltScene:
    """A scene as a simulated participant's skin."""

    scene: Scene

    def sensation_db(self, signal: Signal, contact: Contact) -> float:
        """Sensation level (dB) of a signal under a finger."""
        return self.scene.sensation(signal, contact)


def felt_scene(table: Mapping[str, Any], kind: str, stimulus: Any, touch: Touch) -> FeltScene:
    """The scene of a table, under a stimulus of a kind and a touch.

    Raises
    ------
    InvalidParameter
        If the table holds what a scene does not know, no scene plays such a stimulus, or it gives no sensation so
        accurately under this touch: one sentence that opens with the key.
    """
    expected = "a voltage on one electrode; remove [scene]: what is felt then stands in [sensation]"
    expect(kind in WAVEFORMS, "scene", f"a table with the stimulus {kind!r}", expected)
    read = build(SceneTable, table, "scene")
    surface, effects = _parts_of_scene(read.name) if read.name else _parts_of_table(read)
    expect(isinstance(touch, Sliding), "touch.kind", "'press' with a [scene]", "'slide': friction is felt in motion")
    with rewording(_in_study):
        panel = build_kind({**surface, **SILENT, "duration_s": stimulus.duration_s}, "surface", SURFACES).played()
        scene = Scene(panel, effects, (SENSATION,), read.accuracy, panel.touches)
        scene.felt().resolve()
        return FeltScene(scene)


def _parts_of_table(read: SceneTable) -> tuple[dict[str, Any], tuple[Effect, ...]]:
    """Surface and effects of the table itself."""
    kind = read.surface.get("kind", KIND)
    expect(kind == KIND, "scene.surface.kind", repr(kind), f"{KIND!r}, which the stimulus is played on")
    for name in TONE:
        expect(name not in read.surface, f"scene.surface.{name}", "what [stimulus] states", "it there alone; remove it")
    effects = tuple(build_kind(table, f"scene.effects[{n}]", EFFECTS) for n, table in enumerate(read.effects))
    for n, effect in enumerate(effects):
        changes = f"{effect.kind!r}, which changes what is played"
        expect(not effect.in_signal, f"scene.effects[{n}]", changes, "what [stimulus] plays alone; remove it")
    return {"kind": KIND, **read.surface}, effects


def _parts_of_scene(name: str) -> tuple[dict[str, Any], tuple[Effect, ...]]:
    """Surface and effects of a built-in scene, but for what a stimulus plays."""
    scene = load_scene(path_of(name)).scene
    kind = scene.surface.kind
    expected = f"one on {KIND!r}, such as 'electrovibration-panel'"
    expect(kind == KIND, "scene.name", f"{name!r}, a scene on {kind!r}", expected)
    return {"kind": kind, **vars(scene.surface)}, tuple(effect for effect in scene.effects if not effect.in_signal)


def _in_study(refusal: str) -> str:
    """A refusal of a scene in terms of the study."""
    words = refusal.removeprefix("Scene.")
    return f"scene.{words}" if words.startswith(("effects", "accuracy", "surface")) else f"scene: {words}"
