"""What the format of a journal decides: a session goes on in the one that it began with.

Format 1 has one head, no reason why a track ends or a trial is not valid, and questionnaires after a block without its
condition; its tables lack the columns `ADDED`.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

from ..session.request import Record, Request
from ..trials.columns import Column

FORMAT: Final = 2
ADDED: Final = frozenset(("rig", "speed_in_band", "invalid_reason", "n_gaps"))
ADDED_FACTS: Final = frozenset(("charge_c",))
"""Columns of trials, and of events, that came with format 2."""


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
