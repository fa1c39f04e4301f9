"""Values and tables as a file in TOML writes them."""

import json
import re
from collections.abc import Mapping
from datetime import date


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
