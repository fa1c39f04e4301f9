"""Reference page of the parameters and their sources."""

from collections.abc import Iterator
from pathlib import Path
from typing import Final

from ..study.influence import Group, Parameter, Value, groups, parameters, status_counts

PAGE: Final = Path(__file__).resolve().parents[2] / "docs" / "reference" / "sources.md"
HEAD: Final = """# Parameters and their sources

<!-- Written by `make keys` from stimuli/sources.toml. -->

Simulated results rest on the defaults of this page. `tactometry sources STUDY` lists those of a study, with the change
of the sensation level at both ends of each range. [Observers and populations](people.md) states how participants
differ.

| status of a default | meaning |
|---|---|
| exact | mathematics or a definition |
| published | read in a text, table, figure or data sheet, or computed from one or from a named data set |
| abstract | read in an abstract, or derived from a number in one |
| choice | a choice of the study or a setting of the computation: nothing to verify |
| from memory | a source is known or usual, its numbers were not read |
| no source | nothing was found: a default with a wide range |

A default can differ from the value of its source. The range contains both.
The thesis is Zophoniasson (2017), of which pages 1 to 39 were read. Ranges serve the change of one parameter at a time.
They are not confidence intervals.
"""
COLUMNS: Final = (
    "| parameter | default | range | unit | status | source | how it was read |",
    "|---|---|---|---|---|---|---|",
)


def text() -> str:
    """Return the page."""
    return "\n".join([HEAD, *_counts(), *(line for group in groups() for line in _section(group))])


def _counts() -> Iterator[str]:
    listed = parameters()
    unverified, each = sum(one.is_unverified for one in listed), status_counts(listed)
    yield f"Of {len(listed)} parameters, {unverified} are unverified (from memory or no source): {each}.\n"


def _section(group: Group) -> Iterator[str]:
    yield f"## `{group.name}`\n"
    yield f"In `{group.code}`.\n"
    yield from (*COLUMNS, *map(_row, group.parameters), "")


def _row(parameter: Parameter) -> str:
    span = f"{_shown(parameter.low)} to {_shown(parameter.high)}"
    name = ".".join(parameter.path)
    cells = (
        f"`{name}`",
        _shown(parameter.value),
        span,
        parameter.unit,
        parameter.status_text,
        parameter.source,
        parameter.read,
    )
    return f"| {' | '.join(cells)} |"


def _shown(value: Value) -> str:
    return f"`{value}`" if isinstance(value, str) else f"{value:.6g}"
