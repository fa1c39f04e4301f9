"""`tactometry sources`."""

from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..trials.cells import cell
from .output import STUDY, allow_code_option, say, subcommand

if TYPE_CHECKING:
    from tactometry.experiments.study.influence import Influence, StudySources

LARGE_DB = 1.0
HEAD = ("", "parameter", "set to", "range", "unit", "at low", "at high", "status")


@subcommand("sources electrovibration-threshold")
@click.argument("study", type=STUDY)
@allow_code_option
def command(study: str, *, allow_code: bool) -> None:
    """List the parameters that the simulated results of STUDY rest on.

    Each parameter is set to the low and the high end of its range, one at a time, in the first condition at its
    predicted threshold. The list is sorted by the change of the sensation level (dB), and the three largest are marked.
    A dash marks a change that cannot be computed, for instance where the level exceeds a limit.
    """
    from tactometry.experiments.study.experiment import wire
    from tactometry.experiments.study.influence import sources_of
    from tactometry.experiments.study.study_file import folder_of, load

    code_from: Path | None = folder_of(study) if allow_code else None
    result = sources_of(wire(load(study)[0], study, code_from))
    say("\n".join(_lines(study, result)), _record(result))


def _lines(study: str, found: "StudySources") -> Iterator[str]:
    from tactometry.experiments.study.influence import status_counts

    condition = ", ".join(f"{name} {cell(value)}" for name, value in found.condition.items())
    place = "predicted threshold" if found.is_threshold else "highest level"
    where = f"{study} at {condition}" if condition else study
    yield f"{where}: change of the sensation level (dB) at the {place}, {found.level:.4g} {found.level_unit}"
    rows = [HEAD, *(_cells(one) for one in found.influences if one.at_low_db is not None or one.at_high_db is not None)]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        yield "  ".join(f"{cell:<{width}}" for cell, width in zip(row, widths, strict=True)).rstrip()
    others = [one.parameter.key for one in found.influences if one.at_low_db is None and one.at_high_db is None]
    if others:
        yield f"change not computed: {', '.join(others)}"
    listed = [one.parameter for one in found.influences]
    yield f"{len(listed)} parameters: {status_counts(listed)}"
    large = [one for one in found.influences if one.largest_db >= LARGE_DB]
    unverified = sum(one.parameter.is_unverified for one in large)
    yield f"{len(large)} change the level by {LARGE_DB:g} dB or more, {unverified} of them from memory or no source"


def _cells(one: "Influence") -> tuple[str, ...]:
    parameter = one.parameter
    span = f"{_number(parameter.low)} to {_number(parameter.high)}"
    mark = "*" if one.is_marked else ""
    changes = (_change(one.at_low_db), _change(one.at_high_db))
    return (mark, parameter.key, _number(one.set_to), span, parameter.unit, *changes, parameter.status_text)


def _number(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:.5g}"


def _change(change_db: float | None) -> str:
    return "-" if change_db is None else f"{round(change_db, 2) + 0.0:+.2f}"


def _record(found: "StudySources") -> dict[str, Any]:
    changes = ("set_to", "at_low_db", "at_high_db", "is_marked")
    each = [asdict(one.parameter) | {name: getattr(one, name) for name in changes} for one in found.influences]
    return {
        "condition": dict(found.condition),
        "level": found.level,
        "level_unit": found.level_unit,
        "is_threshold": found.is_threshold,
        "parameters": each,
    }
