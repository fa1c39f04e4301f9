"""Scenes as simulated participants feel them, and their effects in words for journals and reports."""

from collections.abc import Iterator, Mapping
from dataclasses import MISSING, dataclass, fields, is_dataclass
from functools import cached_property
from typing import Any, Final, cast

from tactometry.config.strict import fields_of
from tactometry.contact import Contact
from tactometry.signal import Signal
from tactometry.stimuli.arrays import FloatArray
from tactometry.stimuli.composition.effect import Effect
from tactometry.stimuli.scenes.plan import Plan
from tactometry.stimuli.scenes.scene import Scene

FORCE = "contact_force_n"
STATED_BY_STIMULUS: Final = ("setup", "places", "duration_s")
"""Fields of a surface that the stimulus states."""


@dataclass(frozen=True, eq=False)
class FeltScene:
    """Sensation through a scene.

    Parameters
    ----------
    scene : Scene
    """

    scene: Scene

    def sensation_db(self, signal: Signal, contact: Contact) -> float:
        """Sensation level (dB) of a signal under a finger."""
        return self.scene.sensation(signal, contact)


class FeltOnPlate(FeltScene):
    """Sensation on a moving plate, with the force between finger and plate."""

    def contact_force_n(self, signal: Signal, contact: Contact) -> FloatArray:
        """Return the force of a linear contact on each finger.

        (n_fingers, n_samples), in addition to the pressing force. The plate is loaded as in the scene, else by default.
        """
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
    """Sensation at several fingers on a moving plate."""

    def fingers_db(self, signal: Signal, contact: Contact) -> tuple[float, ...]:
        """Return the sensation level (dB) at each finger."""
        return self.scene.fingers_db(signal, contact)


def felt(scene: Scene) -> FeltScene:
    """Return the sensation model of a scene on its surface."""
    if scene.surface.names:
        return FeltByFingers(scene)
    kind = FeltScene if scene.surface.kind == "electrovibration" else FeltOnPlate
    return kind(scene)


def scene_in_words(scene: Scene) -> str:
    """List the effects that are felt, values of the surface other than defaults, and the tolerated error."""
    off, surface = scene.felt().off(), scene.surface
    effects = ", ".join(effect_in_words(effect) for effect in scene.effects if effect not in off)

    stated = fields(cast("Any", surface))
    defaults = {each.name: each.default for each in stated if each.default is not MISSING}
    defaults |= {each.name: each.default_factory() for each in stated if each.default_factory is not MISSING}
    return "; ".join([effects, *_deviations(vars(surface), defaults), f"accuracy {scene.accuracy:g}"])


def effect_in_words(effect: Effect) -> str:
    """Name an effect as a scene file does, with the values that are not its defaults.

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
    """Yield values that differ from the usual ones, those of dataclasses field by field."""
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
