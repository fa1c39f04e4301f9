"""A ladder as a table, as CSV, and in words: the cheapest rung for 10 %, 1 %, 0.1 % and 0.01 %."""

import platform
from collections.abc import Sequence
from pathlib import Path

from tactometry.files.rows import write_records

from .measure import GOALS, Climb, Point, cheapest
from .problem import OURS

ROW = "{:<29}{:>9}{:>10}{:>10}{:>10}{:>8}{:>11}{:>11}"


def table(climb: Climb) -> str:
    """The points of a ladder, 98 columns wide, and the cheapest rungs; *cold* is a first call, *warm* the median."""
    head = ROW.format("setting", "error", "price", "cold (s)", "warm (s)", "+- (s)", "memory (B)", "answer (B)")
    problem = climb.problem
    lines = [f"{problem.name}: {problem.title}", f"against {problem.reference.by}", f"price: {problem.price}", head]
    lines += [
        ROW.format(
            label(point),
            "unstable" if point.unstable else f"{point.error:.1e}",
            f"{point.price:.3g}",
            f"{point.first_s:.3g}",
            f"{point.median_s:.3g}",
            f"{point.spread_s:.1g}",
            point.peak_bytes,
            point.answer_bytes,
        )
        for point in climb.points
    ]
    return "\n".join([*lines, f"reference good to {climb.floor:.0e}", *answers(climb)])


def label(point: Point) -> str:
    """The setting, and whose it is if there are several contenders."""
    return point.setting if point.contender == OURS else f"{point.contender}, {point.setting}"


def answers(climb: Climb) -> list[str]:
    """What each error costs at least."""
    return [f"{goal:.2%}: {_price_text(cheapest(climb, goal))}" for goal in GOALS]


def _price_text(point: Point | None) -> str:
    return "no rung reaches it" if point is None else f"{label(point)}, price {point.price:.3g}"


def write_csv(climbs: Sequence[Climb], path: Path) -> None:
    """All points, one a row.

    Raises
    ------
    DeviceFailed
        If the file cannot be written.
    """
    write_records(Point, (point for climb in climbs for point in climb.points), path)


def machine() -> str:
    """Versions, processor and BLAS, in a line; ladders are measured on one thread."""
    import numpy as np
    from threadpoolctl import threadpool_info

    pools = sorted({f"{pool['internal_api']} {pool.get('architecture', '')}".strip() for pool in threadpool_info()})
    versions = f"Python {platform.python_version()}, numpy {np.__version__}"
    return f"{versions}, {platform.machine()}, {', '.join(pools)}; 1 thread"
