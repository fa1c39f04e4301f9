"""What commands share: results as JSON, files that they write, progress on a terminal."""

import json
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TypeVar

import click

T = TypeVar("T")
F = TypeVar("F", bound=Callable[..., object])

FIGURE_FORMATS = (".png", ".pdf", ".svg")

json_option: Callable[[F], F] = click.option("--json", "as_json", is_flag=True, help="Print the result as JSON.")


def say(text: str, value: object, *, as_json: bool) -> None:
    """Print a result: as text, or as JSON."""
    click.echo(json.dumps(value, indent=2) if as_json else text)


def check_figure(path: Path | None) -> None:
    """Refuse a figure whose name ends in no format, before anything is computed or measured."""
    from tactometry.errors import InvalidParameter

    if path is not None and path.suffix not in FIGURE_FORMATS:
        raise InvalidParameter(
            f"--figure: found {str(path)!r}, expected a name that ends in {', '.join(FIGURE_FORMATS)}"
        )


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """A file that cannot be written is one sentence."""
    from tactometry.errors import DeviceFailed

    try:
        yield
    except OSError as error:
        raise DeviceFailed(f"{path}: cannot write ({error.strerror}), expected a place to write to") from None


def progress(items: Iterable[T], total: int, what: str) -> Iterator[T]:
    """`items`, with a bar on standard error if that is a terminal."""
    if not sys.stderr.isatty():
        yield from items
        return
    from rich.console import Console
    from rich.progress import track

    yield from track(items, total=total, description=what, console=Console(stderr=True), transient=True)
