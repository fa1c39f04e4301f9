"""A table of a file that users write: its name at the prompt, the class that reads it, and values that it takes."""

import json
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from datetime import date
from typing import Any

from tactometry.config.strict import build, build_kind
from tactometry.loading import resolve

Values = Mapping[str, Any]


@dataclass(frozen=True)
class KeyTable:
    """A table of a file. Nothing of its class is imported before it is asked for.

    Parameters
    ----------
    name : str
        What it is called at the prompt, as ``touch.slide``.
    header : str
        The line that begins it in a file, as ``[touch]``; empty for what stands at the top.
    reads : str
        Target string of the class that reads it.
    kind : str
        The value of its key ``kind``; empty where it has none.
    usual : bool
        Whether ``kind`` may be left out.
    note : str
        What its class does not say of it.
    example : mapping or str
        A table that is valid, with its required keys at least; or the target string of one.
    samples : mapping
        Values of keys that are in no example and have no default.
    instead : mapping of str to mapping
        By key, another example, where the key does not go with the first.
    also : tuple of str
        The names of tables whose keys may stand in it too.
    given : callable
        Fields that come from elsewhere.
    made : callable
        What is made of it, which may refuse more.
    in_levels : tuple of str
        Keys in the unit of the level.
    kinds : mapping of str to mapping of str to str
        Keys that hold a table of one of these kinds, each with the target string of its class.
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
    also: tuple[str, ...] = ()
    given: Callable[[], Values] = dict
    made: Callable[[Any], object] = field(default=lambda built: built)
    in_levels: tuple[str, ...] = ()
    kinds: Mapping[str, Mapping[str, str]] = field(default_factory=dict)

    @property
    def reader(self) -> type:
        """The class that reads it."""
        kind: type = resolve(self.reads)
        return kind

    @property
    def shown(self) -> Values:
        """The example."""
        found: Values = resolve(self.example) if isinstance(self.example, str) else self.example
        return found

    def read(self, values: Values, path: str) -> object:
        """What a file that holds these values makes of them.

        Raises
        ------
        InvalidParameter
            If the class refuses them; `path` opens the sentence.
        """
        parts = {name: build_kind(values.get(name, {}), f"{path}.{name}", kinds) for name, kinds in self.kinds.items()}
        own = {name: value for name, value in values.items() if name not in parts}
        return self.made(build(self.reader, own, path, **self.given(), **parts))


def toml_value(value: object) -> str:
    """A value on one line.

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
