"""Times to answer."""

from collections.abc import Iterator

from ...result import Analysis
from ..section import Kind, Lead, Section


def _sections(found: Analysis) -> Iterator[Section]:
    if "latency_s" in found.trials.rows.columns:
        median_s = found.trials.rows["latency_s"].median()
        yield Section("Times to answer", (Lead(f"Median of all answers: {median_s:.2f} s."),))


LATENCY = Kind(_sections)
