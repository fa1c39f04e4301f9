"""What a scene lets a participant feel, in words for journals and reports."""

from collections.abc import Iterator, Mapping
from dataclasses import MISSING, fields, is_dataclass
from typing import Any, Final

from tactometry.config.strict import fields_of
from tactometry.stimuli.composition.effect import Effect
from tactometry.stimuli.scenes.scene import Scene

OF_STIMULUS: Final = ("setup", "places", "duration_s")
"""What of a surface the stimulus states."""


def scene_in_words(scene: Scene) -> str:
    """The effects that are felt, what of the surface is not at its default, and the error that is tolerated."""
    off, surface = scene.felt().off(), scene.surface
    effects = ", ".join(effect_in_words(effect) for effect in scene.effects if effect not in off)
    stated = _deviations(vars(surface), dict(_usual(type(surface))))
    return "; ".join([effects, *stated, f"accuracy {scene.accuracy:g}"])


def _usual(kind: Any) -> Iterator[tuple[str, Any]]:
    """The defaults of a class, of the fields that have one."""
    for field in fields(kind):
        default = field.default if field.default_factory is MISSING else field.default_factory()
        if default is not MISSING:
            yield field.name, default


def effect_in_words(effect: Effect) -> str:
    """An effect as a scene file names it, with the values that are not its defaults.

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
    """Values that are not as usual; of those that have fields, the fields."""
    for name, value in values.items():
        if name in OF_STIMULUS or value == usual.get(name, value):
            continue
        if is_dataclass(value) and type(value) is type(usual[name]):
            yield from _deviations(vars(value), vars(usual[name]))
        else:
            yield f"{name} = {_in_words(value)}"


def _in_words(value: object) -> str:
    if isinstance(value, tuple):
        return " and ".join(map(_in_words, value))
    return f"{value:.6g}" if isinstance(value, float) else f"{value}"
