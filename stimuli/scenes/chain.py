"""From what is asked for back to what is given: the stages that are needed, in the order in which they run."""

from collections.abc import Callable, Collection, Sequence

from tactometry.errors import InvalidParameter, nearest

from ..composition.effect import Stage
from .result import unit_of

Cure = Callable[[str], str]
"""What would bring a quantity, in words; empty if nothing would."""


def required_stages(
    outputs: Sequence[str], stages: Sequence[Stage], given: Collection[str], cure: Cure = lambda quantity: ""
) -> tuple[Stage, ...]:
    """The stages without which `outputs` cannot be had, each behind those that it needs.

    `stages` stand in the order in which they act. Of those that give one quantity, the last that makes it anew counts,
    and those behind it that change it; whoever else needs the quantity reads its last value. `cure` is asked
    about a quantity that nothing gives.

    Raises
    ------
    InvalidParameter
        If nothing gives a quantity, or quantities need each other in a circle.

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
            raise InvalidParameter(f"scene: found that {' needs '.join((*path, quantity))}, expected no circle")
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
        where, wanted = ("scene", f", which {path[-1]!r} needs") if path else ("outputs", "")
        bringing = cure(quantity)
        mend = f"; {bringing}" if bringing else nearest(quantity, known)
        raise InvalidParameter(
            f"{where}: found nothing that gives {quantity!r}{wanted}, expected one of {', '.join(known)}{mend}"
        )
    return giving[makers[-1] :]
