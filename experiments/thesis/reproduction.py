"""Reproduced table, figure or finding, with the origin of its numbers."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal, get_args

import numpy as np

from tactometry.arguments.require import one_of
from tactometry.stimuli.arrays import FloatArray

from .spread import SourcedRange

Origin = Literal["derived", "calibrated", "assumed"]
QUANTILES: Final = (0.05, 0.5, 0.95)
"""Ends and median of a band."""
ORIGINS: Final[tuple[Origin, ...]] = get_args(Origin)


@dataclass(frozen=True)
class Number:
    """Reproduced number, with the statement of the sources.

    - `quantity`, `condition`: Together they are unique in a table.
    - `origin`: Result of the physics, of a constant that was set to it, or of the input.
    - `stated`: The statement of the thesis, or empty.
    - `holds`: Whether the number agrees with the statement, or None without one.
    - `is_variant`: The input was changed to see its effect: shown, but not counted.
    - `low`, `high`: The 5 % and 95 % quantiles of the value over the spread of its sources.
    - `part`: Title of a table for itself on the page, or empty for the table of the item.
    """

    quantity: str
    condition: str
    value: float
    unit: str
    origin: Origin
    stated: str = ""
    holds: bool | None = None
    is_variant: bool = False
    low: float | None = None
    high: float | None = None
    part: str = ""

    def __post_init__(self) -> None:
        one_of("Number.origin", self.origin, ORIGINS)

    @property
    def verdict(self) -> str:
        """Verdict on the statement: only derived numbers count as reproduced."""
        if self.holds is None:
            return "not compared"
        if not self.holds:
            return "does not agree"
        return "**reproduced**" if self.origin == "derived" else f"agrees, as {self.origin}"


@dataclass(frozen=True)
class DrawnBand:
    """Median of the draws, and the quantiles that are its ends."""

    low: float
    value: float
    high: float

    def holds(self, stated: float) -> bool:
        """Return True if a statement is within the band."""
        return self.low <= stated <= self.high

    def number(self, quantity: str, condition: str, unit: str, **statement: Any) -> Number:
        """Return a derived number with this band."""
        return Number(quantity, condition, self.value, unit, "derived", low=self.low, high=self.high, **statement)


def band_of(values: Sequence[float] | FloatArray) -> DrawnBand:
    """Return the band of values."""
    return DrawnBand(*np.quantile(values, QUANTILES).tolist())


@dataclass(frozen=True)
class Reproduction:
    """Item of `tactometry reproduce`.

    - `stated`: Statement of our sources, with the page.
    - `assumes`: Choices that no source gives.
    - `numbers`: Yields the numbers of a table or finding.
    - `drawing`: Returns a matplotlib figure, whose curves are the numbers of a figure.
    - `origin`: Origin of the curves of the drawing.
    - `outcome`: Result of a finding, and its reason.
    - `ranges`: What the bands of the numbers are drawn from.
    - `name`: Key in `REPRODUCTIONS`.
    """

    title: str
    stated: str
    assumes: str
    numbers: Callable[[], Iterable[Number]] | None = None
    drawing: Callable[[], Any] | None = None
    origin: Origin = "derived"
    outcome: str = ""
    ranges: tuple[SourcedRange, ...] = ()
    name: str = ""


@dataclass(frozen=True)
class Reproduced:
    """Reproduction with its computed numbers."""

    item: Reproduction
    numbers: tuple[Number, ...]

    @property
    def compared(self) -> tuple[Number, ...]:
        """Numbers with a statement, without variants."""
        return tuple(number for number in self.numbers if number.stated and not number.is_variant)


def reproduce(item: Reproduction) -> Reproduced:
    """Compute the numbers of an item."""
    return Reproduced(item, tuple(item.numbers()) if item.numbers else ())
