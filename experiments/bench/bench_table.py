"""Read and edit one table of a bench file, keeping its comments."""

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tactometry.arguments.require import Unlimited, expect
from tactometry.config.strict import as_table
from tactometry.config.toml import LARGEST_FILE, errors_in, read_table
from tactometry.files.durable import read_file, write_atomically

from .bench_file import parse_bench


def table_toml(name: str, values: Mapping[str, object]) -> str:
    """Format a table as TOML, without keys whose value is None.

    >>> print(table_toml("screen", {"height_m": 0.298, "language": None}), end="")
    [screen]
    height_m = 0.298
    """
    lines = (f"{key} = {_item(value).as_string()}\n" for key, value in values.items() if value is not None)
    return "".join([f"[{name}]\n", *lines])


def stated_in(path: Path, name: str) -> dict[str, Any]:
    """Return a table of a bench file (such as ``output.gain``), or {}."""
    return _within(read_table(path, "a bench file"), name)


def with_values(text: str, name: str, values: Mapping[str, object]) -> str:
    """Return a bench file's text with keys set, or removed for None.

    >>> print(with_values("# ours\\n[screen]\\nheight_m = 0.3  # by ruler\\n", "screen", {"height_m": 0.298}), end="")
    # ours
    [screen]
    height_m = 0.298  # by ruler
    """
    import tomlkit

    line_end = "\r\n" if "\r\n" in text else "\n"
    document = tomlkit.parse(text.replace("\r\n", "\n"))
    table: Any = document
    for part in name.split("."):
        if part not in table:
            table[part] = tomlkit.table()
        table = table[part]
    for key, value in values.items():
        if value is not None:
            table[key] = _item(value)
        elif key in table:
            del table[key]
    return document.as_string().replace("\n", line_end)


def write_values(path: Path, name: str, values: Mapping[str, object]) -> None:
    """Set keys of a table in a bench file, as `with_values` does.

    The file is replaced as a whole or not at all.

    Raises `InvalidFile` if the file cannot be read, or would be invalid with these keys. Raises `DeviceFailed` if the
    file cannot be written.
    """
    file = path.resolve()  # write to the target of a link, not over the link
    before = read_file(file, "a bench file", LARGEST_FILE).decode("utf-8-sig")
    with errors_in(path):
        after = _edited(before, name, values)
        parse_bench(tomllib.loads(after))
    write_atomically(file, after.encode())


def _edited(before: str, name: str, values: Mapping[str, object]) -> str:
    """Edit a bench file's text, and check the result."""
    from tomlkit.exceptions import TOMLKitError

    kept = {
        key: value for key, value in {**_within(tomllib.loads(before), name), **values}.items() if value is not None
    }
    expected = {key: list(value) if isinstance(value, tuple) else value for key, value in kept.items()}
    try:
        after = with_values(before, name, values)
        is_done = _within(tomllib.loads(after), name) == expected
    except (TOMLKitError, tomllib.TOMLDecodeError):
        is_done = False
    expect(is_done, name, "a layout of this table that cannot be edited", f"[{name}]; copy the printed keys by hand")
    return after


def _within(tables: Mapping[str, Any], name: str) -> dict[str, Any]:
    for part in name.split("."):
        tables = as_table(tables.get(part, {}), name)
    return dict(tables)


def _item(value: object) -> Any:
    import tomlkit

    plain: Any = list(value) if isinstance(value, tuple) else value
    return tomlkit.item(str(value) if isinstance(value, Unlimited) else plain)
