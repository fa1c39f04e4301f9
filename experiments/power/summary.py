"""Power and false-positive rates with intervals, and a recommendation."""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from ..harness import share_interval
from ..study.study_file import parse
from .design import PowerDesign
from .effect import OF_EXPONENT, OF_JND
from .replicate import Row
from .scores import factors_of

IN_LEVELS: Final = ("threshold", "setting")
"""Dependent variables in the unit of the levels, for which the true effect is known."""


@dataclass(frozen=True)
class PowerEstimate:
    """Estimates for a number of participants and trials (0: as in the study).

    `power` and `false_positives` are shares of `n_studies` and `n_without_effect` simulated studies, each with its 95 %
    interval (Clopper and Pearson 1934). The other values describe the studies with the effect. `found` is the mean
    effect in the data. `bias` is its difference from the stated effect (None if the dependent variable is not in the
    unit of the effect). `threshold_bias` is the mean difference of known thresholds from the true ones, and `width` the
    mean width of intervals. `untested_share` is the share of studies without a test result, and `unknown_share` that of
    cells without a value. `n_left_out` is the mean number of participants without any value, and `minutes` the mean
    duration for one participant.
    """

    n_trials: int
    n_participants: int
    n_studies: int
    power: float
    power_low: float
    power_high: float
    n_without_effect: int
    false_positives: float
    false_positives_low: float
    false_positives_high: float
    found: float | None
    bias: float | None
    threshold_bias: float | None
    width: float | None
    untested_share: float
    unknown_share: float
    n_left_out: float
    minutes: float
    simulated: bool = True

    @property
    def cost_minutes(self) -> float:
        """Duration for all participants (min)."""
        return self.n_participants * self.minutes


class Summary:
    """Estimates of a power analysis from rows as they arrive."""

    def __init__(self, design: PowerDesign) -> None:
        self._design = design
        self._rows: dict[tuple[int, int, bool], list[Row]] = defaultdict(list)

    def add(self, rows: Iterable[Row]) -> None:
        for row in rows:
            self._rows[row.n_trials, row.n_participants, row.has_effect].append(row)

    def points(self) -> tuple[PowerEstimate, ...]:
        """Estimates by trials and participants, where both cases have rows."""
        keys = sorted({key[:2] for key in self._rows})
        return tuple(self._point(*key) for key in keys if all((*key, yes) in self._rows for yes in (True, False)))

    def _point(self, n_trials: int, n_participants: int) -> PowerEstimate:
        rows, without = (self._rows[n_trials, n_participants, has_effect] for has_effect in (True, False))
        result, stated = _mean(row.found for row in rows), stated_effect(self._design)
        return PowerEstimate(
            n_trials,
            n_participants,
            len(rows),
            *_significant(rows),
            len(without),
            *_significant(without),
            found=result,
            bias=None if result is None or stated is None else result - stated,
            threshold_bias=_mean(row.error for row in rows),
            width=_mean(row.width for row in rows),
            untested_share=sum(row.p is None for row in rows) / len(rows),
            unknown_share=sum(row.n_unknown for row in rows) / sum(row.n_cells for row in rows),
            n_left_out=sum(row.n_left_out for row in rows) / len(rows),
            minutes=_mean(row.minutes for row in rows) or 0.0,
        )


def _mean(values: Iterable[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return sum(known) / len(known) if known else None


def _significant(rows: Sequence[Row]) -> tuple[float, float, float]:
    """Return the share of significant studies, with its 95 % interval."""
    n_significant = sum(row.significant for row in rows)
    return n_significant / len(rows), *share_interval(n_significant, len(rows))


def stated_effect(design: PowerDesign) -> float | None:
    """Return the largest stated difference between level means.

    Returns None unless the dependent variable has the unit of the effect.
    """
    effect = design.effect
    in_levels = design.dependent == "pse" if effect.moves_levels else design.dependent in IN_LEVELS
    is_percentage = effect.unit in (OF_JND, OF_EXPONENT)
    if not effect.is_of_score and (effect.is_felt or is_percentage or not in_levels):
        return None
    levels = factors_of(parse(design.study_toml, design.where))[effect.factor]
    return float(np.ptp(list(effect.of_levels(levels).values())))


def recommendation(design: PowerDesign, points: Sequence[PowerEstimate]) -> str:
    """Recommend the design with the target power and the least total time."""
    reaching = [point for point in points if point.power >= design.target]
    if not reaching:
        best = max(points, key=lambda point: point.power)
        excluded = best.power_high < design.target
        open_yet = "" if excluded else f", whose interval does not exclude {design.target:g}: simulate more studies, or"
        return (
            f"No number that was tried reaches a power of {design.target:g} for {design.effect.words()}: "
            f"{_words(best)} have {_power(best)}{open_yet or ';'} try more participants or trials, or a larger effect."
        )
    best = min(reaching, key=lambda point: (point.cost_minutes, point.n_participants))
    sure = "" if best.power_low >= design.target else f"; the interval does not exclude less than {design.target:g}"
    return (
        f"Take {_words(best)}: the power for {design.effect.words()} is {_power(best)}, at {best.minutes:.0f} minutes "
        f"a participant{sure}."
    )


def cautions(design: PowerDesign, points: Sequence[PowerEstimate]) -> list[str]:
    """Return warnings that limit the interpretation of the powers."""
    loose = [point for point in points if point.false_positives_low > design.alpha]
    warnings = []
    if loose:
        worst = max(loose, key=lambda point: point.false_positives)
        rate = _share(worst.false_positives, worst.false_positives_low, worst.false_positives_high)
        warnings.append(
            f"without an effect the test is significant too often ({rate} with {_words(worst)}): do not rely on its "
            "power there"
        )
    untested = max(points, key=lambda point: point.untested_share)
    if untested.untested_share > 0:
        warnings.append(
            f"no test had a result in {untested.untested_share:.0%} of the studies with {_words(untested)}; each "
            "counts as not significant"
        )
    lost = max(points, key=lambda point: point.unknown_share)
    if lost.unknown_share > MUCH:
        warnings.append(
            f"{lost.unknown_share:.0%} of the cells have no value with {_words(lost)}: the levels do not reach the "
            "thresholds, or the trials are too few"
        )
    return warnings


MUCH: Final = 0.1
"""Share of cells without a value above which a warning is printed."""


def _words(point: PowerEstimate) -> str:
    trials = f" with {point.n_trials} trials a track" if point.n_trials else ""
    return f"{point.n_participants} participants{trials}"


def _power(point: PowerEstimate) -> str:
    return _share(point.power, point.power_low, point.power_high)


def _share(share: float, low: float, high: float) -> str:
    return f"{share:.2f} [{low:.2f}, {high:.2f}]"


HEAD: Final = (
    *("trials", "people", "power", "95 %", "no effect", "95 %", "found", "bias", "threshold bias", "width", "no value"),
    *("left out", "min", "studies"),
)


def table(points: Sequence[PowerEstimate]) -> str:
    """Format the estimates as a table for a terminal."""
    rows = [HEAD, *map(cells_of, points)]
    widths = [max(len(row[column]) for row in rows) for column in range(len(HEAD))]
    return "\n".join("  ".join(text.rjust(width) for text, width in zip(row, widths, strict=True)) for row in rows)


def cells_of(point: PowerEstimate) -> tuple[str, ...]:
    """Return the table cells of an estimate, in the order of `HEAD`."""
    return (
        str(point.n_trials or "study"),
        str(point.n_participants),
        f"{point.power:.3f}",
        f"{point.power_low:.3f} - {point.power_high:.3f}",
        f"{point.false_positives:.3f}",
        f"{point.false_positives_low:.3f} - {point.false_positives_high:.3f}",
        *(
            "" if value is None else f"{value:.2f}"
            for value in (point.found, point.bias, point.threshold_bias, point.width)
        ),
        f"{point.unknown_share:.1%}",
        f"{point.n_left_out:.1f}",
        f"{point.minutes:.0f}",
        f"{point.n_studies} + {point.n_without_effect}",
    )
