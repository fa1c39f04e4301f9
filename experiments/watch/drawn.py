"""Plots that take more than a glance at what is seen."""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .plots import Plot


@dataclass(frozen=True)
class TouchDrawn:
    """The samples of the last touch, or why they can't be read."""

    plots: "tuple[Plot, ...]" = ()
    problem: str = ""


@dataclass(frozen=True)
class Drawn:
    """The curve of the present condition, and the last touch."""

    curve: "Plot | None" = None
    touch: TouchDrawn = field(default_factory=TouchDrawn)
