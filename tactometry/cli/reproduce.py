"""`tactometry reproduce`."""

from dataclasses import asdict
from pathlib import Path

import click

from tactometry.experiments.thesis import REPRODUCTIONS, reproduction_of
from tactometry.experiments.thesis.page import count_verdicts, item_of, page as page_of, reason_for, show_number
from tactometry.experiments.thesis.reproduction import Number, Reproduced, reproduce

from ..arguments.require import expect, one_of
from ..files.rows import write_records
from .output import path_option, progress, say, subcommand, writing


@subcommand("reproduce table-4.3 --out reproduced")
@click.argument("name", metavar="NAME|all")
@path_option("--out", help="Folder for a CSV of each table and finding, and a PNG and a CSV of each figure.")
@path_option("--page", help="Write a page (Markdown) that compares tables and findings with those of the thesis.")
def command(*, name: str, out: Path | None, page: Path | None) -> None:
    """Reproduce tables, figures and findings of the thesis.

    Derived numbers follow from the physics, calibrated ones from a fitted constant, and assumed ones are inputs.
    """
    items = [reproduction_of(item) for item in (REPRODUCTIONS if name == "all" else (_item_of(name),))]
    made = [reproduce(item) for item in progress(items, len(items), "reproducing")]
    if out is not None:
        for reproduced in progress(made, len(made), "writing"):
            _write(reproduced, out)
    if page is not None:
        with writing(page):
            page.write_text(page_of(made), encoding="utf-8")
    say(_text(made), {reproduced.item.name: _record(reproduced) for reproduced in made})


def _item_of(name: str) -> str:
    """Return the item with this name or caption, or raise with the reason."""
    reason = reason_for(name)
    expect(reason is None, "NAME", name, f"an item that can be reproduced: this is {reason}")
    one_of("NAME", item_of(name), ("all", *REPRODUCTIONS))
    return item_of(name)


def _write(reproduced: Reproduced, out: Path) -> None:
    item = reproduced.item
    if reproduced.numbers:
        write_records(Number, reproduced.numbers, out / f"{item.name}.csv")
    if item.drawing is not None:
        from tactometry.experiments.thesis.figures.writing import write_drawing

        write_drawing(item.drawing(), out, item.name)


def _text(made: list[Reproduced]) -> str:
    """Format statements and results, and all numbers if there is one item."""
    lines = []
    for reproduced in made:
        numbers = reproduced.numbers if len(made) == 1 else reproduced.compared
        lines += [f"{reproduced.item.name}: {reproduced.item.title}"] if numbers else []
        for number in numbers:
            comparison = f"; stated: {number.stated}: {number.verdict.strip('*')}" if number.stated else ""
            value = f"{show_number(number)} {number.unit}".strip()
            lines.append(f"  {number.quantity}, {number.condition}: {value} ({number.origin}{comparison})")
    counts = ", ".join(f"{words.strip('*')}: {n}" for words, n in sorted(count_verdicts(made).items()))
    return "\n".join([*lines, counts or "the numbers of the thesis are not available for comparison"])


def _record(reproduced: Reproduced) -> dict[str, object]:
    item, numbers = reproduced.item, [asdict(number) for number in reproduced.numbers]
    return {"title": item.title, "stated": item.stated, "assumes": item.assumes, "numbers": numbers}
