"""Interruptions and interventions in sessions, from their journals."""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Final

import pandas as pd

from tactometry.errors import InvalidFile
from tactometry.records.data_set import keys_of
from tactometry.records.head import Head, differences

from .origin import SessionKey

TOLD: Final = ("remark", "pause", "repeat", "stop", "abort", "order", "intervention")
"""Kinds of events that the report lists."""
EVENT_COLUMNS: Final = ("participant", "session", "onset", "trial_type", "text")


def sittings(known: Mapping[SessionKey, Sequence[Head]]) -> pd.DataFrame:
    """Return the sittings of interrupted sessions, with changes between them."""
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
    """Return the reported events of all sessions with their times (s).

    Raises `InvalidFile` if a file of events lacks a column.
    """
    files = sorted((path / "journals").glob("participant-*_events.tsv")) if path.is_dir() else []
    tables = [table for file in files if len(table := _told(file))]
    return pd.concat(tables, ignore_index=True) if tables else pd.DataFrame(columns=EVENT_COLUMNS)


def _told(file: Path) -> pd.DataFrame:
    try:
        events = pd.read_csv(file, sep="\t", keep_default_na=False, quoting=3, dtype=str)  # 3: QUOTE_NONE
        told = events[events["trial_type"].isin(TOLD)]
        keys = keys_of(file.stem)
        told = told.assign(
            participant=keys["participant"],
            session=int(keys["session"]),
            onset=told["onset"].astype(float),
            text=_words(told),
        )
        return told[list(EVENT_COLUMNS)]
    except (KeyError, ValueError, OSError) as damage:
        names = ", ".join(EVENT_COLUMNS[2:])
        raise InvalidFile(f"{file}: found no events ({damage}), expected the columns {names}") from None


def _words(told: pd.DataFrame) -> pd.Series:
    """Return the text of each event; orders about a trial include its number."""
    of_trial = (told["trial_type"] == "order") & (told["trial"] != "n/a")
    return told["text"].where(~of_trial, told["text"] + " trial " + told["trial"])
