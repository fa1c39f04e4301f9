"""`tactometry replay`."""

from dataclasses import asdict
from pathlib import Path

import click

from .output import json_option, say


@click.command(name="replay", epilog="Example: tactometry replay demo")
@click.argument("path", type=click.Path(path_type=Path))
@json_option
def command(path: Path, *, as_json: bool) -> None:
    """Feed the recorded answers of the data set or journal PATH back into its protocol.

    Exit status 1, with the line or row, at the first divergence.
    """
    from tactometry.experiments.data_sets.replaying import replay_data_set

    from ..errors import counted

    replayed = replay_data_set(path)
    lines: list[str] = []
    for session in replayed:
        unfinished = "" if session.complete else ", session not finished"
        lines.append(f"{session.journal}: {counted(session.n_trials, 'row')} agree{unfinished}")
        lines += [f"{session.journal}: {change}" for change in session.changes]
    say("\n".join(lines), [asdict(session) for session in replayed], as_json=as_json)
