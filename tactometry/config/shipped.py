"""Data files that lie in a package, each named by its stem."""

from collections.abc import Callable
from importlib.resources import files
from typing import Final, TypeVar

from ..arguments.require import one_of

T = TypeVar("T")
SUFFIX: Final = ".toml"


def shipped_in(package: str) -> tuple[str, ...]:
    """The names of the TOML files of a package.

    >>> "attrakdiff" in shipped_in("tactometry.questionnaires")
    True
    """
    names = (entry.name for entry in files(package).iterdir())
    return tuple(sorted(name.removesuffix(SUFFIX) for name in names if name.endswith(SUFFIX)))


def load_shipped(package: str, name: str, what: str, parse: Callable[[bytes, str], T]) -> T:
    """One of them, as `parse` makes it of its bytes and of what opens each sentence.

    Raises `InvalidParameter` if there is none of that name.
    """
    one_of(what, name, shipped_in(package))
    return parse((files(package) / f"{name}{SUFFIX}").read_bytes(), f"{what} {name}")
