"""Effects on PSEs, JNDs and exponents, simulated by rescaling the levels.

A condition is simulated at the `played` levels, and its trials are analysed at the `stated` levels. The stated levels
are the played ones, moved by `shift` and stretched by `factor` about `pivot`. This works for every model of sensation.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
import pandas as pd

from tactometry.arguments.require import expect
from tactometry.config.toml import merge
from tactometry.observers.people import Stated
from tactometry.trials.cells import cell as cell_text

from ..study.experiment import Experiment
from ..study.study import Study
from .effect import OF_EXPONENT, OF_JND, WHERE, StatedEffect

TASKS: Final = ("comparison", "magnitude")
LEVELS: Final = ("levels", "start", "low", "high", "threshold_low", "threshold_high", "easy_level")
DISTANCES: Final = (
    *("steps", "steps_up", "steps_down", "step", "start_sd", "sd_stop"),
    *("width_low", "width_high", "sd_low", "sd_high", "decade"),
)
"""Keys of `[procedure]` in the unit of the levels."""
DECADE: Final = 20.0
"""Default of QUEST's `decade`."""
DECIMALS: Final = 9
"""Decimals to which levels are rounded, so that equal stated levels compare equal."""


@dataclass(frozen=True)
class LevelMap:
    """Map from played levels to stated levels.

    >>> float(LevelMap(40.0, shift=1.0, factor=2.0).stated(39.0)), LevelMap(40.0, shift=1.0, factor=2.0).played(39.0)
    (39.0, 39.0)
    """

    pivot: float
    shift: float = 0.0
    factor: float = 1.0

    def stated(self, level: Any) -> Any:
        """Return the stated level for a played level, or for an array."""
        return np.round(self.pivot + self.shift + self.factor * (level - self.pivot), DECIMALS)

    def played(self, level: float) -> float:
        """Return the level to play for a stated level."""
        return self.pivot + (level - self.shift - self.pivot) / self.factor


def level_maps(
    experiment: Experiment, effect: StatedEffect, slopes: Mapping[str, float], *, has_effect: bool
) -> dict[str, LevelMap]:
    """Return the map of each level of the effect's factor.

    `slopes` are growth rates of sensation. Shifts are at least 0 and factors at least 1, so that no level above the
    stated ones is played.
    """
    levels = experiment.study.factors[effect.factor]
    changes = effect.of_levels(levels)
    ratios, shifts = dict.fromkeys(changes, 1.0), dict.fromkeys(changes, 0.0)
    if has_effect and effect.unit in (OF_JND, OF_EXPONENT):
        ratios = effect.ratios(levels)
    elif has_effect:
        shifts = {level: change - min(changes.values()) for level, change in changes.items()}
    factors = {n: slopes[n] / ratio if effect.unit == OF_EXPONENT else slopes[n] * ratio for n, ratio in ratios.items()}
    least, pivot = min(factors.values()), pivot_of(experiment)
    return {level: LevelMap(pivot, shifts[level], factor / least) for level, factor in factors.items()}


def pivot_of(experiment: Experiment) -> float:
    """Return the standard of a comparison, else the middle of the levels."""
    bounds = [end for cell in experiment.cells.values() for end in cell.procedure.rule.bounds]
    return float(getattr(experiment.task, "standard_level", (min(bounds) + max(bounds)) / 2))


def slopes_of(experiment: Experiment, factor: str, growths: Mapping[str, float]) -> dict[str, float]:
    """Return the growth of sensation at each level of a factor.

    The growth is that of `growths`, or the inverse of stated widths.
    """
    people = experiment.people.middle
    if not isinstance(people, Stated):
        return dict(growths)
    result: dict[str, list[float]] = {level: [] for level in growths}
    for cell in experiment.cells.values():
        factors = cell.condition.factors
        result[cell_text(factors[factor])].append(people.stated(factors).stretch)
    return {level: float(np.mean(stretches)) for level, stretches in result.items()}


def check_maps(study: Study, factor: str) -> None:
    """Reject a study whose levels cannot be mapped for the effect's factor.

    Raises `InvalidParameter` if the factor is interleaved, another factor changes the procedure, or the levels are
    spaced by ratios.
    """
    apart = "a factor that is not interleaved, as each of its levels needs a separate procedure"
    expect(factor not in study.plan.interleave, WHERE, f"the factor {factor!r}, which is interleaved", apart)
    others = (name for name in study.variants if name != factor)
    for name in others:
        changes = any("procedure" in tables for tables in study.variants[name].values())
        expect(not changes, WHERE, f"{name!r}, which changes the procedure", "the same procedure at all its levels")
    is_linear = study.procedure.get("spacing", "linear") == "linear" and study.procedure.get("shape") != "weibull"
    expect(is_linear, WHERE, "a procedure that spaces levels by ratios", "levels in decibels, or another linear unit")


def with_levels(study: Study, factor: str, maps: Mapping[str, LevelMap]) -> Study:
    """Return the study with mapped levels at each level of a factor."""
    of_factor = study.variants.get(factor, {})
    changed = {}
    for level, level_map in maps.items():
        tables = of_factor.get(level, {})
        own = tables.get("procedure", {})
        changed[level] = {**tables, "procedure": {**own, **_played(merge(study.procedure, own), level_map)}}
    return replace(study, variants={**study.variants, factor: changed})


def _played(table: Mapping[str, Any], level_map: LevelMap) -> dict[str, Any]:
    stated = {"decade": DECADE, **table} if table.get("kind") == "quest" else table
    result: dict[str, Any] = {}
    for key, value in stated.items():
        if key in LEVELS or key in DISTANCES:
            numbers = value if isinstance(value, list | tuple) else [value]
            mapped = [level_map.played(n) if key in LEVELS else n / level_map.factor for n in numbers]
            result[key] = mapped if isinstance(value, list | tuple) else mapped[0]
    return result


def with_stated_levels(rows: pd.DataFrame, factor: str, maps: Mapping[str, LevelMap]) -> pd.DataFrame:
    """Replace played levels by stated ones in trials, and clear `correct`."""
    result = rows.assign(correct=None)
    texts = rows[factor].map(lambda level: level if isinstance(level, str) else cell_text(level))
    for level, level_map in maps.items():
        at = texts == level
        for column in ("level", "level_delivered"):
            result.loc[at, column] = level_map.stated(rows.loc[at, column].to_numpy(dtype=float))
    return result
