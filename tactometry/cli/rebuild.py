"""`tactometry rebuild`."""

from dataclasses import asdict
from pathlib import Path

import click

from .output import json_option, say


@click.command(name="rebuild", epilog="Example: tactometry rebuild demo")
@click.argument("path", type=click.Path(path_type=Path))
@json_option
def command(path: Path, *, as_json: bool) -> None:
    """Write what is derived from the journals of the data set or journal PATH anew: trials, events, descriptions.

    A trials file that holds what its journal does not is left alone and told.
    """
    from tactometry.experiments.data_sets.replaying import rebuild_data_set

    from ..errors import counted

    rebuilt = rebuild_data_set(path)
    lines = [f"{each.trials}: {counted(each.n_trials, 'trial')}{', mended' * each.changed}" for each in rebuilt]
    say("\n".join(lines) or f"{path}: no session has begun", [asdict(each) for each in rebuilt], as_json=as_json)
