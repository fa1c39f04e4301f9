"""Quantities in TOML: a number in SI units, or a string with a unit."""

import re
from collections.abc import Mapping
from math import nan
from typing import Any

from ..arguments.require import WORD
from ..errors import Gathered, InvalidParameter, nearest

_PREFIXES = {"p": 1e-12, "n": 1e-9, "u": 1e-6, "µ": 1e-6, "m": 1e-3, "": 1.0, "k": 1e3, "M": 1e6, "G": 1e9}
_UNITS = ("Hz", "N", "s", "V", "A", "F", "J", "W", "C", "m", "Pa", "kg", "ohm", "m2")
_SI = {unit.lower(): unit for unit in _UNITS}
"""Units by the suffix of a name."""
_COMPOUND = {
    "m_per_s": ("m/s", {"m/s": 1.0, "mm/s": 1e-3, "cm/s": 1e-2}),
    "n_s_per_m": ("N s/m", {"N s/m": 1.0}),
    "n_per_m": ("N/m", {"N/m": 1.0, "N/mm": 1e3, "kN/m": 1e3}),
    "kg_per_m3": ("kg/m3", {"kg/m3": 1.0, "g/cm3": 1e3}),
    "ohm_m": ("ohm m", {"ohm m": 1.0, "kohm m": 1e3}),
    "m2": ("m2", {"m2": 1.0, "cm2": 1e-4, "mm2": 1e-6}),
    "s": ("s", {"s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "min": 60.0, "h": 3600.0}),
    "m": ("m", {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "nm": 1e-9}),
}
_RATIOS = {"_rad": "rad", "_db": "dB"}
"""Units of ratios, which a file states as plain numbers."""
GREEK_MU = ("\N{GREEK SMALL LETTER MU}", "\N{MICRO SIGN}")
"""Greek mu, and the micro sign that replaces it."""
_NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(\S.*?)?\s*")


def unit_suffix(name: str) -> str | None:
    """Return the unit suffix of a name, or None.

    >>> unit_suffix("speed_m_per_s"), unit_suffix("force_n"), unit_suffix("repeats"), unit_suffix("moment_n_per_v")
    ('m_per_s', 'n', None, None)
    """
    ending = [suffix for suffix in (*_COMPOUND, *_SI) if name.endswith(f"_{suffix}")]
    fitting = [suffix for suffix in ending if not name.removesuffix(f"_{suffix}").endswith("_per")]
    return max(fitting, key=len, default=None)


def unit_in(name: str) -> str:
    """Return the unit at the end of a name, or an empty text.

    >>> unit_in("force_n"), unit_in("moment_n_per_v"), unit_in("slope_hz_per_m_per_s"), unit_in("repeats")
    ('N', 'N/V', 'Hz/(m/s)', '')
    """
    suffix = unit_suffix(name)
    if suffix is not None:
        return units(suffix)[0]
    if name.endswith(tuple(_RATIOS)):
        return _RATIOS[name[name.rindex("_") :]]
    for per in re.finditer("_per_", name):
        above, below = unit_in(name[: per.start()]), unit_in(f"_{name[per.end() :]}")
        if above and below:
            return f"{above}/({below})" if "/" in below else f"{above}/{below}"
    return ""


def units(suffix: str) -> tuple[str, Mapping[str, float]]:
    """Return the SI unit of a suffix, and the factors of its other units."""
    if suffix in _COMPOUND:
        return _COMPOUND[suffix]
    symbol = _SI[suffix]
    return symbol, {prefix + symbol: factor for prefix, factor in _PREFIXES.items()}


def si_unit(unit: str, where: str) -> tuple[str, float]:
    """Return the SI unit with the dimension of a unit, and the factor to it.

    >>> si_unit("ms", "units"), si_unit("mV", "units"), si_unit("cm/s", "units")
    (('s', 0.001), ('V', 0.001), ('m/s', 0.01))
    """
    tables = [units(suffix) for suffix in (*_SI, *_COMPOUND)]
    known = {name: (symbol, factor) for symbol, table in tables for name, factor in table.items()}
    unit = unit.replace(*GREEK_MU)
    if unit not in known:
        raise InvalidParameter(f"{where}: found {unit!r}, expected a unit such as ms, mV or N{nearest(unit, known)}")
    return known[unit]


def si(text: str, suffix: str, where: str) -> float:
    """Convert a text such as "50 mm/s" to SI units.

    Raises `InvalidParameter` if the text is not a number with a unit of the right dimension.

    >>> si("50 mm/s", "m_per_s", "speed_m_per_s")
    0.05
    """
    symbol, known = units(suffix)
    match = _NUMBER.fullmatch(text)
    unit = (match[2] or "").replace(*GREEK_MU) if match else ""
    if match is None or unit not in known:
        raise InvalidParameter(
            f"{where}: found {text!r}, expected a number in {symbol} or a string such as '1 {symbol}' "
            f"(one of {', '.join(known)}){nearest(unit, known)}"
        )
    return float(match[1]) * known[unit]


def as_si(value: object, path: str, found: Gathered | None = None) -> Any:
    """Convert strings of keys with a unit suffix to SI units.

    "unlimited" is not changed. With `found`, errors are collected there, and the affected values are NaN.
    """
    if isinstance(value, dict):
        return {key: as_si(item, f"{path}.{key}" if path else str(key), found) for key, item in value.items()}
    suffix = unit_suffix(path.rpartition(".")[2].partition("[")[0])
    if isinstance(value, list):
        return [as_si(item, f"{path}[{n}]", found) for n, item in enumerate(value)]
    if isinstance(value, str) and suffix is not None and not (value == WORD and not path.endswith("]")):
        return si(value, suffix, path) if found is None else _si_or_nan(value, suffix, path, found)
    return value


def _si_or_nan(text: str, suffix: str, path: str, found: Gathered) -> float:
    try:
        return si(text, suffix, path)
    except InvalidParameter as error:
        found.add(error)
        return nan
