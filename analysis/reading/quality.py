"""What became of the screen's frames, from the events of the sessions of a data set."""

from pathlib import Path

import pandas as pd

from tactometry.errors import InvalidFile

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
    parts = [part for file in files if len(part := _one(file))]
    if not parts:
        return pd.DataFrame(columns=["participant", *COUNTS, SLOWEST])
    whole = pd.concat(parts, ignore_index=True)
    return whole.groupby("participant", sort=True).agg(dict.fromkeys(COUNTS, "sum") | {SLOWEST: "max"}).reset_index()


def _one(file: Path) -> pd.DataFrame:
    try:
        events = pd.read_csv(file, sep="\t", na_values=["n/a"], quoting=3)
        trials = events[events["trial_type"] == "trial"][[*COUNTS, SLOWEST]].dropna(subset=list(COUNTS))
        return trials.astype(float).assign(participant=file.name.split("_")[0].removeprefix("participant-"))
    except (KeyError, ValueError, OSError) as damage:
        names = ", ".join(("trial_type", *COUNTS, SLOWEST))
        raise InvalidFile(f"{file}: found no events ({damage}), expected the columns {names}") from None


def with_frames(quality: pd.DataFrame, found: pd.DataFrame) -> pd.DataFrame:
    """The quality of the data with the frames of each participant."""
    if found.empty:
        return quality
    return quality.merge(found, on="participant", how="left").astype(dict.fromkeys(COUNTS, "Int64"))
