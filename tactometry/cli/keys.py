"""`tactometry keys`: the keys of a table in a file."""

from dataclasses import asdict
from textwrap import fill
from typing import TYPE_CHECKING, Any, Final

import click
from click.shell_completion import CompletionItem

from ..config.strict import InvalidKey
from .output import say, subcommand

if TYPE_CHECKING:
    from tactometry.experiments.reference.tables import KeyTable

WIDTH: Final = 80
"""Columns of the output."""


class TableName(click.ParamType[str]):
    name = "NAME"

    def shell_complete(self, ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
        del ctx, param
        from tactometry.experiments.reference.tables import tables

        return [CompletionItem(name) for name in tables() if name.startswith(incomplete)]


@subcommand("keys procedure.staircase")
@click.argument("name", type=TableName(), required=False)
def command(name: str | None) -> None:
    """Explain the keys of a table of a study, bench, scene or map file.

    Type, unit, default, range, meaning and an example are printed for each key. NAME is a table, such as touch.slide,
    bench.output or map, or `texts` for the texts that [texts] may replace. Without NAME, all names are listed.
    """
    from tactometry.experiments.reference.tables import find, tables, toml_value

    if name == "texts":
        shipped = _shipped_texts()
        say("\n".join(f"{message} = {toml_value(text)}" for message, text in shipped.items()), shipped)
        return
    if name is None:
        say(_names(list(tables())), list(tables()))
        return
    result = find(name)
    if len(result) > 1 and result[0].name != name:
        say("\n".join(table.name for table in result), [table.name for table in result])
        return
    say("\n\n".join(map(_text, result)), [_record(table) for table in result])


def _shipped_texts() -> dict[str, str]:
    """Return the English messages and labels by name, in file order."""
    from ..rigs.texts import texts_in

    shipped = texts_in("en", {})
    return {**shipped.messages, **shipped.labels}


def hint_of_keys(error: BaseException | None) -> str:
    """Return a hint to list the keys of a table if one is unknown or missing."""
    while error is not None and not isinstance(error, InvalidKey):
        error = error.__context__
    if error is None:
        return ""
    from tactometry.experiments.reference.tables import name_at

    name = name_at(error.read_by, str(error).partition(": ")[0])
    return f" (all keys: tactometry keys {name})" if name else ""


def _names(names: list[str]) -> str:
    groups: dict[str, list[str]] = {}
    for name in names:
        first, _, rest = name.partition(".")
        groups.setdefault(first, []).append(rest)
    lines = (f"{first:<12}{' '.join(filter(None, rest))}".rstrip() for first, rest in groups.items())
    return "\n".join(fill(line, WIDTH, subsequent_indent=" " * 12, break_on_hyphens=False) for line in lines)


def _record(table: "KeyTable") -> dict[str, Any]:
    from tactometry.experiments.reference.keys import block, keys_of

    keys = [asdict(key) | {"required": key.required} for key in keys_of(table)]
    return {"name": table.name, "table": table.header, "keys": keys, "example": block(table)}


def _text(table: "KeyTable") -> str:
    from rich.console import Console
    from rich.table import Column, Table

    from tactometry.experiments.reference.keys import block, heading, holds, keys_of

    keys = keys_of(table)
    columns = (
        Column("key", overflow="fold", ratio=5),
        Column("holds", ratio=5),
        Column("if left out", overflow="fold", ratio=3),
    )
    shown = Table(*columns, Column("meaning", ratio=7), box=None, padding=(0, 1), expand=True)
    for key in keys:
        more = f" See: tactometry keys {key.see}" if key.see else ""
        means = f"{key.means}{more}".replace("``", '"').replace("`", "")
        shown.add_row(key.name, holds(key).replace("`", ""), key.otherwise or "required", means)
    console = Console()
    with console.capture() as capture:
        console.print(shown, markup=False, highlight=False)
    lines = [line.rstrip() for line in capture.get().splitlines()]
    opened = fill(f"{table.name}: {heading(table)}".replace("`", ""), WIDTH, break_on_hyphens=False)
    return "\n".join([opened, "", *lines, "", block(table).rstrip()])
