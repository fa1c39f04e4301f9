"""What commands share: results as JSON, files that they write, progress on a terminal."""

import json
import math
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
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
    click.echo(json.dumps(_finite(value), indent=2, allow_nan=False) if as_json else text)


def _finite(value: object) -> object:
    """`value` with null where a number is not finite: JSON has no other word for it."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {name: _finite(part) for name, part in value.items()}
    return [_finite(part) for part in value] if isinstance(value, list | tuple) else value


def check_figure(path: Path | None) -> None:
    """Refuse a figure whose name ends in no format, before anything is computed or measured."""
    from ..errors import InvalidParameter

    if path is not None and path.suffix not in FIGURE_FORMATS:
        raise InvalidParameter(
            f"--figure: found {str(path)!r}, expected a name that ends in {', '.join(FIGURE_FORMATS)}"
        )


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """A file that cannot be written is one sentence."""
    from ..errors import DeviceFailed

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
