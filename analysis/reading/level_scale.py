"""Conversion of levels to the axis of the fits: linear or logarithmic."""

from collections.abc import Callable, Mapping
from typing import Literal, get_args

import numpy as np
import pandas as pd

from tactometry.arguments.require import expect
from tactometry.errors import nearest
from tactometry.trials.tasks import TASKS, tasks_with_level

from ..arrays import Array
from .rows import bad_cell

LevelScale = Literal["linear", "log10", "db"]
LOGARITHMS: Mapping[str, tuple[str, Callable[[Array], Array]]] = {
    "log10": ("log10", np.log10),
    "db": ("dB re 1", lambda level: 20 * np.log10(level)),
}
"""Prefix of the unit on each scale, and the conversion of levels."""
PLACED = ("level", "level_delivered", "standard_level")
SCALED = tasks_with_level("curve", "scale")
SETTINGS = tuple(name for name, held in TASKS.items() if held.sets_level)
WIDE = 20.0
"""Ratio of highest to lowest level above which a linear axis is probably wrong (unverified default)."""


def is_logarithm(unit: str) -> bool:
    """Return True if levels of this unit are logarithms of an amplitude.

    >>> is_logarithm("dB re 1 V"), is_logarithm("log10 V"), is_logarithm("V")
    (True, True, False)
    """
    return unit.startswith(("dB", "log10"))


def on_scale(rows: pd.DataFrame, scale: str) -> pd.DataFrame:
    """Convert levels, settings and unit to ``linear``, ``log10`` or ``db``.

    Raises `InvalidParameter` if the scale is unknown, or the levels are already logarithms. Raises `InvalidFile`,
    naming the row, for a level of 0 or below, which has no logarithm.
    """
    known = get_args(LevelScale)
    expect(scale in known, "--level-scale", repr(scale), f"one of {', '.join(known)}{nearest(scale, known)}")
    if scale == "linear":
        return rows
    name, of = LOGARITHMS[scale]
    is_scaled = rows["task"].isin(SCALED)
    units = rows["level_unit"] if "level_unit" in rows.columns else pd.Series("", index=rows.index)
    for unit in units[is_scaled].unique():
        given = f"{scale} for levels in {unit!r}, which are already logarithms"
        expect(not is_logarithm(unit), "--level-scale", given, "linear")
    table = rows.assign(level_unit=units.where(~is_scaled, [f"{name} {unit}".rstrip() for unit in units]))
    for column in PLACED:
        if column in rows.columns:
            logarithms = of(_positive(rows, column, rows[column].where(is_scaled)))
            table[column] = rows[column].where(~is_scaled, logarithms)
    # The response of an adjustment is a level too; repr keeps every digit in the text.
    settings = is_scaled & rows["task"].isin(SETTINGS) & (rows["response"] != "")
    set_to = of(_positive(rows, "response", rows["response"].where(settings).astype(float)))
    table["response"] = rows["response"].where(~settings, [repr(float(level)) for level in set_to])
    return table


def _positive(rows: pd.DataFrame, name: str, levels: "pd.Series[float]") -> Array:
    bad = rows[(levels <= 0).to_numpy()]
    if len(bad):
        expected = (
            "a level above 0 on a logarithmic scale (a catch trial has an empty level and 1 in the column 'catch'), or "
            "--level-scale linear"
        )
        raise bad_cell(bad.iloc[0], name, str(bad.iloc[0][name]), expected)
    return np.array(levels, dtype=np.float64)


def wide_levels(rows: pd.DataFrame) -> list[str]:
    """Warn about levels on a linear scale that span a factor above `WIDE`."""
    is_linear = rows["task"].isin(tasks_with_level("curve"))
    if "level_unit" in rows.columns:
        logarithms = [unit for unit in rows["level_unit"].unique() if is_logarithm(unit)]
        is_linear &= ~rows["level_unit"].isin(logarithms)
    levels = rows.loc[is_linear, "level"]
    above = levels[levels > 0]
    if above.empty or (levels < 0).any() or above.max() <= WIDE * above.min():
        return []  # negative values exclude a logarithmic scale
    low, high = float(above.min()), float(above.max())
    return [
        f"levels from {low:.3g} to {high:.3g} span a factor of {high / low:.3g} on a linear axis. If this is "
        "a ratio scale, such as contrast or voltage, fit their logarithm (--level-scale log10 or db). "
        "Otherwise set --level-scale linear"
    ]
