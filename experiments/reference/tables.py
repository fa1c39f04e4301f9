"""Every table of every file that users write, by its name and by the page that holds it."""

from collections.abc import Callable, Collection, Iterator, Mapping
from difflib import get_close_matches
from functools import cache
from itertools import chain
from typing import Final

from tactometry.errors import InvalidParameter
from tactometry.loading import resolve

from .key_table import KeyTable

_HERE: Final = __package__
PAGES: Final[Mapping[str, tuple[str, ...]]] = {
    "studies": (
        f"{_HERE}.study_tables:study_tables",
        f"{_HERE}.people_tables:form_tables",
        f"{_HERE}.people_tables:people_tables",
    ),
    "procedures": (f"{_HERE}.study_tables:procedure_tables",),
    "bench": (f"{_HERE}.bench_tables:bench_tables",),
    "scenes": (f"{_HERE}.scene_tables:scene_tables", f"{_HERE}.scene_tables:plate_tables"),
    "maps": (f"{_HERE}.people_tables:map_tables",),
}
"""By the page that holds them, what gives the tables of a file."""


def tables_of_page(page: str) -> Iterator[KeyTable]:
    """The tables of a page, in its order."""
    makers: list[Callable[[], Iterator[KeyTable]]] = [resolve(target) for target in PAGES[page]]
    return chain.from_iterable(make() for make in makers)


@cache
def tables() -> Mapping[str, KeyTable]:
    """Every table, by its name.

    >>> tables()["touch.slide"].header
    '[touch]'
    """
    return {table.name: table for page in PAGES for table in tables_of_page(page)}


def find(name: str) -> tuple[KeyTable, ...]:
    """The table of a name with those whose keys may stand in it too, or those below the name.

    Raises
    ------
    InvalidParameter
        If there is none; the sentence has the nearest names.

    Examples
    --------
    >>> [table.name for table in find("touch.slide")], [table.name for table in find("touch")]
    (['touch.slide'], ['touch.press', 'touch.slide'])
    """
    known = tables()
    if name in known:
        return (known[name], *(known[other] for other in known[name].also))
    below = tuple(table for each, table in known.items() if each.startswith(f"{name}."))
    if below:
        return below
    near = _nearest(name)
    expected = f"one of {', '.join(near)}" if near else "a name that tactometry keys lists"
    raise InvalidParameter(f"NAME: found {name!r}, expected {expected}")


def inner_name(table: KeyTable, key: str, classes: Collection[type] = ()) -> str:
    """The name of the table, or of those, that hold the keys of what a key holds; empty where there is none.

    >>> inner_name(tables()["study"], "touch"), inner_name(tables()["bench"], "force")
    ('touch', 'bench.force')
    """
    of_study = (f"study.{key}", key) if table.name == "study" else ()
    by_place = [name for name in (f"{table.name}.{key}", *of_study) if _is_known(name)]
    by_class = [name for name in map(name_of, classes) if name]
    return next(iter((*by_place, *by_class)), "")


def name_of(kind: type) -> str:
    """The name of the table that a class reads; empty where it reads none, or only as one of several.

    >>> from tactometry.safety.limits import Limits
    >>> name_of(Limits)
    'limits'
    """
    module, names = kind.__module__, tables()
    target = f"{module}:{kind.__qualname__}"
    by_target = [name for name, table in names.items() if table.reads == target]
    of_module = [name for name, table in names.items() if table.reads == f"{module}:TASK.table"]
    return next(iter((*by_target, *of_module)), "")


def name_at(kind: type | None, path: str) -> str:
    """The name of the table that a class reads, else of those at the path of a key; empty where there is none.

    >>> name_at(None, "s.toml, task.over"), name_at(None, "s.toml, mood")
    ('task', '')
    """
    by_class = name_of(kind) if kind is not None else ""
    above = path.rpartition(", ")[2].rpartition(".")[0]
    return by_class or (above if _is_known(above) else "")


def _is_known(name: str) -> bool:
    return any(each == name or each.startswith(f"{name}.") for each in tables())


def _nearest(name: str) -> list[str]:
    """Names like this one, then those that hold its last word."""
    last = name.rpartition(".")[2]
    close = get_close_matches(name[:100], tables(), n=3)
    return list(dict.fromkeys([*close, *(each for each in tables() if last and last in each)]))[:6]
