"""The column map of a table of another program."""

from collections.abc import Iterator
from typing import Final

from .key_table import KeyTable, Values

_SAMPLES: Final[Values] = {
    "columns": {"participant": "subject", "latency_s": "rt"},
    "constants": {"task": "yes_no"},
    "values": {"response": {"y": 1, "n": 0}},
    "keep": {"event": ["response"]},
    "from_name": {"participant": "sub"},
    "units": {"latency_s": "ms"},
    "level_scale": "log10",
    "missing": ["NA"],
}


def map_tables() -> Iterator[KeyTable]:
    """The file itself: all of its tables are names that a lab chooses."""
    yield KeyTable("map", "", "tactometry.analysis.reading.column_map:ColumnMap", samples=_SAMPLES)
