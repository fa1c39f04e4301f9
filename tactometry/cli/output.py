"""Shared parts of commands: options, results, progress, questions."""

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
    """Name of a built-in file, or path. `names` is a target string."""

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
    """Return an option that names a file or a folder."""
    return click.option(*names, type=click.Path(path_type=Path), **said)


def figure_option(said: str) -> Callable[[F], F]:
    """Return the option of a figure, which refuses a wrong format early."""
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
    "--hands-off", is_flag=True, help="Confirm that no hand is on the surface, so that an amplifier may play."
)
allow_code_option: Callable[[F], F] = click.option(
    "--allow-code", is_flag=True, help="Run the code that STUDY names as module:Class, from a file next to it."
)
allow_erased_option: Callable[[F], F] = click.option(
    "--allow-erased", is_flag=True, help="Allow new sessions of an erased participant."
)
data_argument: Callable[[F], F] = click.argument("path", type=click.Path(path_type=Path))


def subcommand(example: str, group: click.Group | None = None) -> Callable[[Callable[..., Any]], click.Command]:
    """Create a command with an example in its help and the option `--json`."""

    def made_of(function: Callable[..., Any]) -> click.Command:
        made = click.command(epilog=f"Example: tactometry {example}")(function)
        made.params.append(click.Option(["--json"], help="Print the result as JSON.", **_JSON))
        if group is not None:
            group.add_command(made)
        return made

    return made_of


def say(text: str, value: object) -> None:
    """Print the result of the running command, as text or as JSON."""
    as_json = click.get_current_context().meta[_AS_JSON]
    click.echo(json.dumps(_finite(value), indent=2, allow_nan=False) if as_json else text)


def _finite(value: object) -> object:
    """Replace numbers that are not finite by null, which JSON supports."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {name: _finite(part) for name, part in value.items()}
    return [_finite(part) for part in value] if isinstance(value, list | tuple) else value


def drawn_seed(seed: int | None, *, resume: bool = False) -> int:
    """Return the seed, or draw a seed and print it on standard error.

    Raises `InvalidParameter` if an interrupted run is continued without its seed.
    """
    if seed is not None:
        return seed
    if resume:
        raise InvalidParameter("--seed: found none, expected the seed that the interrupted run printed")
    seed = secrets.randbelow(2**32)
    click.echo(f"seed: {seed} (repeat with this --seed)", err=True)
    return seed


def writing(path: Path) -> AbstractContextManager[None]:
    """Raise a short error if a file cannot be written."""
    return attempt(path, "cannot write", "a writable place")


def progress(items: Iterable[T], total: int, what: str) -> Iterator[T]:
    """Yield `items`, with a progress bar if standard error is a terminal."""
    if not sys.stderr.isatty():
        yield from items
        return
    from rich.console import Console
    from rich.progress import track

    yield from track(items, total=total, description=what, console=Console(stderr=True), transient=True)


def hands_are_off() -> bool:
    """Return True if a user types that no hand is on the surface."""
    if not sys.stdin.isatty():
        return False
    question = f"The output will play. Type '{HANDS_OFF}' when no hand is on the surface"
    return str(click.prompt(question, default="", err=True)).strip().casefold() == HANDS_OFF
