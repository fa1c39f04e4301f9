"""`tactometry export`."""

from pathlib import Path

import click

from .output import json_option, say

FORMS = ("bids", "psych-ds", "psychopy", "r")


@click.command(
    name="export",
    epilog="Example: tactometry export demo --to bids --out demo_bids --author 'Ada Lovelace' --author 'Alan Turing'",
)
@click.argument("path", type=click.Path(path_type=Path))
@click.option(
    "--to", "form", type=click.Choice(FORMS), required=True, help="BIDS, Psych-DS, PsychoPy's CSV, or a table for R."
)
@click.option("--out", type=click.Path(path_type=Path), required=True, help="The folder to write, new or empty.")
@click.option("--author", "authors", multiple=True, help="An author of a BIDS data set; may be given again.")
@json_option
def command(path: Path, form: str, out: Path, authors: tuple[str, ...], *, as_json: bool) -> None:
    """The data set or trials file PATH in the form of another program; PATH stays as it is."""
    from tactometry.experiments.data_sets.export import export

    written = export(path, form, out, authors)
    result = {"path": str(path), "to": form, "out": str(out), "files": [str(file.relative_to(out)) for file in written]}
    say(f"{out}: {len(written)} files", result, as_json=as_json)
