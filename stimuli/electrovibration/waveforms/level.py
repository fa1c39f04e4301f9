"""The level of a voltage, in decibel re 1 V peak or in volt peak."""

from math import log10
from typing import Literal

from tactometry.arguments import require
from tactometry.arguments.magnitudes import DOMAINS
from tactometry.errors import InvalidParameter

LevelUnit = Literal["dB re 1 V", "V"]
HIGHEST_V = DOMAINS["_v"][1]


def peak_voltage_v(level: float, unit: LevelUnit = "dB re 1 V") -> float:
    """The peak voltage (V) of a level: ``10**(level/20)`` in decibel re 1 V peak, the level itself in volt.

    Raises
    ------
    InvalidParameter
        If the level is not finite or above `HIGHEST_V`, or a level in volt is negative.

    >>> peak_voltage_v(20.0)
    10.0
    >>> peak_voltage_v(0.0, "V")
    0.0
    """
    require.one_of("level_unit", unit, ("dB re 1 V", "V"))
    require.finite("stimulus", level=level)
    return _volt(level) if unit == "V" else _decibel(level)


def level_db_re_1v(voltage_v: float) -> float:
    """The level (dB re 1 V) of a peak voltage above 0.

    >>> round(level_db_re_1v(200.0), 2)
    46.02
    """
    require.positive("level_db_re_1v", voltage_v=voltage_v)
    return 20 * log10(voltage_v)


def _volt(level: float) -> float:
    require.not_negative("stimulus", level=level)
    if level > HIGHEST_V:
        raise InvalidParameter(f"stimulus.level: found {level} V, expected at most {HIGHEST_V:g} V")
    return float(level)


def _decibel(level: float) -> float:
    highest_db = 20 * log10(HIGHEST_V)
    if level > highest_db:
        raise InvalidParameter(f"stimulus.level: found {level} dB re 1 V, expected at most {highest_db:g} dB")
    return float(10 ** (level / 20))
