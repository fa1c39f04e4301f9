"""Times to answer."""

from collections.abc import Iterator

from ...result import Analysis
from ..section import Lead, ResultKind, Section


def _sections(analysis: Analysis) -> Iterator[Section]:
    if "latency_s" in analysis.trials.rows.columns:
        median_s = analysis.trials.rows["latency_s"].median()
        yield Section("Times to answer", (Lead(f"Median of all answers: {median_s:.2f} s."),))


KIND = ResultKind(_sections)
