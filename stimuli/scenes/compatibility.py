"""Which effects go together: each refusal says what was found, and how to mend it."""

from collections.abc import Sequence

from tactometry.errors import InvalidParameter

from ..composition.effect import Effect, Surroundings

TOUCHES = ("contact", "sliding contact", "resting contact")


def check_effects(effects: Sequence[Effect], scene: Surroundings) -> None:
    """Refuse effects that the surface does not know, that fill one slot, contradict each other or lack something."""
    filled: dict[str, Effect] = {}
    for n, effect in enumerate(effects):
        _check_place(effect, scene, f"effects[{n}]")
        if effect.slot in filled:
            raise InvalidParameter(
                f"effects[{n}]: found {effect.kind!r} beside {filled[effect.slot].kind!r}, expected one of them, for "
                f"both are the {effect.slot}; remove the other"
            )
        filled[effect.slot] = effect
    for n, effect in enumerate(effects):
        _check_company(effect, scene, f"effects[{n}]")
        for need in effect.requires:
            _check_need(effect, need, scene, f"effects[{n}]")


def _check_place(effect: Effect, scene: Surroundings, where: str) -> None:
    refused = scene.surface.refuses.get(effect.kind)
    if refused:
        raise InvalidParameter(f"{where}: found {effect.kind!r} on {scene.surface.kind!r}, expected {refused}")
    if effect.kind not in scene.surface.effects:
        raise InvalidParameter(
            f"{where}: found {effect.kind!r}, which {scene.surface.kind!r} does not know, expected an effect of "
            f"{', '.join(scene.surface.effects)}; remove it"
        )


def _check_company(effect: Effect, scene: Surroundings, where: str) -> None:
    excluded = scene.surface.excluded(effect)
    for other in scene.effects:
        if other.kind in excluded:
            raise InvalidParameter(
                f"{where}: found {effect.kind!r} beside {other.kind!r}, expected one of them: {excluded[other.kind]}"
            )


def _check_need(effect: Effect, need: str, scene: Surroundings, where: str) -> None:
    if need in TOUCHES:
        if not any(_is(need, touch.slides) for touch in scene.contacts):
            raise InvalidParameter(
                f"{where}: found {effect.kind!r} without a {need}, expected one; add a [[contacts]] table with "
                f"force_n{_HOW[need]}, or remove {effect.kind!r}"
            )
    elif scene.find(need) is None:
        raise InvalidParameter(
            f"{where}: found {effect.kind!r} without an effect of {need}, which it acts on, expected one; add it or "
            f"remove {effect.kind!r}"
        )


_HOW = {"contact": "", "sliding contact": " and a speed_m_per_s above 0", "resting contact": " and no speed"}


def _is(need: str, slides: bool) -> bool:
    return need == "contact" or (need == "sliding contact") == slides
