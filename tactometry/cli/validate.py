"""`tactometry validate`."""

from dataclasses import asdict
from pathlib import Path

import click

from .output import json_option, say


@click.command(name="validate", epilog="Example: tactometry validate demo")
@click.argument("path", type=click.Path(path_type=Path))
@json_option
def command(path: Path, *, as_json: bool) -> int:
    """Check the data set or trials file PATH. Exit status 1 if it has defects; each is named with file and row."""
    from tactometry.experiments.data_sets.validation import validate

    from ..errors import counted

    found = validate(path)
    verdict = counted(sum(defect.n_rows for defect in found.defects), "defect") if found.defects else "sound"
    summary = f"{path}: {verdict}; {counted(found.n_sessions, 'session')}, {counted(found.n_trials, 'row')}"
    say("\n".join([*map(str, found.defects), *found.notes, summary]), asdict(found), as_json=as_json)
    return 1 if found.defects else 0
