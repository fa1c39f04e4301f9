"""The head of a sitting: its line of a journal says who, what, where and on what, and in which format.

A session goes on in the format that it began with. Format 1 has one head, no reason why a track ends or a trial is not
valid, and questionnaires after a block without its condition; its tables lack the columns `ADDED`.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import isfinite
from typing import Any, Final

import msgspec

from ..session.request import Fact, Record, Request
from ..trials.cell_rules import PARTICIPANT, STUDY, is_time
from ..trials.columns import RIGS, Column
from .data_set import LARGEST_NUMBER

FORMAT: Final = 2
ADDED: Final = frozenset(("rig", "speed_in_band", "invalid_reason", "n_gaps"))
ADDED_FACTS: Final = frozenset(("charge_c",))
"""Columns of trials, and of events, that came with format 2."""
LARGEST_SEED = 2**63 - 1
_SHA256 = re.compile(r"[0-9a-f]{64}")


@dataclass(frozen=True)
class Head:
    """Of a sitting: what is needed to ask the same again, and where and on what it was asked.

    `begun_s` is the time of the session at which the sitting began.
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
        """What all sittings of a session share."""
        return self.study, self.study_sha256, self.participant, self.session, self.number, self.seed, self.rig


def head_of(value: object, first: Head | None = None) -> Head:
    """A head from its line; `first` is that of the first sitting, with which it must agree.

    Raises
    ------
    msgspec.ValidationError
        If it is none, or is of another session or of a later format.
    """
    head = msgspec.convert(value, Head)
    for name, holds in _conditions(head).items():
        if not holds:
            raise msgspec.ValidationError(f"the {name} {getattr(head, name)!r}")
    if first is not None and (head.whose, head.format) != (first.whose, first.format):
        raise msgspec.ValidationError("a sitting of another session than the first line's")
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
    """A request as a journal of this format keeps it.

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
    """Those of the columns of a table that sessions of this format have."""
    return tuple(column for column in columns if journal_format > 1 or column.name not in ADDED | ADDED_FACTS)
