"""Table 3.2: amplitude of the focus on thick glass."""

from ..reproduction import Number, Reproduction
from .thick_plates import ASSUMES, foci


def numbers() -> list[Number]:
    first = foci()[0].amplitude_m
    return [
        number
        for focus in foci()
        for number in (
            Number("amplitude", focus.condition, 1e6 * focus.amplitude_m, "um", "calibrated"),
            Number("over the first row", focus.condition, focus.amplitude_m / first, "", "derived"),
        )
    ]


TABLE = Reproduction(
    title="Displacement amplitude of the focus",
    stated="That there is such a table, in um (page 16); its values are not in our sources.",
    assumes=f"{ASSUMES} The moment per volt of a patch is the constant that was set so that the prototype of "
    "chapter 4 gives 10 um, and is kept for other glass.",
    numbers=numbers,
)
