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
from tactometry.stimuli.composition.effect import Effect, FingerContact
from tactometry.stimuli.scenes.effects import EFFECTS
from tactometry.stimuli.scenes.file import load_scene
from tactometry.stimuli.scenes.scene import SENSATION, Scene
from tactometry.stimuli.scenes.surfaces import SURFACES

from ..scenes import names, path_of

KIND: Final = "electrovibration"
TONE: Final = ("frequency_hz", "duration_s", "ramp_s")
CARRIERS: Final[Mapping[str, tuple[str, ...]]] = {"sine": (), "amplitude_modulated": ("carrier_hz", "modulation")}
"""By the stimuli that a scene plays, the fields that are those of the effect carrier."""


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
    expected = f"a stimulus of {' or '.join(CARRIERS)}; remove [scene]: what is felt then stands in [sensation]"
    expect(kind in CARRIERS, "scene", f"a table with the stimulus {kind!r}", expected)
    read = build(SceneTable, table, "scene")
    surface, effects = _parts_of_scene(read.name) if read.name else _parts_of_table(read)
    tone = {name: getattr(stimulus, name) for name in TONE}
    carrier = {name: getattr(stimulus, name) for name in CARRIERS[kind]}
    played = (build_kind({"kind": "carrier", **carrier}, "stimulus", EFFECTS),) if carrier else ()
    expect(isinstance(touch, Sliding), "touch.kind", "'press' with a [scene]", "'slide': friction is felt in motion")
    assert isinstance(touch, Sliding)
    phase_rad = getattr(stimulus, "phase_rad", 0.0)
    expect(phase_rad == 0, "stimulus.phase_rad", f"{phase_rad:g}", "0: a scene plays a tone that begins at 0")
    with rewording(_in_study):
        contacts = (FingerContact(touch.force_n, touch.speed_m_per_s),)
        panel = build_kind({**surface, **tone}, "surface", SURFACES)
        scene = Scene(panel, (*effects, *played), (SENSATION,), read.accuracy, contacts)
        scene.felt(Contact(touch.force_n, touch.speed_m_per_s)).resolve()
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
        expect(not _plays(effect), f"scene.effects[{n}]", changes, "what [stimulus] plays alone; remove it")
    return {"kind": KIND, **read.surface}, effects


def _parts_of_scene(name: str) -> tuple[dict[str, Any], tuple[Effect, ...]]:
    """Surface and effects of a built-in scene, but for what a stimulus plays."""
    scene = load_scene(path_of(name)).scene
    kind = scene.surface.kind
    expected = f"one on {KIND!r}, such as 'electrovibration-panel'"
    expect(kind == KIND, "scene.name", f"{name!r}, a scene on {kind!r}", expected)
    return {"kind": kind, **vars(scene.surface)}, tuple(effect for effect in scene.effects if not _plays(effect))


def _plays(effect: Effect) -> bool:
    return getattr(effect, "gives", "") == "waveform"


def _in_study(refusal: str) -> str:
    """A refusal of a scene in terms of the study."""
    words = refusal.removeprefix("Scene.")
    return f"scene.{words}" if words.startswith(("effects", "accuracy", "surface")) else f"scene: {words}"
