"""Tables, findings and figures of the thesis: a file for those of one computation or chapter, a line for each here."""

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
    "finding-5": f"{_HERE}.four_signals:FINDING_5",
    "table-2.1": f"{_HERE}.table_2_1:TABLE",
    "table-3.1": f"{_HERE}.thick_plates:TABLE_3_1",
    "table-3.2": f"{_HERE}.thick_plates:TABLE_3_2",
    "table-3.3": f"{_HERE}.thick_plates:TABLE_3_3",
    "table-4.1": f"{_HERE}.table_4_1:TABLE",
    "table-4.3": f"{_HERE}.four_signals:TABLE_4_3",
    "table-4.4": f"{_HERE}.four_signals:TABLE_4_4",
    "table-4.5": f"{_HERE}.four_signals:TABLE_4_5",
    "table-6.1": f"{_HERE}.table_6_1:TABLE",
    "table-6.2": f"{_HERE}.applied_force:TABLE_6_2",
    "table-6.3": f"{_HERE}.electrovibration_thresholds:TABLE_6_3",
    "figure-3.4": f"{_HERE}.figures_3_4:FIGURE_3_4",
    "figure-3.8": f"{_HERE}.figures_3_4:FIGURE_3_8",
    "figure-3.9": f"{_HERE}.figures_3_4:FIGURE_3_9",
    "figure-3.11": f"{_HERE}.figures_3_4:FIGURE_3_11",
    "figure-3.13": f"{_HERE}.figures_3_4:FIGURE_3_13",
    "figure-3.14": f"{_HERE}.figures_3_4:FIGURE_3_14",
    "figure-3.15": f"{_HERE}.figures_3_4:FIGURE_3_15",
    "figure-3.16": f"{_HERE}.figures_3_4:FIGURE_3_16",
    "figure-3.18": f"{_HERE}.figures_3_4:FIGURE_3_18",
    "figure-3.19": f"{_HERE}.figures_3_4:FIGURE_3_19",
    "figure-3.20": f"{_HERE}.figures_3_4:FIGURE_3_20",
    "figure-3.21": f"{_HERE}.figures_3_4:FIGURE_3_21",
    "figure-4.9": f"{_HERE}.figures_3_4:FIGURE_4_9",
    "figure-4.11": f"{_HERE}.figures_3_4:FIGURE_4_11",
    "figure-4.13": f"{_HERE}.figures_3_4:FIGURE_4_13",
    "figure-4.15": f"{_HERE}.figures_3_4:FIGURE_4_15",
    "figure-4.25": f"{_HERE}.figures_3_4:FIGURE_4_25",
    "figure-4.28": f"{_HERE}.figures_3_4:FIGURE_4_28",
    "figure-4.29": f"{_HERE}.figures_3_4:FIGURE_4_29",
    "figure-4.30": f"{_HERE}.figures_3_4:FIGURE_4_30",
    "figure-4.31": f"{_HERE}.figures_3_4:FIGURE_4_31",
    "figure-4.33": f"{_HERE}.figures_3_4:FIGURE_4_33",
    "figure-4.34": f"{_HERE}.figures_3_4:FIGURE_4_34",
    "figure-5.4": f"{_HERE}.figures_5_6:FIGURE_5_4",
    "figure-5.7": f"{_HERE}.figures_5_6:FIGURE_5_7",
    "figure-5.8": f"{_HERE}.figures_5_6:FIGURE_5_8",
    "figure-5.9": f"{_HERE}.attrakdiff_scores:FIGURE_5_9",
    "figure-5.10": f"{_HERE}.attrakdiff_scores:FIGURE_5_10",
    "figure-5.11": f"{_HERE}.attrakdiff_scores:FIGURE_5_11",
    "figure-5.12": f"{_HERE}.attrakdiff_scores:FIGURE_5_12",
    "figure-5.13": f"{_HERE}.attrakdiff_scores:FIGURE_5_13",
    "figure-6.3": f"{_HERE}.figures_5_6:FIGURE_6_3",
    "figure-6.5": f"{_HERE}.figures_5_6:FIGURE_6_5",
    "figure-6.6": f"{_HERE}.figures_5_6:FIGURE_6_6",
    "figure-6.8": f"{_HERE}.figures_5_6:FIGURE_6_8",
    "figure-6.12": f"{_HERE}.applied_force:FIGURE_6_12",
    "figure-6.13": f"{_HERE}.applied_force:FIGURE_6_13",
    "figure-6.15": f"{_HERE}.figures_5_6:FIGURE_6_15",
    "figure-A.1": f"{_HERE}.attrakdiff_scores:FIGURE_A_1",
    "figure-A.2": f"{_HERE}.attrakdiff_scores:FIGURE_A_2",
    "figure-A.3": f"{_HERE}.attrakdiff_scores:FIGURE_A_3",
    "figure-A.4": f"{_HERE}.attrakdiff_scores:FIGURE_A_4",
    "figure-A.5": f"{_HERE}.attrakdiff_scores:FIGURE_A_5",
    "figure-A.6": f"{_HERE}.attrakdiff_scores:FIGURE_A_6",
    "figure-A.7": f"{_HERE}.attrakdiff_scores:FIGURE_A_7",
    "figure-B.1": f"{_HERE}.figures_5_6:FIGURE_B_1",
}
"""The name of each item, and where it is."""


def reproduction_of(name: str) -> "Reproduction":
    """An item by its name."""
    item: Reproduction = resolve(REPRODUCTIONS[name])
    return replace(item, name=name)
