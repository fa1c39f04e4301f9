"""Reference page of all commands and options, from their `--help`.

`python -m tactometry.cli.reference` (`make keys`) writes it.
"""

import inspect
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import click

from . import tactometry

PAGE: Final = Path(__file__).resolve().parents[2] / "docs" / "reference" / "commands.md"
HEAD: Final = """# Commands

<!-- Written by `make keys`. -->

This page lists every command and option, with the text of `--help`. The exit status is 0 on success, 1 if the answer is
no, 2 for input that cannot be used, and 3 if a device failed. `--json` prints results as JSON. A terminal shows a
progress bar.
"""


def text() -> str:
    """Return the page of the commands."""
    root = click.Context(tactometry, info_name="tactometry", **tactometry.context_settings)
    return "\n".join([HEAD, *_sections(tactometry, root)])


def _sections(group: click.Group, context: click.Context) -> Iterator[str]:
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        if command is not None:
            inner = click.Context(command, info_name=name, parent=context)
            yield _section(command, inner)
            yield from _sections(command, inner) if isinstance(command, click.Group) else ()


def _section(command: click.Command, context: click.Context) -> str:
    usage = " ".join([context.command_path, *command.collect_usage_pieces(context)])
    shown = [one for one in command.get_params(context) if isinstance(one, click.Option) and "--help" not in one.opts]
    options = [record for one in shown if (record := one.get_help_record(context))]
    rows = [f"| `{_cell(names)}` | {_cell(meaning)} |" for names, meaning in options]
    table = ["| option | meaning |", "|---|---|", *rows]
    example = (command.epilog or "").partition(": ")[2]
    parts = [
        f"## `{context.command_path}`",
        inspect.cleandoc(command.help or ""),
        f"Usage: `{usage}`",
        *(["\n".join(table)] if options else []),
        *([f"Example: `{example}`"] if example else []),
    ]
    return "\n\n".join(parts) + "\n"


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|").replace("<", "&lt;")


def main() -> None:
    PAGE.write_text(text(), encoding="utf-8")


if __name__ == "__main__":
    main()
