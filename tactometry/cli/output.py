"""What commands share: options, results as text or JSON, files that they write, progress, a word at the terminal."""

import json
import math
import secrets
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, Final, TypeVar

import click
from click.shell_completion import CompletionItem

from ..errors import InvalidParameter, attempt
from ..loading import resolve

T = TypeVar("T")
F = TypeVar("F", bound=Callable[..., object])

FIGURE_FORMATS = (".png", ".pdf", ".svg")
HANDS_OFF: Final = "hands off"
_AS_JSON: Final = f"{__name__}.as_json"


class NamedFile(click.Path):
    """The name of a built-in file, or the path of another; both are completed.

    - `names`: Target string of what gives the names.
    """

    def __init__(self, names: str) -> None:
        super().__init__()
        self._names = names

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        del param, ctx
        return value

    def shell_complete(self, ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
        named = [CompletionItem(name) for name in resolve(self._names)() if name.startswith(incomplete)]
        return named or super().shell_complete(ctx, param, incomplete)


STUDY: Final = NamedFile("tactometry.experiments.study.study_file:shipped")
SCENE: Final = NamedFile("tactometry.experiments.scenes:names")


def path_option(*names: str, **said: Any) -> Callable[[F], F]:
    """An option that names a file or a folder."""
    return click.option(*names, type=click.Path(path_type=Path), **said)


def figure_option(said: str) -> Callable[[F], F]:
    """The option of a figure, refused before anything is computed or measured if its name ends in no format."""
    return path_option("--figure", callback=_check_figure, help=said)


def _check_figure(ctx: click.Context, param: click.Parameter, path: Path | None) -> Path | None:
    del ctx, param
    if path is not None and path.suffix not in FIGURE_FORMATS:
        formats = ", ".join(FIGURE_FORMATS)
        raise InvalidParameter(f"--figure: found {str(path)!r}, expected a name that ends in {formats}")
    return path


def _keep_form(ctx: click.Context, param: click.Parameter, as_json: bool) -> None:
    del param
    ctx.meta[_AS_JSON] = as_json


_JSON: Final[dict[str, Any]] = {"is_flag": True, "expose_value": False, "callback": _keep_form}
bench_option: Callable[[F], F] = path_option("--bench", "bench_path", help="Bench file (TOML).")
hands_off_option: Callable[[F], F] = click.option(
    "--hands-off", is_flag=True, help="No hand is on the surface: an output that leads to an amplifier may play."
)
allow_code_option: Callable[[F], F] = click.option(
    "--allow-code", is_flag=True, help="Run the code that STUDY names as module:Class, from a file beside it."
)
allow_erased_option: Callable[[F], F] = click.option(
    "--allow-erased", is_flag=True, help="Record a participant again who was erased from the data set."
)
data_argument: Callable[[F], F] = click.argument("path", type=click.Path(path_type=Path))


def subcommand(example: str, group: click.Group | None = None) -> Callable[[Callable[..., Any]], click.Command]:
    """A command, of a group if one is given, with an example below its help, which says its result as text or JSON."""

    def made_of(function: Callable[..., Any]) -> click.Command:
        made = click.command(epilog=f"Example: tactometry {example}")(function)
        made.params.append(click.Option(["--json"], help="Print the result as JSON.", **_JSON))
        if group is not None:
            group.add_command(made)
        return made

    return made_of


def say(text: str, value: object) -> None:
    """Print the result of the command that runs: as text, or as JSON where that was asked for."""
    as_json = click.get_current_context().meta[_AS_JSON]
    click.echo(json.dumps(_finite(value), indent=2, allow_nan=False) if as_json else text)


def _finite(value: object) -> object:
    """`value` with null where a number is not finite: JSON has no other word for it."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {name: _finite(part) for name, part in value.items()}
    return [_finite(part) for part in value] if isinstance(value, list | tuple) else value


def drawn_seed(seed: int | None, *, resume: bool = False) -> int:
    """Return the seed, or draw one and print it on standard error.

    Raises `InvalidParameter` if what is resumed has another seed than one that is drawn.
    """
    if seed is not None:
        return seed
    if resume:
        raise InvalidParameter("--seed: found none, expected the seed that the interrupted run printed")
    seed = secrets.randbelow(2**32)
    click.echo(f"seed: {seed} (the same --seed repeats this)", err=True)
    return seed


def writing(path: Path) -> AbstractContextManager[None]:
    """A file that cannot be written is one sentence."""
    return attempt(path, "cannot write", "a place to write to")


def progress(items: Iterable[T], total: int, what: str) -> Iterator[T]:
    """`items`, with a bar on standard error if that is a terminal."""
    if not sys.stderr.isatty():
        yield from items
        return
    from rich.console import Console
    from rich.progress import track

    yield from track(items, total=total, description=what, console=Console(stderr=True), transient=True)


def hands_are_off() -> bool:
    """Whether somebody at the terminal types that no hand is on the surface; without a terminal nobody does.

    Asked before something plays that no gate stops.
    """
    if not sys.stdin.isatty():
        return False
    question = f"The output will play. Type '{HANDS_OFF}' when no hand is on the surface"
    return str(click.prompt(question, default="", err=True)).strip().casefold() == HANDS_OFF
