"""Run a power analysis, from the design to a recommendation."""

from collections.abc import Callable
from dataclasses import dataclass

from ..workers import Spread, here
from .design import PowerDesign
from .files import Folder
from .sampling import Batch, sample
from .summary import PowerEstimate, Summary, cautions, recommendation


@dataclass(frozen=True)
class Power:
    """Results of a power analysis."""

    design: PowerDesign
    points: tuple[PowerEstimate, ...]
    recommendation: str
    cautions: tuple[str, ...]


def power(
    design: PowerDesign,
    spread: Spread = here,
    folder: Folder | None = None,
    tell: Callable[[Batch], None] = lambda batch: None,
) -> Power:
    """Simulate studies until their powers are precise enough.

    Batches stored in `folder` are reused.
    """
    found = Summary(design)
    stored = () if folder is None else (folder.kept, folder.keep, folder.simulated)
    batches = sample(design, spread, *stored)
    for batch, rows in batches:
        found.add(rows)
        tell(batch)
    points = found.points()
    if folder is not None:
        folder.write_table(points)
    return Power(design, points, recommendation(design, points), tuple(cautions(design, points)))
