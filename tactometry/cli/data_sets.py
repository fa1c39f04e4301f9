"""Commands on data sets: replay, validate, rebuild, export and erase."""

import sys
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..errors import InvalidParameter, count_of
from .output import data_argument, path_option, say, subcommand

if TYPE_CHECKING:
    from tactometry.experiments.data_sets.erasing import Erased

FORMS = ("bids", "jspsych", "psych-ds", "psychopy", "r")


@subcommand("replay demo")
@data_argument
def replay(path: Path) -> None:
    """Replay the answers of the data set or journal PATH.

    The first divergence is reported with its line or row, with exit status 1.
    """
    from tactometry.experiments.data_sets.replaying import replay_data_set

    replayed = replay_data_set(path)
    lines: list[str] = []
    for session in replayed:
        unfinished = "" if session.complete else ", but the session is not finished"
        lines.append(f"{session.journal}: {count_of(session.n_trials, 'row')} agree{unfinished}")
        lines += [f"{session.journal}: {change}" for change in session.changes]
    say("\n".join(lines), [asdict(session) for session in replayed])


@subcommand("validate demo")
@data_argument
def validate(path: Path) -> int:
    """Check the data set or trials file PATH and list every defect.

    Exit status 1 if there are defects.
    """
    from tactometry.experiments.data_sets import validation

    report = validation.validate(path)
    verdict = count_of(sum(defect.n_rows for defect in report.defects), "defect") if report.defects else "sound"
    summary = f"{path}: {verdict}; {count_of(report.n_sessions, 'session')}, {count_of(report.n_trials, 'row')}"
    say("\n".join([*map(str, report.defects), *report.notes, summary]), asdict(report))
    return 1 if report.defects else 0


@subcommand("rebuild demo")
@data_argument
def rebuild(path: Path) -> None:
    """Rebuild trials, events and descriptions of PATH from its journals.

    A trials file with rows that are not in its journal is reported and not changed.
    """
    from tactometry.experiments.data_sets.replaying import rebuild_data_set

    rebuilt = rebuild_data_set(path)
    lines = [f"{file.trials}: {count_of(file.n_trials, 'trial')}{', repaired' * file.changed}" for file in rebuilt]
    say("\n".join(lines) or f"{path}: no session has begun", [asdict(file) for file in rebuilt])


@subcommand("export demo --to bids --out demo_bids --author 'Ada Lovelace' --author 'Alan Turing'")
@data_argument
@click.option(
    "--to",
    "form",
    type=click.Choice(FORMS),
    required=True,
    help="BIDS, jsPsych's JSON, Psych-DS, PsychoPy's CSV, or a table for R.",
)
@path_option("--out", required=True, help="Folder to write, new or empty.")
@click.option("--author", "authors", multiple=True, help="Author of a BIDS data set; may be repeated.")
def export(path: Path, form: str, out: Path, authors: tuple[str, ...]) -> None:
    """Export the data set or trials file PATH to another format."""
    from tactometry.experiments.data_sets import export as data_sets

    written = data_sets.export(path, form, out, authors)
    result = {"path": str(path), "to": form, "out": str(out), "files": [str(file.relative_to(out)) for file in written]}
    say(f"{out}: {len(written)} files", result)


@subcommand("erase data --participant P07 --dry-run")
@data_argument
@click.option("--participant", metavar="ID", required=True, help="Code of the participant.")
@click.option("--yes", is_flag=True, help="Erase without confirmation.")
@click.option("--dry-run", is_flag=True, help="List what would be erased, and erase nothing.")
def erase(path: Path, participant: str, *, yes: bool, dry_run: bool) -> int:
    """Erase the data of one participant from the data set PATH.

    The erasure is recorded in erasures.jsonl. Sessions, traces, reports, figures and exports within PATH are erased.
    Files of other participants are not changed. Files that Tactometry did not write are kept, and listed for you to
    check. If the command is interrupted, run it again. Exit status 1 if you do not confirm.
    """
    from tactometry.experiments.data_sets import erasing

    result = erasing.find(path, participant)
    if not dry_run:
        if not (yes or _is_wanted(path, result)):
            say(f"{path}: nothing was erased", _record(result, path, dry_run=True))
            return 1
        result = erasing.erase(path, participant)
    say("\n".join(_text(path, result, dry_run=dry_run)), _record(result, path, dry_run=dry_run))
    return 0


def _is_wanted(path: Path, found: "Erased") -> bool:
    if not sys.stdin.isatty():
        raise InvalidParameter("erase: found no terminal for a confirmation, expected --yes or --dry-run")
    sessions, files = count_of(found.n_sessions, "session"), count_of(len(found.own) + len(found.derived), "file")
    question = f"{path}: erase {sessions} of {found.participant} ({files}) permanently? This cannot be undone"
    return click.confirm(question, default=False, err=True)


def _record(found: "Erased", path: Path, *, dry_run: bool) -> dict[str, object]:
    return {"path": str(path), "dry_run": dry_run, **asdict(found)}


def _text(path: Path, found: "Erased", *, dry_run: bool) -> Iterator[str]:
    if dry_run:
        yield from found.own
    did = "would erase" if dry_run else "erased"
    files = count_of(len(found.own), "file")
    yield f"{path}: {did} {found.participant}, {count_of(found.n_sessions, 'session')} in {files}"
    if found.derived:
        yield f"{did} these files of several participants; recreate them with analyse, show and export:"
        yield from (f"  {name}" for name in found.derived)
    if found.others:
        yield "not searched; check whether these files name the participant, and edit or remove them:"
        yield from (f"! {name}" for name in found.others)
    yield found.not_reached
