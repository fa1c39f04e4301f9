"""Table 4.1: the material of the patches."""

from tactometry.stimuli.time_reversal.screen.transducer import PATCH_CAPACITANCE_F, PZ27_RELATIVE_PERMITTIVITY

from ..reproduction import Number, Reproduction

NAVY_TYPE_II = {
    "relative permittivity K": (1900.0, ""),
    "d33": (400.0, "pC/N"),
    "d31": (-175.0, "pC/N"),
    "Young's modulus Y11": (63.0, "GPa"),
    "mechanical quality": (80.0, ""),
    "density": (7600.0, "kg/m3"),
    "Curie temperature": (360.0, "deg C"),
}


def numbers() -> list[Number]:
    stand_in = [Number(name, "stand-in", *constant, "assumed") for name, constant in NAVY_TYPE_II.items()]
    used = Number("relative permittivity used here", "PZ27", PZ27_RELATIVE_PERMITTIVITY, "", "assumed")
    return [*stand_in, used, Number("capacitance of a patch", "PZ27", 1e9 * PATCH_CAPACITANCE_F, "nF", "derived")]


TABLE = Reproduction(
    title="Material of the patches (PZ27)",
    stated="That the patches are of PZ27 (page 16); its data sheet is not in our sources.",
    assumes="The constants of a ceramic of the same class (Navy type II, APC 850) stand in; the permittivity "
    "that is used (1800) and the thickness of a patch (0.3 mm) are unverified defaults.",
    numbers=numbers,
)
