"""What changed from sitting to sitting of a session: devices, screen, limits, versions, authors."""

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Final

import msgspec

from ..errors import InvalidFile
from ..files.durable import read_file
from ..safety.limits import ROUNDING
from ..session.request import Fact
from .head import Head, head_of

VARYING: Final = re.compile(r"(^|_)n_|(_offset_s|_minus_clock_s|_latency_s|_measured_s|_failure)$")
"""Names of counts, clocks and what is measured anew each time: they differ in every sitting and say nothing of it."""
SAME_PERIOD: Final = 0.02
"""Two frame periods that differ by less, relatively, are of one screen."""
_SITTING: Final = b'{"sitting":'


def heads(path: Path) -> tuple[Head, ...]:
    """The heads of all sittings of a journal, by a quick look: damage elsewhere is not found; none without a line.

    Raises
    ------
    InvalidFile
        If one is damaged.
    """
    first, *rest = read_file(path, "a journal").split(b"\n")[:-1] or [b""]  # without a last line that was torn
    lines = [first, *(line for line in rest if line.startswith(_SITTING))] if first else []
    try:
        values = [msgspec.json.decode(line) for line in lines]
        return tuple(head_of(value.get("sitting", value)) for value in values)
    except (msgspec.DecodeError, UnicodeDecodeError, AttributeError, RecursionError) as error:
        raise InvalidFile(f"{path}: found a damaged head ({error}), expected those that the journal wrote") from None


def differences(before: Head, after: Head) -> list[str]:
    """What is not the same in two sittings, a phrase each.

    Examples
    --------
    >>> first = Head("s", "0", "P01", 1, 1, 1, "bench", {"numpy": "2.1"}, {"output_volts_per_unit": 200.0})
    >>> second = Head("s", "0", "P01", 1, 1, 1, "bench", {"numpy": "2.1"}, {"output_volts_per_unit": 400.0})
    >>> differences(first, second)
    ['output_volts_per_unit was 200.0, is 400.0']
    """
    parts = (("version of ", before.versions, after.versions), ("", before.facts, after.facts))
    return [
        f"{label}{name} was {_words(old.get(name))}, is {_words(new.get(name))}"
        for label, old, new in parts
        for name in dict.fromkeys([*old, *new])
        if not VARYING.search(name) and not _alike(name, old, new)
    ]


def _alike(name: str, old: Mapping[str, Fact], new: Mapping[str, Fact]) -> bool:
    before, after = old.get(name), new.get(name)
    if isinstance(before, float) and isinstance(after, float):
        tolerance = SAME_PERIOD if name == "frame_period_s" else ROUNDING
        return math.isclose(before, after, rel_tol=tolerance)
    return before == after


def _words(fact: Fact) -> str:
    return "not stated" if fact is None else str(fact)


def changes(heads: Sequence[Head]) -> Iterator[str]:
    """A sentence for each sitting that differs from the one before it."""
    for number, (before, after) in enumerate(pairwise(heads), 2):
        phrases = differences(before, after)
        if phrases:
            yield f"sitting {number} differs from the one before: {'; '.join(phrases)}"
