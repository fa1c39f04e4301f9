"""Reference tables of all user files, by name and documentation page."""

import json
import re
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, field
from datetime import date
from difflib import get_close_matches
from functools import cache
from typing import Any, Final

from tactometry.config.strict import build, build_kind
from tactometry.config.toml import merge, shipped_table
from tactometry.errors import InvalidParameter
from tactometry.loading import resolve

Values = Mapping[str, Any]


@dataclass(frozen=True)
class KeyTable:
    """Reference table of a user file. Its class is imported only when needed.

    - `name`: Name for `tactometry keys`, such as ``touch.slide``.
    - `header`: Header in the file, such as ``[touch]``. Empty for the top of the file.
    - `reads`: Import target of the class that reads the table.
    - `kind`: Value of the table's key ``kind``, if any.
    - `usual`: True if ``kind`` is optional.
    - `note`: Addition to the description of the class.
    - `example`: Valid table with the required keys, or the import target of such a table.
    - `samples`: Example values of keys that have no default and are not in `example`.
    - `instead`: Separate examples for keys that contradict `example`.
    - `also`: Names of tables whose keys are also allowed.
    - `given`: Returns fields that the file does not state.
    - `made`: Builds the final object, which may check more.
    - `in_levels`: Keys whose unit is that of the level.
    - `kinds`: Keys whose value is a table of one of these kinds, with the import target of each class.
    """

    name: str
    header: str
    reads: str
    kind: str = ""
    usual: bool = False
    note: str = ""
    example: Values | str = field(default_factory=dict)
    samples: Values = field(default_factory=dict)
    instead: Mapping[str, Values] = field(default_factory=dict)
    also: Collection[str] = ()
    given: Callable[[], Values] = dict
    made: Callable[[Any], object] = field(default=lambda built: built)
    in_levels: Collection[str] = ()
    kinds: Mapping[str, Mapping[str, str]] = field(default_factory=dict)

    @property
    def reader(self) -> type:
        """The class that reads the table."""
        kind: type = resolve(self.reads)
        return kind

    @property
    def shown(self) -> Values:
        """Values of the example."""
        result: Values = resolve(self.example) if isinstance(self.example, str) else self.example
        return result

    def read(self, values: Values, path: str) -> object:
        """Build the object of a table. An error begins with `path`."""
        parts = {name: build_kind(values.get(name, {}), f"{path}.{name}", kinds) for name, kinds in self.kinds.items()}
        own = {name: value for name, value in values.items() if name not in parts}
        return self.made(build(self.reader, own, path, **self.given(), **parts))


_LISTED: Final[Mapping[str, dict[str, Values]]] = shipped_table(__package__, "tables")
PAGES: Final = tuple(_LISTED)
"""Documentation pages."""


def tables_of_page(page: str) -> Iterator[KeyTable]:
    """Yield the tables of a page, in their order."""
    for name in _LISTED[page]:
        stated = _said(page, name)
        if "kinds_of" not in stated:
            yield _table(name, stated)
            continue
        changes, header = stated.pop("kind", {}), stated["header"]
        of_header = "{kind}" in header
        for kind, known in resolve(stated.pop("kinds_of")).items():
            fields = {"reads": known} if isinstance(known, str) else known
            own = {"header": header.format(kind=kind), "kind": "" if of_header else kind}
            yield _table(name.format(kind=kind), merge(stated | fields | own, changes.get(kind, {})))


def _said(page: str, name: str) -> dict[str, Any]:
    """Return what `tables.toml` says of a table, with the fields it copies."""
    stated = dict(_LISTED[page][name])
    return merge(_said(page, stated.pop("as")), stated) if "as" in stated else stated


def _table(name: str, said: Values) -> KeyTable:
    given = said.get("given", {})
    return KeyTable(**{"header": "", **said, "name": name, "given": lambda: _built(given)})


def _built(value: Any) -> Any:
    """Replace each table with a key `built` by the object of its target."""
    if not isinstance(value, Mapping):
        return value
    inner = {name: _built(each) for name, each in value.items() if name != "built"}
    return resolve(value["built"])(**inner) if "built" in value else inner


@cache
def tables() -> Mapping[str, KeyTable]:
    """Return every table by its name.

    >>> tables()["touch.slide"].header
    '[touch]'
    """
    return {table.name: table for page in PAGES for table in tables_of_page(page)}


def find(name: str) -> tuple[KeyTable, ...]:
    """Return a table and related ones, or all tables below a name.

    Raises `InvalidParameter` for an unknown name.

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
    expected = f"one of {', '.join(near)}" if near else "a name listed by tactometry keys"
    raise InvalidParameter(f"NAME: found {name!r}, expected {expected}")


def inner_name(table: KeyTable, key: str, classes: Collection[type] = ()) -> str:
    """Return the name of the table or group for a key, or an empty text.

    >>> inner_name(tables()["study"], "touch"), inner_name(tables()["bench"], "force")
    ('touch', 'bench.force')
    """
    of_study = (f"study.{key}", key) if table.name == "study" else ()
    by_place = [name for name in (f"{table.name}.{key}", *of_study) if _is_known(name)]
    by_class = [name for name in map(name_of, classes) if name]
    return next(iter((*by_place, *by_class)), "")


def name_of(kind: type) -> str:
    """Return the first table that a class reads, or an empty text.

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
    """Return the table of a class, else of a key's path, or empty.

    >>> name_at(None, "s.toml, task.over"), name_at(None, "s.toml, mood")
    ('task', '')
    """
    by_class = name_of(kind) if kind is not None else ""
    above = path.rpartition(", ")[2].rpartition(".")[0]
    return by_class or (above if _is_known(above) else "")


def _is_known(name: str) -> bool:
    return any(each == name or each.startswith(f"{name}.") for each in tables())


def _nearest(name: str) -> list[str]:
    """Return similar names, then names that contain the last part of the name."""
    last = name.rpartition(".")[2]
    close = get_close_matches(name[:100], tables(), n=3)
    return list(dict.fromkeys([*close, *(each for each in tables() if last and last in each)]))[:6]


def toml_value(value: object) -> str:
    """Format a value as TOML on one line.

    >>> toml_value(True), toml_value(0.05), toml_value("a"), toml_value([1, 2])
    ('true', '0.05', '"a"', '[1, 2]')
    >>> toml_value({"kind": "grating", "period_m": 1e-3})
    '{ kind = "grating", period_m = 0.001 }'
    """
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, date):
        return value.isoformat()
    if isinstance(value, float):
        digits = f"{value:.6g}"
        return digits if set(digits) & set(".einf") else f"{digits}.0"
    if isinstance(value, Mapping):
        parts = ", ".join(f"{_key(key)} = {toml_value(item)}" for key, item in value.items())
        return f"{{ {parts} }}" if parts else "{}"
    return f"[{', '.join(map(toml_value, value))}]" if isinstance(value, list | tuple) else str(value)


def _key(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else json.dumps(name, ensure_ascii=False)
