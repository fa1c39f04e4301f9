"""What other programs reached on the same ladders, as `benchmarks/ladder_peers.py` recorded it.

A ladder's own finest rung was measured in the same run: prices are drawn as if that rung had taken as long then as
it takes now, so that a peer recorded on one machine can stand beside rungs measured on another.
"""

import csv
from dataclasses import replace
from pathlib import Path

import msgspec

from .measure import Climb, Point

RECORD = Path(__file__).with_name("peers.csv")


def peers_of(climb: Climb, record: Path = RECORD) -> tuple[Point, ...]:
    """The recorded points of a ladder's peers, as dear as they would be on this machine."""
    with record.open(newline="", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["ladder"] == climb.problem.name]
    now_s = climb.points[-1].median_s
    return tuple(_rescale(msgspec.convert(row, Point, strict=False), now_s / float(row["yardstick_s"])) for row in rows)


def recorded_on(record: Path = RECORD) -> str:
    """Date and machine of the record."""
    with record.open(newline="", encoding="utf-8") as file:
        return next((row["recorded"] for row in csv.DictReader(file)), "never")


def _rescale(point: Point, factor: float) -> Point:
    times = {name: factor * getattr(point, name) for name in ("price", "first_s", "median_s", "spread_s")}
    return replace(point, **times)
