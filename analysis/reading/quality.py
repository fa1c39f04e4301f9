"""Data quality and interruptions by participant, and exclusion rules."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from itertools import pairwise
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd

from tactometry.arguments.require import expect, whole
from tactometry.errors import InvalidFile, InvalidParameter
from tactometry.records.data_set import keys_of
from tactometry.records.head import Head, differences
from tactometry.trials.tasks import FORM_TASK, PRACTICE_CRITERION, TASKS, YES_OR_NO
from tactometry.trials.trial import Tally

from .origin import SessionKey, study_table
from .rows import correctness, holds, is_catch, no_column, numbers_of
from .trials import Trials

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


COUNTS = ("n_frames", "n_dropped_frames")
SLOWEST = "frame_interval_max_s"


def frames(path: Path) -> pd.DataFrame:
    """Return frames, dropped frames and longest interval by participant.

    The result is empty outside a data set folder, or if nothing was shown on a screen.

    Raises `InvalidFile` if a file of events lacks a column, or a count is not a number.
    """
    tables = [table for table in session_events(path, ("trial_type", *COUNTS, SLOWEST), _frames) if len(table)]
    if not tables:
        return pd.DataFrame(columns=["participant", *COUNTS, SLOWEST])
    sessions = pd.concat(tables, ignore_index=True)
    return sessions.groupby("participant", sort=True).agg(dict.fromkeys(COUNTS, "sum") | {SLOWEST: "max"}).reset_index()


def _frames(events: pd.DataFrame) -> pd.DataFrame:
    trials = events.loc[events["trial_type"] == "trial", [*COUNTS, SLOWEST]].replace("n/a", np.nan)
    return trials.dropna(subset=list(COUNTS)).astype(float)


def with_frames(quality: pd.DataFrame, frames: pd.DataFrame) -> pd.DataFrame:
    """Add the columns of `frames` to the table of data quality."""
    if frames.empty:
        return quality
    return quality.merge(frames, on="participant", how="left").astype(dict.fromkeys(COUNTS, "Int64"))


def quality(trials: Trials) -> pd.DataFrame:
    """Count recorded, invalid, repeated and catch trials by participant."""
    rows = trials.rows
    practice, invalid, silent = holds(rows, "practice", 1), holds(rows, "valid", 0), rows["response"] == ""
    catch = is_catch(rows) & ~practice & ~invalid & ~silent
    flags = {
        "n_rows": True,
        "n_practice": practice,
        "n_invalid": invalid,
        "n_repeated": (rows["attempt"] > 1) & _is_first(rows) if "attempt" in rows.columns else False,
        "n_unanswered": silent & ~invalid,
        "n_catch": catch,
        "n_false_alarms": catch & rows["response"].isin(["1", "1.0"]),
    }
    table = pd.DataFrame(flags, index=rows.index).groupby(rows["participant"], sort=True).sum()
    rate = table["n_false_alarms"] / table["n_catch"].where(table["n_catch"] > 0)  # NaN without catch trials
    table, missed = table.assign(false_alarm_rate=rate), missed_practice(trials)
    if len(missed):
        table["practice_missed"] = missed.reindex(table.index).fillna(False).astype(int)
    return table.reset_index()


def tally_of(trials: Trials) -> Tally:
    """Count presentations and questionnaire answers as a session does."""
    rows = trials.rows
    is_form = (rows["task"] == FORM_TASK) & rows["level"].isna() if "level" in rows.columns else False
    first = rows[_is_first(rows) & ~pd.Series(is_form, rows.index)]
    n_again = int((first["attempt"] > 1).sum()) if "attempt" in rows.columns else 0
    return Tally(len(first), int(holds(first, "valid", 0).sum()), int(np.sum(is_form)), n_again=n_again)


def _is_first(rows: pd.DataFrame) -> "pd.Series[bool]":
    """Return True for the first row of each presentation."""
    if "item" not in rows.columns or "trial" not in rows.columns:
        return pd.Series(True, index=rows.index)
    keys = ["participant", *(name for name in ("source", "session", "block", "trial", "attempt") if name in rows)]
    return rows["item"].eq("") | ~rows.duplicated(keys)


TARGET = "force_n"


def missed_practice(trials: Trials) -> "pd.Series[bool]":
    """Return for each participant True if practice ended below the criterion.

    The result is empty if the study has no practice.
    """
    criterion = study_table(trials.path, "practice", _criterion)
    rows = trials.rows
    if criterion is None:
        return pd.Series(dtype=bool)
    n_correct, n_of = criterion
    rows = rows[holds(rows, "practice", 1) & ~holds(rows, "valid", 0) & ~is_catch(rows)]
    keys = [name for name in ("participant", "session") if name in rows.columns]
    right = _is_right(rows).groupby([rows[name] for name in keys], sort=True)
    missed = right.apply(lambda answers: answers.tail(n_of).sum() < n_correct)
    return missed.groupby(level=0).any().astype(bool)


def _criterion(table: Mapping[str, Any]) -> tuple[int, int] | None:
    """Return the practice criterion: `n_correct` of the last `n_of` answers."""
    if not table:
        return None
    stated = dict(zip(("n_correct", "n_of"), PRACTICE_CRITERION, strict=True)) | dict(table)
    whole("practice", lowest=1, n_correct=stated["n_correct"], n_of=stated["n_of"])
    return stated["n_correct"], stated["n_of"]


def _is_right(rows: pd.DataFrame) -> "pd.Series[bool]":
    """Return True for answers that are correct or cannot be scored."""
    by_response = rows["task"].isin([name for name, task in TASKS.items() if task.response is YES_OR_NO])
    counted = (numbers_of(rows["response"]) == 1).where(by_response, correctness(rows) != 0)
    return counted.astype(bool)


@dataclass(frozen=True)
class Exclusion:
    """Rules that exclude trials and participants; None disables a rule.

    Raises `InvalidParameter` if a bound is not a number of at least 0 (shares: at most 1), or the lowest latency is not
    below the highest.

    - `force_in_band_share_min`: Excludes trials in which the force was in the target band for a smaller share of the
      stimulus.
    - `force_deviation_ratio_max`: Excludes trials whose mean force deviates from the target (factor `force_n`) by more
      than this fraction of the target.
    - `latency_min_s`: Excludes trials with a shorter latency.
    - `latency_max_s`: Excludes trials with a longer latency.
    - `false_alarm_share_max`: Excludes participants with a higher false-alarm rate in catch trials.
    - `invalid_share_max`: Excludes participants with a larger share of invalid trials.
    - `practice`: Excludes participants who did not meet the practice criterion.
    """

    force_in_band_share_min: float | None = None
    force_deviation_ratio_max: float | None = None
    latency_min_s: float | None = None
    latency_max_s: float | None = None
    false_alarm_share_max: float | None = None
    invalid_share_max: float | None = None
    practice: bool = False

    def __post_init__(self) -> None:
        shares = ("force_in_band_share_min", "false_alarm_share_max", "invalid_share_max")
        for name, value in self.stated().items():
            top, to = (1.0, " to 1") if name in shares else (np.inf, "")
            expect(0 <= value <= top and np.isfinite(value), name, value, f"a number from 0{to}")
        is_ordered = (self.latency_min_s or 0.0) < (self.latency_max_s or np.inf)
        expect(is_ordered, "latency_max_s", self.latency_max_s, f"more than latency_min_s, {self.latency_min_s}")

    def stated(self) -> dict[str, float]:
        """Return the rules that are not None.

        >>> Exclusion(force_in_band_share_min=0.8).stated()
        {'force_in_band_share_min': 0.8}
        """
        values = {rule.name: getattr(self, rule.name) for rule in fields(self)}
        return {name: value for name, value in values.items() if value is not None and value is not False}


def exclude(trials: Trials, rules: Exclusion, quality: pd.DataFrame) -> tuple[Trials, pd.DataFrame]:
    """Apply exclusion rules and return remaining trials and exclusions.

    The rows keep their index. The table of exclusions has the columns `participant, rule, bound, n_trials`. `quality`
    is the data quality of the trials, used by the rules on participants.

    Raises `InvalidParameter` if the table lacks a column that a rule needs.
    """
    rows = trials.rows
    lost: list[tuple[object, ...]] = []
    out = pd.Series(False, index=rows.index)
    for name, bound in rules.stated().items():
        against_rule = _against_rule(rows, name, bound, quality)
        numbers = against_rule.groupby(rows["participant"], sort=True).sum()
        lost += [(code, name, bound, n) for code, n in numbers.items() if n]
        out |= against_rule
    return replace(trials, rows=rows[~out]), pd.DataFrame(lost, columns=["participant", "rule", "bound", "n_trials"])


def _against_rule(rows: pd.DataFrame, name: str, bound: float, quality: pd.DataFrame) -> "pd.Series[bool]":
    """Return True for rows that break a rule; missing values break no rule."""
    of = quality.set_index("participant")
    match name:
        case "force_in_band_share_min":
            return _column(rows, "force_in_band", name) < bound
        case "force_deviation_ratio_max":
            target = pd.to_numeric(_column(rows, TARGET, name), errors="coerce")
            return (_column(rows, "force_mean_n", name) - target).abs() > bound * target
        case "latency_min_s":
            return _column(rows, "latency_s", name) < bound
        case "latency_max_s":
            return _column(rows, "latency_s", name) > bound
        case "practice":
            is_out = of.get("practice_missed", pd.Series(0, of.index)) == 1
        case "false_alarm_share_max":
            is_out = of["false_alarm_rate"] > bound
        case _:
            is_out = of["n_invalid"] / of["n_rows"] > bound
    return rows["participant"].map(is_out).astype(bool)


def _column(rows: pd.DataFrame, name: str, rule: str) -> "pd.Series[float]":
    if name not in rows.columns:
        raise InvalidParameter(f"{rule}: {no_column(name, rows)}, which this rule requires")
    return rows[name]
