"""Stated effect: change in threshold, sensation or score between levels."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Final

import numpy as np

from tactometry.arguments.require import expect
from tactometry.errors import InvalidParameter, nearest
from tactometry.trials.cells import cell as cell_text

from ..study.study import Levels

OF_SENSATION: Final = "dB SL"
"""Unit of an effect on sensation: decibels of sensation level."""
OF_SCORE: Final = "points"
"""Unit of an effect on the score of a questionnaire's dimension."""
OF_PSE: Final = " PSE"
"""Suffix of the level's unit, for an effect on the point of subjective equality."""
OF_JND, OF_EXPONENT = "% JND", "% exponent"
"""Units of effects on the just noticeable difference and on the exponent of magnitude estimates."""
WHERE: Final = "--effect"
EXAMPLES: Final = (
    "an effect such as 'force_n: 2 dB', 'force_n: 3 dB SL', 'force_n: 20 % JND', 'pattern: P1 = 3 dB, P4 = 1 dB' or "
    "'feedback: 0.5 points'"
)
_QUANTITY = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(\S.*)?")


@dataclass(frozen=True)
class StatedEffect:
    """Stated change between the levels of a factor.

    - `unit`: ``"dB SL"`` for a change in sensation, ``"points"`` for a change in score, ``"% JND"`` or ``"% exponent"``
      for a relative change of these. The unit of the levels stands for a change in threshold, or with the suffix ``
      PSE`` for a change in the point of subjective equality.
    - `change`: Change from the first level to the last, in equal steps centred on zero.
    - `by_level`: Alternative to `change`: the change at each named level. Other levels are unchanged.
    """

    factor: str
    unit: str
    change: float | None = None
    by_level: tuple[tuple[str, float], ...] = ()

    @property
    def is_felt(self) -> bool:
        """True for an effect on sensation instead of levels."""
        return self.unit == OF_SENSATION

    @property
    def is_of_score(self) -> bool:
        """True for an effect on a questionnaire's score."""
        return self.unit == OF_SCORE

    @property
    def moves_levels(self) -> bool:
        """True for an effect on how answers depend on levels (`level_map`)."""
        return self.unit in (OF_JND, OF_EXPONENT) or self.unit.endswith(OF_PSE)

    def ratios(self, levels: Sequence[float | str]) -> dict[str, float]:
        """Return the ratio at each level, for an effect in per cent.

        >>> StatedEffect("force_n", "% JND", 21.0).ratios((0.5, 1.5, 3.0))["3"]
        1.1
        """
        changes = self.of_levels(levels)
        if self.change is None:
            return {name: 1 + change / 100 for name, change in changes.items()}
        return {name: (1 + self.change / 100) ** (change / self.change) for name, change in changes.items()}

    def of_levels(self, levels: Sequence[float | str]) -> dict[str, float]:
        """Return the change at each level of the factor, in the effect's unit.

        >>> StatedEffect("force_n", "dB", 2.0).of_levels((0.5, 1.5, 3.0))
        {'0.5': -1.0, '1.5': 0.0, '3': 1.0}
        >>> StatedEffect("pattern", "dB", by_level=(("P1", 3.0),)).of_levels(("P0", "P1"))
        {'P0': 0.0, 'P1': 3.0}
        """
        names = [cell_text(level) for level in levels]
        if self.change is None:
            return dict.fromkeys(names, 0.0) | dict(self.by_level)
        steps = np.linspace(-0.5, 0.5, len(names)) * self.change
        return dict(zip(names, steps.tolist(), strict=True))

    def words(self) -> str:
        """Format the effect as a user writes it.

        >>> StatedEffect("force_n", "dB", 2.0).words()
        'force_n: 2 dB'
        >>> StatedEffect("p", "dB SL", None, (("a", 1.0), ("b", -2.0))).words()
        'p: a = 1 dB SL, b = -2 dB SL'
        """
        named = ", ".join(f"{name} = {value:g} {self.unit}" for name, value in self.by_level)
        return f"{self.factor}: {named if self.change is None else f'{self.change:g} {self.unit}'}"


def parse_effect(text: str) -> StatedEffect:
    """Parse an effect given on the command line.

    Raises
    ------
    InvalidParameter
        If the text does not describe an effect.

    >>> parse_effect("force_n: 2 dB")
    StatedEffect(factor='force_n', unit='dB', change=2.0, by_level=())
    >>> parse_effect("pattern: P1 = 3 dB, P4 = 1 dB").by_level
    (('P1', 3.0), ('P4', 1.0))
    """
    factor, colon, rest = (part.strip() for part in text.partition(":"))
    expect(bool(factor and colon and rest), WHERE, repr(text), EXAMPLES)
    if "=" not in rest:
        change, unit = _quantity(rest, text)
        return StatedEffect(factor, unit, change)
    by_level: dict[str, float] = {}
    units = []
    for part in rest.split(","):
        level, equals, quantity = (word.strip() for word in part.partition("="))
        expect(bool(level and equals), WHERE, repr(text), EXAMPLES)
        expect(level not in by_level, WHERE, f"{level!r} twice", "each level once")
        by_level[level], unit = _quantity(quantity, text)
        units.append(unit)
    expect(
        len(set(units)) == 1, WHERE, f"{' and '.join(dict.fromkeys(units))} in one effect", "one unit for all levels"
    )
    return StatedEffect(factor, units[0], by_level=tuple(by_level.items()))


def _quantity(words: str, text: str) -> tuple[float, str]:
    match = _QUANTITY.fullmatch(words.strip())
    expect(match is not None, WHERE, repr(text), EXAMPLES)
    assert match is not None
    value, unit = float(match[1]), " ".join((match[2] or "").split())
    expect(bool(unit), WHERE, f"{words!r} without a unit", EXAMPLES)
    expect(isfinite(value), WHERE, repr(words), "a finite number")
    return value, unit


def check_effect(effect: StatedEffect, factors: Mapping[str, Levels]) -> None:
    """Reject an effect that a study with these factors cannot have.

    Raises `InvalidParameter` if the factor or level is unknown, the factor has one level, or nothing changes.
    """
    if effect.factor not in factors:
        known = ", ".join(factors) or "it has none"
        hint = nearest(effect.factor, factors)
        raise InvalidParameter(f"{WHERE}: found {effect.factor!r}, expected a factor of the study ({known}){hint}")
    levels = [cell_text(level) for level in factors[effect.factor]]
    one = f"the factor {effect.factor!r} with one level ({levels[0]})"
    expect(len(levels) > 1, WHERE, one, "a factor with two or more levels")
    for name, _ in effect.by_level:
        if name not in levels:
            expected = f"a level of {effect.factor} ({', '.join(levels)})"
            raise InvalidParameter(f"{WHERE}: found {name!r}, expected {expected}{nearest(name, levels)}")
    changes = effect.of_levels(factors[effect.factor]).values()
    stated = [value for _, value in effect.by_level] if effect.change is None else [effect.change]
    is_share = effect.unit not in (OF_JND, OF_EXPONENT) or min(stated) > -100
    expect(is_share, WHERE, repr(effect.words()), "a change above -100 %")
    expect(
        len(set(changes)) > 1, WHERE, f"{effect.words()!r}, which changes all levels equally", "an effect other than 0"
    )
