"""The head of a sitting: its line of a journal says who, what, where and on what."""

import re
from dataclasses import dataclass, field
from math import isfinite

import msgspec

from ..session.request import Fact
from ..trials.cell_rules import PARTICIPANT, STUDY, is_time
from ..trials.columns import RIGS
from .data_set import LARGEST_NUMBER
from .formats import FORMAT

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
