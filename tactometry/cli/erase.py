"""`tactometry erase`."""

import sys
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..errors import InvalidParameter, count_of
from .output import data_argument, say, subcommand

if TYPE_CHECKING:
    from tactometry.experiments.data_sets.erasing import Erased


@subcommand("erase data --participant P07 --dry-run")
@data_argument
@click.option("--participant", metavar="ID", required=True, help="Whose data are erased.")
@click.option("--yes", is_flag=True, help="Erase without asking.")
@click.option("--dry-run", is_flag=True, help="List what would be erased, and erase nothing.")
def command(path: Path, participant: str, *, yes: bool, dry_run: bool) -> int:
    """Erase all that the data set PATH holds of one participant, and record that it was done (erasures.jsonl).

    Sessions, traces, reports, figures and exports within PATH are erased. Files of other participants stay as they
    are. Files that Tactometry did not write stay too; they are listed, so that you can look at them. If the command
    is interrupted, run it again. Exit status 1 if the answer to the question is no.
    """
    from tactometry.experiments.data_sets.erasing import erase, find

    found = find(path, participant)
    if not dry_run:
        if not (yes or _is_wanted(path, found)):
            say(f"{path}: nothing was erased", _record(found, path, dry_run=True))
            return 1
        found = erase(path, participant)
    say("\n".join(_text(path, found, dry_run=dry_run)), _record(found, path, dry_run=dry_run))
    return 0


def _is_wanted(path: Path, found: "Erased") -> bool:
    if not sys.stdin.isatty():
        raise InvalidParameter("erase: found no terminal to ask at, expected --yes (or --dry-run, which only lists)")
    sessions, files = count_of(found.n_sessions, "session"), count_of(len(found.own) + len(found.derived), "file")
    question = f"{path}: erase {sessions} of {found.participant} ({files}) for good? There is no way back"
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
        yield f"derived from several participants, {did} too; make anew what is needed, with analyse, show and export:"
        yield from (f"  {name}" for name in found.derived)
    if found.others:
        yield "not searched; look whether these name the participant, and edit or remove them:"
        yield from (f"! {name}" for name in found.others)
    yield found.not_reached
