"""Head of a sitting: journal line with participant, study and devices.

A session keeps the format with which it began. Format 1 has one head, no reasons, and questionnaires after a block
without its condition. Its tables lack the columns `ADDED`. Devices, limits and versions may change between sittings.
`changes` lists the differences.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from math import isclose, isfinite
from pathlib import Path
from typing import Any, Final

import msgspec

from ..errors import InvalidFile
from ..files.durable import read_file, whole_lines
from ..safety.limits import ROUNDING
from ..session.request import Fact, Record, Request
from ..trials.cells import PARTICIPANT, STUDY, is_time
from ..trials.columns import RIGS, Column
from .data_set import LARGEST_NUMBER

FORMAT: Final = 2
ADDED: Final = frozenset(("rig", "speed_in_band", "invalid_reason", "n_gaps"))
ADDED_FACTS: Final = frozenset(("charge_c",))
"""Columns of trials, and of events, added in format 2."""
LARGEST_SEED = 2**63 - 1
VARYING: Final = re.compile(r"(^|_)n_|(_offset_s|_minus_clock_s|_latency_s|_measured_s|_failure)$")
"""Names of counts, clocks and measurements. They differ in every sitting and are not reported as changes."""
SAME_PERIOD: Final = 0.02
"""Relative difference below which two frame periods belong to the same screen."""
_SITTING: Final = b'{"sitting":'
_SHA256 = re.compile(r"[0-9a-f]{64}")


@dataclass(frozen=True)
class Head:
    """Everything needed to repeat the requests, and the conditions of a sitting.

    `begun_s` is the session time at which the sitting began.
    """

    study: str
    study_sha256: str
    participant: str
    session: int
    number: int
    seed: int
    rig: str
    versions: dict[str, str]
    facts: dict[str, Fact] = field(default_factory=dict)
    observer: dict[str, Fact] = field(default_factory=dict)
    started_utc: str | None = None
    begun_s: float = 0.0
    format: int = FORMAT

    @property
    def whose(self) -> tuple[object, ...]:
        return self.study, self.study_sha256, self.participant, self.session, self.number, self.seed, self.rig


def head_of(value: object, first: Head | None = None) -> Head:
    """Decode a head, and compare it with the head of the first sitting.

    Raises `msgspec.ValidationError` if the head is invalid, belongs to another session, or has a later format.
    """
    head = msgspec.convert(value, Head)
    for name, holds in _conditions(head).items():
        if not holds:
            raise msgspec.ValidationError(f"the {name} {getattr(head, name)!r}")
    if first is not None and (head.whose, head.format) != (first.whose, first.format):
        raise msgspec.ValidationError("a sitting of a different session than the first line")
    return head


def _conditions(head: Head) -> dict[str, object]:
    return {
        "format": 1 <= head.format <= FORMAT,
        "study": STUDY.fullmatch(head.study),
        "study_sha256": _SHA256.fullmatch(head.study_sha256),
        "participant": PARTICIPANT.fullmatch(head.participant),
        "session": 1 <= head.session <= LARGEST_NUMBER,
        "number": 1 <= head.number <= LARGEST_NUMBER,
        "seed": 0 <= head.seed <= LARGEST_SEED,
        "rig": head.rig in RIGS,
        "started_utc": head.started_utc is None or is_time(head.started_utc),
        "begun_s": isfinite(head.begun_s) and head.begun_s >= 0,
    }


def as_kept(request: Request[Any], journal_format: int) -> Request[Any]:
    """Return a request as a journal of the given format stores it.

    >>> from tactometry.trials.trial import Trial
    >>> trial = Trial(1, 1, {"force_n": 1.0}, "sus", None, "", "rating", 3.0)
    >>> as_kept(Record(trial, aborted="too late"), 1) == Record(replace(trial, factors={"force_n": ""}))
    True
    """
    if journal_format > 1 or not isinstance(request, Record):
        return request
    trial = replace(request.trial, invalid_reason=None, n_gaps=None)
    return Record(replace(trial, factors=dict.fromkeys(trial.factors, "")) if trial.is_form else trial)


def columns_in(columns: Sequence[Column], journal_format: int) -> tuple[Column, ...]:
    """Return the columns that sessions of the given format have."""
    return tuple(column for column in columns if journal_format > 1 or column.name not in ADDED | ADDED_FACTS)


def heads(path: Path) -> tuple[Head, ...]:
    """Read the heads of all sittings of a journal. Other lines are not checked."""
    content = read_file(path, "a journal")
    first = next(whole_lines(content), b"")
    others = [] if first.startswith(_SITTING) else [first]
    lines = [*others, *whole_lines(content, _SITTING)] if first else []
    try:
        values = [msgspec.json.decode(line) for line in lines]
        return tuple(head_of(value.get("sitting", value)) for value in values)
    except (msgspec.DecodeError, UnicodeDecodeError, AttributeError, RecursionError) as error:
        raise InvalidFile(f"{path}: found a damaged head ({error}), expected a head as the journal wrote it") from None


def differences(before: Head, after: Head) -> list[str]:
    """Return a phrase for each difference between two sittings.

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
        return isclose(before, after, rel_tol=tolerance)
    return before == after


def _words(fact: Fact) -> str:
    return "not stated" if fact is None else str(fact)


def changes(heads: Sequence[Head]) -> Iterator[str]:
    """Yield a sentence for each sitting that differs from the previous one."""
    for number, (before, after) in enumerate(pairwise(heads), 2):
        phrases = differences(before, after)
        if phrases:
            yield f"sitting {number} differs from the previous one: {'; '.join(phrases)}"
