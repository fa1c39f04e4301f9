"""Checks of the stages and effects that a scene needs."""

from collections.abc import Callable, Collection, Sequence

from tactometry.errors import InvalidParameter, nearest

from ..composition.effect import Effect, Stage, Surroundings
from .plan import unit_of

Cure = Callable[[str], str]
"""Returns advice for a missing quantity, or an empty string."""


def required_stages(
    outputs: Sequence[str], stages: Sequence[Stage], given: Collection[str], cure: Cure = lambda quantity: ""
) -> tuple[Stage, ...]:
    """Return the stages that `outputs` need, each after its prerequisites.

    `stages` are in the order in which they act. The last stage that creates a quantity counts, with all later stages
    that change it. Other stages read the final value. `cure` returns advice for a quantity that no stage computes.

    Raises `InvalidParameter` if no stage computes a quantity, or quantities depend on each other in a cycle.

    >>> source = Stage("source", (), "voltage", "x:y")
    >>> ramps = Stage("ramps", ("voltage",), "voltage", "x:y")
    >>> force = Stage("force", ("voltage", "contact"), "force", "x:y")
    >>> [stage.name for stage in required_stages(["force"], [force, source, ramps], {"contact"})]
    ['source', 'ramps', 'force']
    >>> recorded = Stage("recorded", (), "voltage", "x:y")
    >>> [stage.name for stage in required_stages(["voltage"], [source, recorded, ramps], ())]
    ['recorded', 'ramps']
    """
    done: dict[str, None] = dict.fromkeys(given)
    ordered: list[Stage] = []

    def visit(quantity: str, path: tuple[str, ...]) -> None:
        if quantity in done:
            return
        if quantity in path:
            raise InvalidParameter(f"scene: found that {' needs '.join((*path, quantity))}, expected no cycle")
        for stage in _chain(quantity, stages, path, cure):
            for need in stage.needs:
                if need != quantity:
                    visit(need, (*path, quantity))
            ordered.append(stage)
        done[quantity] = None

    for output in outputs:
        visit(output, ())
    return tuple(ordered)


def _chain(quantity: str, stages: Sequence[Stage], path: tuple[str, ...], cure: Cure) -> Sequence[Stage]:
    giving = [stage for stage in stages if stage.gives == quantity]
    makers = [n for n, stage in enumerate(giving) if not stage.changes]
    if not makers:
        known = sorted({stage.gives for stage in stages if path or unit_of(stage.gives)})
        where, needed = ("scene", f", which {path[-1]!r} needs") if path else ("outputs", "")
        bringing = cure(quantity)
        mend = f"; {bringing}" if bringing else nearest(quantity, known)
        raise InvalidParameter(
            f"{where}: found no stage or effect for {quantity!r}{needed}, expected one of {', '.join(known)}{mend}"
        )
    return giving[makers[-1] :]


TOUCHES = ("contact", "sliding contact", "resting contact")


def check_effects(effects: Sequence[Effect], scene: Surroundings) -> None:
    """Raise an error for unknown, repeated, excluded or incomplete effects."""
    filled: dict[str, Effect] = {}
    for n, effect in enumerate(effects):
        where = f"effects[{n}]"
        refused = scene.surface.refuses.get(effect.kind)
        if refused:
            raise InvalidParameter(f"{where}: found {effect.kind!r} on {scene.surface.kind!r}, expected {refused}")
        if effect.kind not in scene.surface.effects:
            raise InvalidParameter(
                f"{where}: found {effect.kind!r}, which {scene.surface.kind!r} does not support, expected an effect of "
                f"{', '.join(scene.surface.effects)}; remove it"
            )
        if effect.slot in filled:
            raise InvalidParameter(
                f"effects[{n}]: found {effect.kind!r} with {filled[effect.slot].kind!r}, expected only one of them "
                f"in the slot {effect.slot}; remove the other"
            )
        filled[effect.slot] = effect
    for n, effect in enumerate(effects):
        _check_company(effect, scene, f"effects[{n}]")
        for need in effect.requires:
            _check_need(effect, need, scene, f"effects[{n}]")


def _check_company(effect: Effect, scene: Surroundings, where: str) -> None:
    excluded = scene.surface.excluded(effect)
    for other in scene.effects:
        if other.kind in excluded:
            raise InvalidParameter(
                f"{where}: found {effect.kind!r} with {other.kind!r}, expected only one of them: {excluded[other.kind]}"
            )


def _check_need(effect: Effect, need: str, scene: Surroundings, where: str) -> None:
    if need in TOUCHES:
        if not any(need == "contact" or (need == "sliding contact") == touch.slides for touch in scene.contacts):
            raise InvalidParameter(
                f"{where}: found {effect.kind!r} without a {need}, expected one; add a [[contacts]] table with "
                f"force_n{_HOW[need]}, or remove {effect.kind!r}"
            )
    elif scene.find(need) is None:
        raise InvalidParameter(
            f"{where}: found {effect.kind!r} without an effect in slot {need}, expected one; add it or "
            f"remove {effect.kind!r}"
        )


_HOW = {"contact": "", "sliding contact": " and a speed_m_per_s above 0", "resting contact": " and no speed"}
