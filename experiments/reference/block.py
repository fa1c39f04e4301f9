"""A table of keys as words, and as lines that a file may hold."""

from collections.abc import Mapping

from .keys import Key, keys_of, summary
from .tables import KeyTable, toml_value


def heading(table: KeyTable) -> str:
    """Where it stands, and what it is.

    >>> from tactometry.experiments.reference.tables import tables
    >>> heading(tables()["touch.press"])
    '[touch] with kind = "press". A finger that rests.'
    """
    place = table.header or "the top of the file"
    kind = f' with kind = "{table.kind}"' if table.kind else ""
    return " ".join(filter(None, [f"{place}{kind}.", summary(table.reader), table.note]))


def holds(key: Key) -> str:
    """Type, unit and range of a key.

    >>> holds(Key("force_n", "a number", "N", "above 0", ""))
    'a number, N, above 0'
    """
    return ", ".join(filter(None, [key.holds, key.unit, key.within]))


def block(table: KeyTable) -> str:
    """Return the table as a file may hold it: required keys, and the others as comments.

    Tables at the top of a file follow both.

    >>> from tactometry.experiments.reference.tables import tables
    >>> print(block(tables()["touch.press"]), end="")
    [touch]
    kind = "press"
    force_n = 1.0
    hold_s = 0.3
    timeout_s = 10.0
    # tolerance = 0.15
    """
    return _block(table, comments=True)


def example(table: KeyTable) -> str:
    """Return the table with the keys that an example needs.

    >>> from tactometry.experiments.reference.tables import tables
    >>> print(example(tables()["limits"]), end="")
    [limits]
    voltage_peak_v = 200.0
    """
    return _block(table, comments=False)


def _block(table: KeyTable, *, comments: bool) -> str:
    keys = [key for key in keys_of(table) if key.example]
    stated = [key for key in keys if key.required or key.name in table.shown]
    others = [f"# {key.name} = {key.example}" for key in keys if key not in stated]
    if not stated and not comments:  # one optional key shows how the table is written
        others = [line.removeprefix("# ") for line in others[:1]]

    apart = [] if table.header else [key for key in stated if isinstance(table.shown.get(key.name), Mapping)]
    lines = [f"{key.name} = {key.example}" for key in stated if key not in apart]
    parts = [line for key in apart for line in ("", f"[{key.name}]", *_lines(table.shown[key.name]))]
    shown = others if comments or not stated else []
    return "".join(f"{line}\n" for line in [*filter(None, [table.header]), *lines, *shown, *parts])


def _lines(values: Mapping[str, object]) -> list[str]:
    return [f"{name} = {toml_value(value)}" for name, value in values.items()]
