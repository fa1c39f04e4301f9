"""The scenes that are felt where a study states none, one file for each model of `[sensation]`."""

from typing import Any, Final

from tactometry.loading import resolve

from ...composition.effect import Effect
from ..effects import EFFECTS

ACCURACY: Final = 0.02
"""Half of it is left for what aliases, 40 dB under the rest, half for the spectrum."""


def effect(kind: str, *values: Any) -> Effect:
    """An effect by its kind; none that is not made is imported."""
    made: Effect = resolve(EFFECTS[kind])(*values)
    return made
