"""The table of parameters with value, range and source."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from importlib import import_module
from importlib.resources import files
from typing import Any, Final, Literal

from tactometry.config.strict import build
from tactometry.config.toml import table_of
from tactometry.loading import resolve

Value = float | str
Status = Literal["exact", "published", "abstract", "choice", "from_memory", "no_source"]
UNVERIFIED: Final = ("from_memory", "no_source")
"""Statuses of defaults whose number was not read in a source."""


@dataclass(frozen=True)
class Parameter:
    """A default with its range and source.

    `key` is the group and the name in the code. `read` states how the source was read.
    """

    key: str
    value: Value
    low: Value
    high: Value
    unit: str
    status: Status
    source: str
    read: str

    @property
    def is_unverified(self) -> bool:
        """True if the number was not read in a source."""
        return self.status in UNVERIFIED

    @property
    def status_text(self) -> str:
        """The status in words."""
        return self.status.replace("_", " ")

    @property
    def path(self) -> list[str]:
        """Names from the class or module of the group to the value."""
        return self.key.split(".")[1:]


@dataclass(frozen=True)
class Group:
    """Parameters of one class or module.

    - `code`: Class or object with the defaults (``module:Class``), or a module with constants.
    - `kinds`: Classes whose objects have the values in a study, by default that of `code`.
    - `effects`: Effects of a scene that use the constants of a module.
    - `varied`: False if the effect on the sensation level is not computed.
    """

    name: str
    code: str
    kinds: tuple[str, ...]
    effects: tuple[str, ...]
    varied: bool
    parameters: tuple[Parameter, ...]

    @property
    def target(self) -> Any:
        """The class, object or module with the defaults."""
        return resolve(self.code) if ":" in self.code else import_module(self.code)

    @property
    def classes(self) -> tuple[type, ...]:
        """Classes whose objects have the values in a study, none for a module."""
        if self.kinds:
            return tuple(resolve(kind) for kind in self.kinds)
        return (self.target,) if isinstance(self.target, type) else ()

    def default(self, parameter: Parameter) -> Value:
        """Return the default in the code."""
        return value_at(self.target, parameter.path)


def groups() -> tuple[Group, ...]:
    """Read the table of sources.

    >>> [group.name for group in groups()][:3]
    ['skin', 'skin_leakage', 'contact_area']
    """
    file = files("tactometry.stimuli") / "sources.toml"
    table = table_of(file.read_bytes(), "sources.toml", "a table of sources")
    return tuple(_group(name, dict(rows)) for name, rows in table.items())


def parameters() -> tuple[Parameter, ...]:
    """Return the parameters of all groups."""
    return tuple(parameter for group in groups() for parameter in group.parameters)


def status_counts(listed: Iterable[Parameter]) -> str:
    """Return the number of parameters of each status as a text."""
    counts = Counter(one.status_text for one in listed)
    return ", ".join(f"{n} {status}" for status, n in sorted(counts.items()))


def value_at(holder: Any, path: list[str]) -> Value:
    """Return the value at a path of attributes and indices.

    >>> value_at(slice((3, 4.5)), ["stop", "1"])
    4.5
    """
    for name in path:
        holder = holder[int(name)] if name.isdigit() else getattr(holder, name)
    found: Value = holder
    return found


def _group(name: str, rows: dict[str, Any]) -> Group:
    code, varied = rows.pop("code"), rows.pop("varied", True)
    kinds, effects = tuple(rows.pop("kinds", ())), tuple(rows.pop("effects", ()))
    each = (build(Parameter, row, f"{name}.{of}", key=f"{name}.{of}") for of, row in rows.items())
    return Group(name, code, kinds, effects, varied, tuple(each))
