"""Table 3.1: spatial resolution of the focus on thick glass."""

from ..reproduction import Number, Reproduction
from .thick_plates import ASSUMES, foci


def numbers() -> list[Number]:
    return [
        Number(quantity, focus.condition, 1e3 * width_m, "mm", "derived")
        for focus in foci()
        for quantity, width_m in (("simulated width", focus.width_m), ("diffuse-field law", focus.law_m))
    ]


TABLE = Reproduction(
    title="Spatial resolution of the focus",
    stated="That there is such a table, in mm, for 2 and 3 mm glass and discs of 12 and 35 mm (pages 11, 12 "
    "and 16); its values are not in our sources.",
    assumes=ASSUMES,
    numbers=numbers,
)
