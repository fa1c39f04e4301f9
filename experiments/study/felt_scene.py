"""Sensation models of scenes, and the table `[scene]`.

A study states the played signal in `[stimulus]` and the finger's contact in `[touch]`. The scene is the physics between
them.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import MISSING, dataclass, field, fields, is_dataclass, replace
from functools import cached_property
from typing import Annotated, Any, Final, cast

from annotated_types import Interval

from tactometry.arguments.constraints import constrained
from tactometry.arguments.require import expect
from tactometry.config.strict import build, build_kind, check_keys, fields_of
from tactometry.contact import Contact
from tactometry.errors import rewording
from tactometry.loading import resolve
from tactometry.protocols.tasks.touch import Sliding, Touch
from tactometry.signal import Signal
from tactometry.stimuli.arrays import FloatArray
from tactometry.stimuli.composition.effect import Effect, Surface
from tactometry.stimuli.scenes.effects import EFFECTS
from tactometry.stimuli.scenes.plan import Plan
from tactometry.stimuli.scenes.scene import SENSATION, Scene
from tactometry.stimuli.scenes.surfaces import SURFACES

from ..scenes import path_of
from .procedure_table import without

FORCE = "contact_force_n"
STATED_BY_STIMULUS: Final = ("setup", "places", "duration_s")
"""Fields of a surface that the stimulus sets."""
SUCH_AS: Final = {"electrovibration": "electrovibration-panel", "time_reversal": "a4-screen", "hybrid": "hybrid-screen"}
TONE: Final = ("frequency_hz", "duration_s", "ramp_s")
SILENT: Final = {"kind": "electrovibration", "frequency_hz": 1.0}
"""Placeholder for the tone of a panel, which the played stimulus replaces."""
Parts = tuple[dict[str, Any], tuple[Effect, ...]]


@dataclass(frozen=True, eq=False)
class FeltScene:
    """Sensation model of a scene."""

    scene: Scene

    def sensation_db(self, signal: Signal, contact: Contact) -> float:
        """Return the sensation level (dB) of a signal under a finger."""
        return self.scene.sensation(signal, contact)


class FeltOnPlate(FeltScene):
    """Sensation model of a moving plate, with the contact force."""

    def contact_force_n(self, signal: Signal, contact: Contact) -> FloatArray:
        """Return contact minus pressing force, (n_fingers, n_samples)."""
        force_n: FloatArray = self._pressed.run({"signal": signal, "contact": contact})[FORCE]
        return force_n

    @property
    def pressers(self) -> tuple[str, ...]:
        """Names of the fingers that share the force of a touch."""
        return tuple(f"finger at {name}" for name in self.scene.surface.names) or ("finger",)

    @cached_property
    def _pressed(self) -> Plan:
        return self.scene.felt(FORCE).resolve()


class FeltByFingers(FeltOnPlate):
    """Sensation model of several fingers on a moving plate."""

    def fingers_db(self, signal: Signal, contact: Contact) -> tuple[float, ...]:
        """Return the sensation level (dB) at each finger."""
        return self.scene.fingers_db(signal, contact)


def felt(scene: Scene) -> FeltScene:
    """Return the sensation model of a scene."""
    if scene.surface.names:
        return FeltByFingers(scene)
    kind = FeltScene if scene.surface.kind == "electrovibration" else FeltOnPlate
    return kind(scene)


def scene_in_words(scene: Scene) -> str:
    """Describe felt effects, non-default values and the accuracy in words."""
    off, surface = scene.felt().off(), scene.surface
    effects = ", ".join(effect_in_words(effect) for effect in scene.effects if effect not in off)

    stated = fields(cast("Any", surface))
    defaults = {each.name: each.default for each in stated if each.default is not MISSING}
    defaults |= {each.name: each.default_factory() for each in stated if each.default_factory is not MISSING}
    return "; ".join([effects, *_deviations(vars(surface), defaults), f"accuracy {scene.accuracy:g}"])


def effect_in_words(effect: Effect) -> str:
    """Describe an effect with its non-default values in words.

    >>> from tactometry.stimuli.scenes.effects.force_law import ForceLaw
    >>> from tactometry.stimuli.scenes.effects.focus_detection import FocusDetection
    >>> effect_in_words(ForceLaw("sc_layer")), effect_in_words(FocusDetection(2e-5))
    ('force_law (law = sc_layer)', 'focus_detection (reference_m = 2e-05)')
    >>> effect_in_words(FocusDetection())
    'focus_detection'
    """
    usual = {name: field.default for name, field in fields_of(type(effect)).items()}
    stated = ", ".join(_deviations(vars(effect), usual))
    return f"{effect.kind} ({stated})" if stated else effect.kind


def _deviations(values: Mapping[str, Any], usual: Mapping[str, Any]) -> Iterator[str]:
    """Yield values that differ from the defaults, including inner dataclasses."""
    for name, value in values.items():
        if name in STATED_BY_STIMULUS or value == usual.get(name, value):
            continue
        if is_dataclass(value) and type(value) is type(usual[name]):
            yield from _deviations(vars(value), vars(usual[name]))
        else:
            yield f"{name} = {_value_in_words(value)}"


def _value_in_words(value: object) -> str:
    if isinstance(value, tuple):
        return " and ".join(map(_value_in_words, value))
    return f"{value:.6g}" if isinstance(value, float) else f"{value}"


@dataclass(frozen=True)
@constrained
class SceneTable:
    """Physics between the stimulus and the skin.

    - `name`: Built-in scene or scene file that supplies surface and effects.
    - `surface`: ``kind`` and the keys of a scene's surface, without the keys of the tone.
    - `effects`: Effects as in a scene file, with at least a force law, friction and a threshold.
    - `accuracy`: Relative error of the felt amplitude. 0.05 corresponds to 0.4 dB.
    """

    name: str = ""
    surface: dict[str, Any] = field(default_factory=dict)
    effects: tuple[dict[str, Any], ...] = ()
    accuracy: Annotated[float, Interval(gt=0, le=1)] = 0.05

    def __post_init__(self) -> None:
        both = f"{self.name!r} next to surface or effects"
        expect(not (self.name and (self.surface or self.effects)), "SceneTable.name", both, "one of the two")


def felt_scene(table: Mapping[str, Any], surface: str, stimulus: Any, touch: Touch) -> FeltScene:
    """Build the scene of a table on a surface, under a stimulus and touch.

    Raises `InvalidParameter` if a key or value is invalid, no scene supports the stimulus, or the sensation cannot be
    computed with this accuracy for this touch. The message starts with the key.
    """
    expected = "another stimulus kind; remove [scene] and use [sensation]"
    expect(surface in PLAYED, "scene", "a table with a stimulus that no scene supports", expected)
    read = build(SceneTable, table, "scene")
    stated, effects = _parts_of_scene(read.name, surface) if read.name else _parts_of_table(read, surface)
    rests = surface == "electrovibration" and not isinstance(touch, Sliding)
    expect(not rests, "touch.kind", "'press' with a [scene]", "'slide', as friction is felt only in motion")
    with rewording(_in_study):
        played = PLAYED[surface](stated, stimulus, "surface")
        scene = Scene(played, effects, (SENSATION,), read.accuracy, played.touches)
        scene.felt().resolve()
        return felt(scene)


def _panel(stated: Mapping[str, Any], stimulus: Any, where: str) -> Any:
    """Build an electrode with layers stated as in a scene file."""
    for name in TONE:
        expect(name not in stated, f"{where}.{name}", "a key of [stimulus]", "it only in [stimulus]; remove it")
    panel: Any = build_kind({**SILENT, **stated, "duration_s": stimulus.duration_s}, where, SURFACES)
    return panel.played()


def _plate(stated: Mapping[str, Any], stimulus: Any, where: str) -> Any:
    """Build a plate from the stimulus, with the positions of the fingers."""
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
"""Functions that build a surface from the table `surface` and a stimulus, by kind."""


def _parts_of_table(read: SceneTable, surface: str) -> Parts:
    """Return the surface and effects of the table itself."""
    kind = read.surface.get("kind", surface)
    where = "use [variants.FACTOR.LEVEL.scene] if levels of a factor have different surfaces"
    expect(kind == surface, "scene.surface.kind", repr(kind), f"{surface!r}, the surface of the stimulus; {where}")
    effects = tuple(build_kind(table, f"scene.effects[{n}]", EFFECTS) for n, table in enumerate(read.effects))
    for n, effect in enumerate(effects):
        changes = f"{effect.kind!r}, which changes the played signal"
        is_played = effect.kind in resolve(SURFACES[surface]).effects and effect.in_signal
        expect(not is_played, f"scene.effects[{n}]", changes, "effects of contact and sensation; remove it")
    return read.surface, effects


def _parts_of_scene(name: str, surface: str) -> Parts:
    """Return surface and effects of a scene file that [stimulus] does not set."""
    from tactometry.stimuli.scenes.file import load_scene  # imports the modules of its effects

    with rewording(lambda words: words.replace("FILE", "scene.name", 1)):
        path = path_of(name)
    scene = load_scene(path).scene
    of = getattr(scene.surface, surface, scene.surface)  # on a hybrid screen, the half that plays the stimulus
    expected = f"a scene on {surface!r}, such as {SUCH_AS[surface]!r}"
    expect(of.kind == surface, "scene.name", f"{name!r}, a scene on {of.kind!r}", expected)
    levels = tuple(output for output in scene.outputs if output.endswith(SENSATION)) or (SENSATION,)
    with rewording(_in_study):
        idle = replace(scene, outputs=levels).off()
    on_it = (one for one in scene.effects if one.kind in of.effects)
    return _stated(of), tuple(one for one in on_it if not one.in_signal and one not in idle)


def _stated(surface: Surface) -> dict[str, Any]:
    """Return the values of a surface that the stimulus does not state."""
    if surface.kind == "hybrid":
        return {"electrovibration": _stated(vars(surface)["electrovibration"])}
    return without(vars(surface), *TONE) if surface.kind == "electrovibration" else {}


def _in_study(refusal: str) -> str:
    words = refusal.removeprefix("Scene.")
    return f"scene.{words}" if words.startswith(("effects", "accuracy", "surface")) else f"scene: {words}"
