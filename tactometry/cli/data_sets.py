"""`tactometry replay`, `validate`, `rebuild` and `export`: what is done with a data set that stands."""

from dataclasses import asdict
from pathlib import Path

import click

from ..errors import count_of
from .output import data_argument, path_option, say, subcommand

FORMS = ("bids", "jspsych", "psych-ds", "psychopy", "r")


@subcommand("replay demo")
@data_argument
def replay(path: Path) -> None:
    """Feed the recorded answers of the data set or journal PATH back into its protocol.

    Exit status 1, with the line or row, at the first divergence.
    """
    from tactometry.experiments.data_sets.replaying import replay_data_set

    replayed = replay_data_set(path)
    lines: list[str] = []
    for session in replayed:
        unfinished = "" if session.complete else ", session not finished"
        lines.append(f"{session.journal}: {count_of(session.n_trials, 'row')} agree{unfinished}")
        lines += [f"{session.journal}: {change}" for change in session.changes]
    say("\n".join(lines), [asdict(session) for session in replayed])


@subcommand("validate demo")
@data_argument
def validate(path: Path) -> int:
    """Check the data set or trials file PATH. Exit status 1 if it has defects; each is named with file and row."""
    from tactometry.experiments.data_sets import validation

    report = validation.validate(path)
    verdict = count_of(sum(defect.n_rows for defect in report.defects), "defect") if report.defects else "sound"
    summary = f"{path}: {verdict}; {count_of(report.n_sessions, 'session')}, {count_of(report.n_trials, 'row')}"
    say("\n".join([*map(str, report.defects), *report.notes, summary]), asdict(report))
    return 1 if report.defects else 0


@subcommand("rebuild demo")
@data_argument
def rebuild(path: Path) -> None:
    """Write what is derived from the journals of the data set or journal PATH anew: trials, events, descriptions.

    A trials file that holds what its journal does not is left alone and told.
    """
    from tactometry.experiments.data_sets.replaying import rebuild_data_set

    rebuilt = rebuild_data_set(path)
    lines = [f"{file.trials}: {count_of(file.n_trials, 'trial')}{', mended' * file.changed}" for file in rebuilt]
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
@path_option("--out", required=True, help="The folder to write, new or empty.")
@click.option("--author", "authors", multiple=True, help="An author of a BIDS data set; may be given again.")
def export(path: Path, form: str, out: Path, authors: tuple[str, ...]) -> None:
    """The data set or trials file PATH in the form of another program; PATH stays as it is."""
    from tactometry.experiments.data_sets import export as data_sets

    written = data_sets.export(path, form, out, authors)
    result = {"path": str(path), "to": form, "out": str(out), "files": [str(file.relative_to(out)) for file in written]}
    say(f"{out}: {len(written)} files", result)
