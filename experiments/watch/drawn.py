"""Plots that take more than a glance at what is seen."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .plots import Plot


@dataclass(frozen=True)
class Drawn:
    """The curve of the present condition, and the samples of the last touch."""

    curve: "Plot | None" = None
    touch: "tuple[Plot, ...]" = ()
