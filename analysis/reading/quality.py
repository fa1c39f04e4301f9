"""Per participant: what was recorded and used, how catch trials were answered, what became of the frames."""

from pathlib import Path

import pandas as pd

from tactometry.errors import InvalidFile

from .rows import holds, is_catch
from .trials import Trials

COUNTS = ("n_frames", "n_dropped_frames")
SLOWEST = "frame_interval_max_s"


def frames(path: Path) -> pd.DataFrame:
    """Per participant `n_frames`, `n_dropped_frames` and the longest interval between frames, s; empty without events
    of frames (no data set's folder, or nothing was shown on a screen).

    Raises
    ------
    InvalidFile
        If a file of events has not the columns, or something else than counts in them.
    """
    files = sorted((path / "journals").glob("participant-*_events.tsv")) if path.is_dir() else []
    tables = [table for file in files if len(table := _one(file))]
    if not tables:
        return pd.DataFrame(columns=["participant", *COUNTS, SLOWEST])
    whole = pd.concat(tables, ignore_index=True)
    return whole.groupby("participant", sort=True).agg(dict.fromkeys(COUNTS, "sum") | {SLOWEST: "max"}).reset_index()


def _one(file: Path) -> pd.DataFrame:
    try:
        events = pd.read_csv(file, sep="\t", na_values=["n/a"], quoting=3)
        trials = events[events["trial_type"] == "trial"][[*COUNTS, SLOWEST]].dropna(subset=list(COUNTS))
        return trials.astype(float).assign(participant=file.name.split("_")[0].removeprefix("participant-"))
    except (KeyError, ValueError, OSError) as damage:
        names = ", ".join(("trial_type", *COUNTS, SLOWEST))
        raise InvalidFile(f"{file}: found no events ({damage}), expected the columns {names}") from None


def with_frames(quality: pd.DataFrame, frames: pd.DataFrame) -> pd.DataFrame:
    """The quality of the data with the frames of each participant."""
    if frames.empty:
        return quality
    return quality.merge(frames, on="participant", how="left").astype(dict.fromkeys(COUNTS, "Int64"))


def quality(trials: Trials) -> pd.DataFrame:
    """Per participant: what was recorded, what of it is used, and how the catch trials were answered."""
    rows = trials.rows
    practice, invalid, silent = holds(rows, "practice", 1), holds(rows, "valid", 0), rows["response"] == ""
    catch = is_catch(rows) & ~practice & ~invalid & ~silent
    flags = {
        "n_rows": True,
        "n_practice": practice,
        "n_invalid": invalid,
        "n_repeated": _is_repeated(rows),
        "n_unanswered": silent & ~invalid,
        "n_catch": catch,
        "n_false_alarms": catch & rows["response"].isin(["1", "1.0"]),
    }
    table = pd.DataFrame(flags, index=rows.index).groupby(rows["participant"], sort=True).sum()
    rate = table["n_false_alarms"] / table["n_catch"].where(table["n_catch"] > 0)  # without catch trials NaN, not inf
    return table.assign(false_alarm_rate=rate).reset_index()


def _is_repeated(rows: pd.DataFrame) -> "pd.Series[bool]":
    """The first row of each attempt behind the first: a questionnaire has a row for each of its items."""
    if "attempt" not in rows.columns:
        return pd.Series(False, index=rows.index)
    keys = ["participant", *(name for name in ("source", "session", "block", "trial", "attempt") if name in rows)]
    first = rows["item"].eq("") | ~rows.duplicated(keys) if "item" in rows.columns else True
    return (rows["attempt"] > 1) & first
