"""What commands share: results as JSON, progress on a terminal."""

import json
import sys
from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

import click

T = TypeVar("T")
F = TypeVar("F", bound=Callable[..., object])

json_option: Callable[[F], F] = click.option("--json", "as_json", is_flag=True, help="Print the result as JSON.")


def say(text: str, value: object, *, as_json: bool) -> None:
    """Print a result: as text, or as JSON."""
    click.echo(json.dumps(value, indent=2) if as_json else text)


def progress(items: Iterable[T], total: int, what: str) -> Iterator[T]:
    """`items`, with a bar on standard error if that is a terminal."""
    if not sys.stderr.isatty():
        yield from items
        return
    from rich.console import Console
    from rich.progress import track

    yield from track(items, total=total, description=what, console=Console(stderr=True), transient=True)
