"""Explanation of a scene's plan: stages, settings and cost."""

import textwrap
from collections.abc import Iterable, Mapping
from dataclasses import replace
from math import isinf

from tactometry.errors import InvalidParameter

from ..composition.effect import Stage
from .plan import FORCE, Plan, PulledFinger, Result, loads_n, predicted_s, pulled_fingers
from .scene import Scene

COLUMNS = (("stage", 24), ("on", 4), ("why", 30), ("error", 7), ("predicted", 9), ("cold", 7), ("warm", 7))
WIDTH = 100
ROUGH = 0.1
"""Tolerated error of forces that are not outputs of a scene."""

Row = tuple[tuple[str, ...], str]
"""A row of the explanation (one cell per column of `COLUMNS`) and the settings printed below it. ``cold`` is the time
of the first run in this process, ``warm`` that of the second.
"""


def explanation(scene: Scene, given: Mapping[str, float]) -> str:
    """Return the explanation in lines of at most 100 columns.

    Raises `InvalidParameter` if the plan needs a quantity that is not given.
    """
    plan = scene.resolve()
    values = values_for(plan, given)
    cold, warm = plan.timed(values), plan.timed(values)  # includes imports and thread starts
    on = (_on(stage, plan, *times_s) for stage, *times_s in zip(plan.stages, cold, warm, strict=True))
    unused = [((effect.kind, "off", "no output needs it", "", "", "", ""), "") for effect in scene.off()]
    named = {effect.kind for effect in scene.effects}
    kinds = [kind for kind in scene.surface.effects if kind not in named]

    rows = [*on, *unused, *(((kind, "off", "not called for", "", "0", "0", "0"), "") for kind in kinds)]
    fingers = [line for finger in pulled_by(scene, plan, values) for line in _wrapped(finger.line)]
    assumed = [*_wrapped(f"assumptions: {'; '.join(scene.assumed())}"), *_wrapped(rests_on_in_words(scene))]
    lines = [*assumed, *fingers, "", _line(name.title() for name, _ in COLUMNS), "-" * WIDTH]
    for cells, settings in rows:
        lines.append(_line(cells))
        lines += [f"    {text}" for text in textwrap.wrap(settings, WIDTH - 4)]

    total = (
        f"accuracy {scene.accuracy:g}: predicted error {error_in_words(plan)}, "
        f"predicted time {_time(plan.predicted_s)}, measured {_time(sum(cold))} cold, {_time(sum(warm))} warm"
    )
    return "\n".join([*lines, "-" * WIDTH, total, _one_more_digit(scene, plan)])


def values_for(plan: Plan, given: Mapping[str, float]) -> dict[str, float]:
    """Select the given values that a plan needs.

    Raises `InvalidParameter` if a quantity is not given.
    """
    missing = [name for name in plan.given if name not in given]
    if missing:
        raise InvalidParameter(f"given.{missing[0]}: found no such key, expected a number for a run of this scene")
    return {name: given[name] for name in plan.given}


def pulled_by(scene: Scene, plan: Plan, given: Mapping[str, float]) -> list[PulledFinger]:
    """Return the fingers whose linear contact would pull the plate.

    Their forces are accurate to a tenth, or to the accuracy of the scene where that is looser. The list is empty if
    they cannot be computed.
    """
    if not loads_n(plan).size:
        return []
    linear = tuple(effect for effect in scene.effects if "load" not in effect.requires)  # effects on the load
    accuracy = max(scene.accuracy, ROUGH)
    forces = replace(scene, effects=linear, outputs=(FORCE,), accuracy=accuracy, settings={})
    try:
        rough = forces.resolve()
    except InvalidParameter:  # the record may be too long for forces only
        return []
    values = values_for(rough, given)
    return pulled_fingers(Result(rough.run(values), rough, values, 0.0))


def _on(stage: Stage, plan: Plan, cold_s: float, warm_s: float) -> Row:
    settings = ", ".join(f"{key} = {_short(value)}" for key, value in stage.settings.items())
    error = "exact" if stage.error == 0 else "set" if isinf(stage.error) else f"{stage.error:.1e}"
    times = map(_time, (predicted_s(stage), cold_s, warm_s))
    return (stage.name, "on", _why(stage, plan), error, *times), settings


def _why(stage: Stage, plan: Plan) -> str:
    if stage.gives in plan.outputs:
        return f"asked for: {stage.gives}"
    later = plan.stages[plan.stages.index(stage) + 1 :]
    readers = [other.name for other in later if stage.gives in other.needs]
    return f"for {', '.join(readers)}"


def _wrapped(text: str) -> list[str]:
    return textwrap.wrap(text, WIDTH, subsequent_indent="    ")


def rests_on_in_words(scene: Scene) -> str:
    """Describe the constants that set absolute levels, or return ""."""
    return f"absolute levels rest on {'; '.join(scene.rests_on())}" if scene.rests_on() else ""


def error_in_words(plan: Plan) -> str:
    """Format the predicted error, which is unknown if a setting is given."""
    return "not known (a setting is given)" if isinf(plan.error) else f"{plan.error:.1e}"


def _one_more_digit(scene: Scene, plan: Plan) -> str:
    try:
        finer = replace(scene, accuracy=scene.accuracy / 10).resolve()
    except InvalidParameter as error:
        return f"one more digit: not possible ({str(error).partition(',')[0]})"
    ratio = finer.predicted_s / plan.predicted_s
    return (
        f"one more digit (accuracy {scene.accuracy / 10:g}): predicted {_time(finer.predicted_s)}, "
        f"{ratio:.1f} times as long"
    )


def _line(cells: Iterable[str]) -> str:
    fitted = []
    for text, (_, width) in zip(cells, COLUMNS, strict=True):
        cut = text if len(text) <= width else f"{text[: width - 2]}.."
        fitted.append(cut.ljust(width))
    return "  ".join(fitted).rstrip()


def _short(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _time(time_s: float) -> str:
    """Format a time with its unit.

    >>> _time(0.00321), _time(2.5), _time(1e-5)
    ('3.21 ms', '2.5 s', '10 us')
    """
    for unit, factor in (("s", 1.0), ("ms", 1e-3)):
        if time_s >= factor:
            return f"{time_s / factor:.3g} {unit}"
    return f"{time_s * 1e6:.3g} us"
