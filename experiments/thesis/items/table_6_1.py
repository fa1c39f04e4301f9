"""Table 6.1: skin and screen."""

from tactometry.stimuli.electrovibration.skin.skin import Skin

from ..reproduction import Number, Origin, Reproduction

AREA_M2 = 1e-4


def numbers() -> list[Number]:
    skin = Skin()
    assumed = {
        "insulator, thickness": (1e6 * skin.insulator_thickness_m, "um"),
        "insulator, relative permittivity": (skin.insulator_permittivity, ""),
        "stratum corneum, thickness": (1e6 * skin.corneum_thickness_m, "um"),
        "stratum corneum, relative permittivity": (skin.corneum_permittivity, ""),
        "stratum corneum, resistivity": (skin.corneum_resistivity_ohm_m, "ohm m"),
        "contact area": (1e4 * AREA_M2, "cm2"),
    }
    derived = {
        "capacitance of the insulator": (1e9 * skin.insulator_capacitance_f(AREA_M2), "nF"),
        "capacitance of the corneum": (1e9 * skin.corneum_capacitance_f(AREA_M2), "nF"),
        "share of a fast voltage across the corneum": (skin.k, ""),
    }
    calibrated = {
        "resistance of the corneum": (1e-3 * skin.corneum_resistance_ohm(AREA_M2), "kohm"),
        "time constant": (1e6 * skin.tau_s, "us"),
        "corner of the high-pass": (skin.cutoff_hz, "Hz"),
    }
    constants: dict[Origin, dict[str, tuple[float, str]]] = {
        "assumed": assumed,
        "derived": derived,
        "calibrated": calibrated,
    }
    return [Number(name, "set P0", *values, origin) for origin, of in constants.items() for name, values in of.items()]


TABLE = Reproduction(
    title="Skin and screen parameters",
    stated="That there is such a table, for a leaky stratum corneum on an insulator (pages 13 and 16); its "
    "values are not in our sources.",
    assumes="All of the parameter set P0 (unverified defaults). The resistivity was chosen so that the corner is "
    "near the 500 Hz that Meyer, Peshkin and Colgate (2013) predict, and do not find.",
    numbers=numbers,
)
