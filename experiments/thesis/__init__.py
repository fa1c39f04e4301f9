"""Reproduced tables, figures and findings of the thesis.

Each has a name here, and an entry in `ITEMS` of its module.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from tactometry.loading import resolve

if TYPE_CHECKING:
    from .reproduction import Reproduction

_NAMES = {
    "findings": "finding-1 finding-2 finding-4",
    "finding_3": "finding-3",
    "four_signals": "finding-5 table-4.3 table-4.4 table-4.5",
    "tables": "table-2.1 table-3.1 table-3.2 table-3.3 table-4.1 table-6.1 table-6.2 table-6.3",
    "figures.plates": "figure-3.4 figure-3.8 figure-3.9 figure-3.11 figure-3.13 figure-3.14 figure-3.15 figure-3.16 "
    "figure-3.18 figure-3.19 figure-3.20 figure-3.21 figure-4.9 figure-4.11 figure-4.13 figure-4.15 figure-4.25 "
    "figure-4.28 figure-4.29 figure-4.30 figure-4.31 figure-4.33 figure-4.34 figure-5.4 figure-5.8",
    "figures.people": "figure-5.7 figure-5.9 figure-5.10 figure-5.11 figure-5.12 figure-5.13 "
    "figure-6.3 figure-6.5 figure-6.6 figure-6.8 figure-6.12 figure-6.13 figure-6.15 figure-A.1 figure-A.2 figure-A.3 "
    "figure-A.4 figure-A.5 figure-A.6 figure-A.7 figure-B.1",
}
_KINDS = ("finding", "table", "figure")


def _place(name: str) -> tuple[int, str, int]:
    kind, _, number = name.partition("-")
    chapter, _, n = number.rpartition(".")
    return _KINDS.index(kind), chapter, int(n)


_MODULES = {name: module for module, names in _NAMES.items() for name in names.split()}
REPRODUCTIONS: Mapping[str, str] = {name: _MODULES[name] for name in sorted(_MODULES, key=_place)}
"""The module of each item, in the order of the page."""


def reproduction_of(name: str) -> "Reproduction":
    """Return an item by its name."""
    item: Reproduction = resolve(f"{__name__}.{REPRODUCTIONS[name]}:ITEMS")[name]
    return replace(item, name=name)
