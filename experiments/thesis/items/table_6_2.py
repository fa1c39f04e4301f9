"""Table 6.2: applied force of each condition."""

from ..reproduction import Number, Reproduction
from .studies import contact_of, experiment

STUDY = "electrovibration-threshold"


def numbers() -> list[Number]:
    cells = experiment(STUDY).cells.values()
    forces_n = sorted({contact_of(cell).force_n for cell in cells})
    return [Number("applied force", f"condition of {force_n:g} N", force_n, "N", "assumed") for force_n in forces_n]


TABLE = Reproduction(
    title="Mean applied force of each condition",
    stated="That there were three forces, shown to the participant (pages 14 and 16); their values are not in "
    "our sources.",
    assumes="The forces that the built-in study asks for (unverified defaults); a simulated finger presses as "
    "it is told, so that no simulation can reproduce what people did.",
    numbers=numbers,
)
