"""Interruptions and interventions in sessions."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Final

import pandas as pd

from tactometry.errors import InvalidFile
from tactometry.records.data_set import keys_of
from tactometry.records.head import Head, differences

from .origin import SessionKey

REPORTED: Final = ("remark", "pause", "repeat", "stop", "abort", "order", "intervention")
"""Kinds of events that the report lists."""
EVENT_COLUMNS: Final = ("participant", "session", "onset", "trial_type", "text")


def sittings(known: Mapping[SessionKey, Sequence[Head]]) -> pd.DataFrame:
    """Return the sittings of interrupted sessions, with changes."""
    rows = [
        (code, int(session), number, head.started_utc or "", head.begun_s, words)
        for (code, session), heads in known.items()
        if len(heads) > 1
        for number, (head, words) in enumerate(zip(heads, _changes(heads), strict=True), 1)
    ]
    return pd.DataFrame(rows, columns=["participant", "session", "sitting", "started_utc", "begun_s", "changes"])


def _changes(heads: Sequence[Head]) -> list[str]:
    return ["as it began", *("; ".join(differences(before, after)) or "nothing" for before, after in pairwise(heads))]


def happenings(path: Path) -> pd.DataFrame:
    """Return the events to report of all sessions, with their times (s).

    Raises `InvalidFile` if a file of events lacks a column.
    """
    tables = [table for table in session_events(path, EVENT_COLUMNS[2:], _reported) if len(table)]
    return pd.concat(tables, ignore_index=True)[list(EVENT_COLUMNS)] if tables else pd.DataFrame(columns=EVENT_COLUMNS)


def session_events(
    path: Path, columns: Sequence[str], read: Callable[[pd.DataFrame], pd.DataFrame]
) -> Iterator[pd.DataFrame]:
    """Yield the result of `read` for each session's event table.

    Raises `InvalidFile` if a file is damaged or lacks one of the columns.
    """
    for file in sorted((path / "journals").glob("participant-*_events.tsv")) if path.is_dir() else []:
        keys = keys_of(file.stem)
        try:
            events = pd.read_csv(file, sep="\t", keep_default_na=False, quoting=3, dtype=str)  # csv.QUOTE_NONE
            yield read(events).assign(participant=keys["participant"], session=int(keys["session"]))
        except (KeyError, ValueError, OSError) as damage:
            expected = f"expected the columns {', '.join(columns)}"
            raise InvalidFile(f"{file}: found a damaged file of events ({damage}), {expected}") from None


def _reported(events: pd.DataFrame) -> pd.DataFrame:
    """Return the events to report, with trial numbers inserted in their texts."""
    table = events[events["trial_type"].isin(REPORTED)]
    of_trial = (table["trial_type"] == "order") & (table["trial"] != "n/a")
    text = table["text"].where(~of_trial, table["text"] + " trial " + table["trial"])
    return table[["trial_type"]].assign(onset=table["onset"].astype(float), text=text)
