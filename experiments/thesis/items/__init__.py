"""Tables, figures and findings of the thesis: one file each, one line here."""

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from tactometry.loading import resolve

if TYPE_CHECKING:
    from ..reproduction import Reproduction

_HERE = "tactometry.experiments.thesis.items"
REPRODUCTIONS: Mapping[str, str] = {
    "finding-1": f"{_HERE}.finding_1:FINDING",
    "finding-2": f"{_HERE}.finding_2:FINDING",
    "finding-3": f"{_HERE}.finding_3:FINDING",
    "finding-4": f"{_HERE}.finding_4:FINDING",
    "finding-5": f"{_HERE}.finding_5:FINDING",
    "table-2.1": f"{_HERE}.table_2_1:TABLE",
    "table-3.1": f"{_HERE}.table_3_1:TABLE",
    "table-3.2": f"{_HERE}.table_3_2:TABLE",
    "table-3.3": f"{_HERE}.table_3_3:TABLE",
    "table-4.1": f"{_HERE}.table_4_1:TABLE",
    "table-4.3": f"{_HERE}.table_4_3:TABLE",
    "table-4.4": f"{_HERE}.table_4_4:TABLE",
    "table-4.5": f"{_HERE}.table_4_5:TABLE",
    "table-6.1": f"{_HERE}.table_6_1:TABLE",
    "table-6.2": f"{_HERE}.table_6_2:TABLE",
    "table-6.3": f"{_HERE}.table_6_3:TABLE",
}
"""The name of each item, and where it is."""


def reproduction_of(name: str) -> "Reproduction":
    """An item by its name."""
    item: Reproduction = resolve(REPRODUCTIONS[name])
    return replace(item, name=name)
