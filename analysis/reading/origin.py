"""Origin of the answers: study file, and real or simulated participants."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pandas as pd

from tactometry.arguments.require import expect
from tactometry.config.toml import errors_in, read_table
from tactometry.errors import InvalidFile, count_of
from tactometry.questionnaire import (
    ChoiceForm,
    Questionnaire,
    choice_forms_of,
    load,
    load_choices,
    questionnaires_of,
    shipped_choices,
    shipped_names,
)
from tactometry.records.description import SIMULATED
from tactometry.records.head import Head, changes, heads

from ..arrays import Bools
from ..wording import first_named
from .level_scale import SETTINGS
from .rows import holds
from .trials import Trials

SessionKey = tuple[str, float]
"""Participant code and session number."""


@dataclass(frozen=True)
class Origin:
    """Origin of the answers, with its texts in the report.

    `heads` are the journal heads of all sittings, by session.
    """

    is_simulated: bool = False
    seeds: tuple[int, ...] = ()
    warnings: tuple[str, ...] = ()
    felt: tuple[str, ...] = ()
    heads: Mapping[SessionKey, tuple[Head, ...]] = field(default_factory=dict, repr=False)

    @property
    def line(self) -> str:
        """First line of a report; empty for real participants.

        >>> Origin(is_simulated=True, seeds=(5,)).line
        'Simulated participants, no people (seed 5).'
        """
        return f"Simulated participants, no people ({self._seeds})." if self.is_simulated else ""

    @property
    def method(self) -> str:
        """Beginning of the methods paragraph; empty for real participants.

        >>> Origin(is_simulated=True).method
        'The participants were simulated by Tactometry (seed not known); no person took part. '
        """
        if not self.is_simulated:
            return ""
        felt = "".join(f"The stimuli were perceived through these effects: {words}. " for words in self.felt)
        return f"The participants were simulated by Tactometry ({self._seeds}); no person took part. {felt}"

    @property
    def _seeds(self) -> str:
        seeds = ", ".join(map(str, self.seeds)) or "not known"
        return f"{'seeds' if len(self.seeds) > 1 else 'seed'} {seeds}"


def of_one_kind(trials: Trials) -> tuple[Trials, Origin]:
    """Return the rows of real participants, or all rows if all are simulated.

    The `rig` of a row, or else the journal of its session, states whether it was simulated. Without either,
    participants count as real.
    """
    known = _heads_of(trials.path)
    mask = _is_simulated(trials.rows, known)
    first_heads = [sittings[0] for sittings in known.values()]  # a resumed session keeps its rig and seed
    seeds = tuple(sorted({head.seed for head in first_heads if head.rig == SIMULATED}))
    warnings = (*_silence_warnings(trials.rows), *_changes(known))
    if mask.all() and len(mask):
        felt = {str(head.facts["felt"]): None for head in first_heads if head.facts.get("felt")}
        origin = Origin(is_simulated=True, seeds=seeds, warnings=warnings, felt=tuple(felt), heads=known)
        return trials, replace(origin, warnings=(origin.line.removesuffix("."), *warnings))
    if not mask.any():
        return trials, Origin(warnings=warnings, heads=known)
    left_out = (
        f"simulated participants were excluded, as the table also contains real ones ({_codes(trials.rows[mask])})"
    )
    kept = replace(trials, rows=trials.rows[~mask].reset_index(drop=True))
    return kept, Origin(warnings=(f"{left_out}; analyse them separately", *warnings), heads=known)


def _heads_of(path: Path) -> dict[SessionKey, tuple[Head, ...]]:
    """Return the journal heads of all sittings, by session."""
    by_session: dict[SessionKey, tuple[Head, ...]] = {}
    for journal in sorted((path / "journals").glob("participant-*.jsonl")) if path.is_dir() else ():
        with suppress(InvalidFile):
            sittings = heads(journal)
            by_session |= {(sittings[0].participant, float(sittings[0].session)): sittings} if sittings else {}
    return by_session


def _is_simulated(rows: pd.DataFrame, known: Mapping[SessionKey, Sequence[Head]]) -> Bools:
    rigs = rows["rig"].astype(str) if "rig" in rows.columns else pd.Series("", index=rows.index)
    if known and "session" in rows.columns and (rigs == "").any():
        by_journal = {key: sittings[0].rig for key, sittings in known.items()}
        keys = zip(rows["participant"], rows["session"], strict=True)
        of_sessions = pd.Series([by_journal.get(key, "") for key in keys], index=rows.index)
        rigs = rigs.mask(rigs == "", of_sessions)
    return np.asarray(rigs == SIMULATED)


def _silence_warnings(rows: pd.DataFrame) -> Iterator[str]:
    """Warn about trials with a requested but no delivered level.

    Only rows with a rig are examined. Tasks in which the participant sets the level are skipped.
    """
    if not {"rig", "level_delivered"} <= set(rows.columns):
        return
    is_felt = rows["level"].notna() & ~rows["task"].isin(SETTINGS)
    played = rows[(rows["rig"] != "") & ~holds(rows, "valid", 0) & is_felt]
    silent = played[played["level_delivered"].isna()]
    if len(silent):
        yield f"no stimulus was presented in some trials with a level ({_codes(silent)}); these answers are invalid"


def _codes(rows: pd.DataFrame) -> str:
    codes = list(dict.fromkeys(rows["participant"]))
    return f"{first_named(codes)}: {count_of(len(rows), 'row')}"


def _changes(known: Mapping[SessionKey, Sequence[Head]]) -> Iterator[str]:
    for (code, session), sittings in known.items():
        for change in changes(sittings):
            yield f"{code}, session {session:g}: {change}"


T = TypeVar("T")


@dataclass(frozen=True)
class StudyText:
    """Title and procedure of a study, and its force (N) if fixed."""

    title: str = ""
    procedure: str = ""
    force_n: float | None = None


def study_table(path: Path, name: str, read: Callable[[Mapping[str, Any]], T]) -> T:
    """Apply `read` to a table of a folder's study, or to an empty table.

    Raises `InvalidFile` if the study cannot be read, or `read` raises for its table.
    """
    file = path / "study.toml"
    table = read_table(file, "the study that ran").get(name, {}) if file.is_file() else {}
    with errors_in(file):
        expect(isinstance(table, Mapping), name, f"{table!r:.60}", "a table")
        return read(table)


def forms_of(path: Path) -> Mapping[str, Questionnaire]:
    """Return the built-in questionnaires and those in the study's `[forms]`.

    Raises `InvalidFile` as `study_table`.

    >>> "attrakdiff" in forms_of(Path("no data set"))
    True
    """
    return {name: load(name) for name in shipped_names()} | study_table(path, "forms", questionnaires_of)


def choices_of(path: Path) -> Mapping[str, ChoiceForm]:
    """Return the built-in choice forms and those in the study's `[forms]`.

    Raises `InvalidFile` as `study_table`.

    >>> "demographics" in choices_of(Path("no data set"))
    True
    """
    return {name: load_choices(name) for name in shipped_choices()} | study_table(path, "forms", choice_forms_of)
