"""A table, figure or finding of the thesis made anew: its numbers, each with how it came about."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Literal, get_args

from tactometry.arguments.require import one_of
from tactometry.files.rows import write_records

Origin = Literal["derived", "calibrated", "assumed"]
ORIGINS: Final[tuple[Origin, ...]] = get_args(Origin)


@dataclass(frozen=True)
class Number:
    """One number, and what our sources of the thesis state of it.

    Parameters
    ----------
    quantity, condition : str
        Of what, and under which condition; together they are one number of the table.
    value, unit
    origin : {"derived", "calibrated", "assumed"}
        Whether it comes out of the physics, a constant was set to it, or the input says so.
    stated : str
        What the thesis states, in words; empty where our sources hold nothing.
    holds : bool or None
        Whether the number agrees with it; None where nothing is stated that could be compared.
    is_variant : bool
        Whether the input was changed on purpose, to see what the number hangs on: shown, but not counted.
    """

    quantity: str
    condition: str
    value: float
    unit: str
    origin: Origin
    stated: str = ""
    holds: bool | None = None
    is_variant: bool = False

    def __post_init__(self) -> None:
        one_of("Number.origin", self.origin, ORIGINS)

    @property
    def is_reproduced(self) -> bool:
        """Only what is derived and agrees counts."""
        return self.origin == "derived" and self.holds is True


@dataclass(frozen=True)
class Reproduction:
    """What a name of `tactometry reproduce` makes.

    Parameters
    ----------
    title : str
    stated : str
        What our sources say of it, with the page of the source.
    assumes : str
        What no source gives and was chosen here.
    numbers : callable, optional
        Gives the numbers of a table or a finding.
    drawing : callable, optional
        Gives a matplotlib figure, whose curves are the numbers of a figure.
    origin : {"derived", "calibrated", "assumed"}
        How the curves of the drawing came about.
    outcome : str
        For a finding: what comes out, and why, or why not.
    name : str
        That of the table `REPRODUCTIONS`.
    """

    title: str
    stated: str
    assumes: str
    numbers: Callable[[], Iterable[Number]] | None = None
    drawing: Callable[[], Any] | None = None
    origin: Origin = "derived"
    outcome: str = ""
    name: str = ""


@dataclass(frozen=True)
class Reproduced:
    """A reproduction and the numbers that it gave."""

    item: Reproduction
    numbers: tuple[Number, ...]

    @property
    def compared(self) -> tuple[Number, ...]:
        """The numbers of which the thesis states something, of inputs as they are."""
        return tuple(number for number in self.numbers if number.stated and not number.is_variant)


def reproduce(item: Reproduction) -> Reproduced:
    """Compute the numbers of an item."""
    return Reproduced(item, tuple(item.numbers()) if item.numbers else ())


def write_numbers(made: Reproduced, path: Path) -> None:
    """The numbers as a CSV, a row each, `holds` empty where nothing is stated.

    Raises
    ------
    DeviceFailed
        If the file cannot be written.
    """
    write_records(Number, made.numbers, path)
