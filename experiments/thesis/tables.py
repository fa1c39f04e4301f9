"""Tables 2.1, 3.1 to 3.3, 4.1 and 6.1 to 6.3 of the thesis."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache, partial

import numpy as np

from tactometry.stimuli.electrovibration.skin.skin import Skin
from tactometry.stimuli.perception.channels import NP_I, NP_III, P, channel_thresholds_db
from tactometry.stimuli.time_reversal import Band, focus_amplitude
from tactometry.stimuli.time_reversal.design.closed_forms import ALPHA, resolution_m
from tactometry.stimuli.time_reversal.focusing.merit import resolution_per_focus_m
from tactometry.stimuli.time_reversal.screen.transducer import PATCH_CAPACITANCE_F, PZ27_RELATIVE_PERMITTIVITY

from .reproduction import Number, Origin
from .setups import RIG_BAND, rig, thick_plate
from .studies import FORCE, STUDY, cells_of, contact_of, threshold_db, touches

STATED_HZ = {
    "Merkel (NP III)": (NP_III, 0.0, 3.0),
    "Meissner (NP I)": (NP_I, 20.0, 50.0),
    "Pacini (P)": (P, 50.0, 500.0),
}
BEST_HZ, HALF_AN_OCTAVE = 250.0, 0.5


def receptors() -> Iterator[Number]:
    f_hz = np.geomspace(0.4, 1000.0, 2001)
    thresholds_db = channel_thresholds_db(f_hz)
    lowest, felt = thresholds_db.argmin(axis=0), np.isfinite(thresholds_db.min(axis=0))
    for name, (row, from_hz, to_hz) in STATED_HZ.items():
        band_hz = f_hz[(lowest == row) & felt]
        yield _compared("mediates from", name, band_hz[0], from_hz)
        yield _compared("mediates to", name, band_hz[-1], to_hz)
        for end, at_hz in (("from", from_hz), ("to", to_hz)):
            if at_hz > 0:
                over_db = float(channel_thresholds_db(at_hz)[row, 0] - thresholds_db[row].min())
                yield Number(f"threshold where stated {end}, over its lowest", name, over_db, "dB", "assumed")
    yield _compared("most sensitive at", "Pacini (P)", f_hz[thresholds_db[P].argmin()], BEST_HZ)


def _compared(quantity: str, channel: str, found_hz: float, stated_hz: float) -> Number:
    """Return a frequency; within half an octave it agrees, below 1 Hz with 0."""
    is_near = found_hz < 1 if stated_hz == 0 else abs(np.log2(found_hz / stated_hz)) <= HALF_AN_OCTAVE
    return Number(quantity, channel, float(found_hz), "Hz", "assumed", f"{stated_hz:g} Hz", bool(is_near))


FOCI_M = ((0.121, 0.093), (0.15, 0.105), (0.17, 0.12), (0.1, 0.11), (0.14, 0.08))
THICKNESSES_M, DIAMETERS_M, F_MAX_HZ = (2e-3, 3e-3), (12e-3, 35e-3), (10e3, 15e3, 20e3, 25e3)


@dataclass(frozen=True)
class Focus:
    """Width (m), amplitude (m) and diffuse width (m), means over foci."""

    thickness_m: float
    diameter_m: float
    f_max_hz: float
    width_m: float
    amplitude_m: float
    law_m: float

    @property
    def discs(self) -> str:
        return f"{self.thickness_m * 1e3:g}/{self.diameter_m * 1e3:g} mm"

    @property
    def condition(self) -> str:
        return f"{self.discs}, {self.f_max_hz / 1e3:g} kHz"


@lru_cache(maxsize=1)
def foci() -> tuple[Focus, ...]:
    """Compute every condition of the thick plates."""
    result = []
    for thickness_m in THICKNESSES_M:
        for diameter_m in DIAMETERS_M:
            screen = rig(diameter_m, thickness_m)
            for f_max_hz in F_MAX_HZ:
                emission = replace(RIG_BAND, band=Band(0.0, f_max_hz))
                width_m = float(resolution_per_focus_m(screen, FOCI_M, emission).mean())
                responses = [emission.responses(screen, [at_m]) for at_m in FOCI_M]
                amplitude_m = float(np.mean([focus_amplitude(emission.drive(one), one) for one in responses]))
                law_m = resolution_m(screen.plate, emission.band)
                result.append(Focus(thickness_m, diameter_m, f_max_hz, width_m, amplitude_m, law_m))
    return tuple(result)


def widths() -> Iterator[Number]:
    for focus in foci():
        yield Number("simulated width", focus.condition, 1e3 * focus.width_m, "mm", "derived")
        yield Number("diffuse-field law", focus.condition, 1e3 * focus.law_m, "mm", "derived")


def amplitudes() -> Iterator[Number]:
    first_m = foci()[0].amplitude_m
    for focus in foci():
        yield Number("amplitude", focus.condition, 1e6 * focus.amplitude_m, "um", "calibrated")
        yield Number("over the first row", focus.condition, focus.amplitude_m / first_m, "", "derived")


def alphas() -> Iterator[Number]:
    """Fit R_s = a / sqrt(f_mean); a is over the root of the wave constant."""
    for condition in dict.fromkeys(focus.discs for focus in foci()):
        rows = [focus for focus in foci() if focus.discs == condition]
        per_root = np.array([(focus.f_max_hz / 2) ** -0.5 for focus in rows])
        slope = float(per_root @ [focus.width_m for focus in rows] / (per_root @ per_root))
        root = thick_plate(rows[0].thickness_m).wave_constant_m2_per_s ** 0.5
        yield Number("alpha", condition, slope / root, "", "derived")
        yield Number("diffuse-field law, sqrt(pi / 2)", condition, ALPHA, "", "derived")
        yield Number("R_s sqrt(f_mean)", condition, slope, "m Hz^0.5", "derived")


NAVY_TYPE_II = {
    "relative permittivity K": (1900.0, ""),
    "d33": (400.0, "pC/N"),
    "d31": (-175.0, "pC/N"),
    "Young's modulus Y11": (63.0, "GPa"),
    "mechanical quality": (80.0, ""),
    "density": (7600.0, "kg/m3"),
    "Curie temperature": (360.0, "deg C"),
}


def patches() -> Iterator[Number]:
    for name, constant in NAVY_TYPE_II.items():
        yield Number(name, "stand-in", *constant, "assumed")
    yield Number("relative permittivity used here", "PZ27", PZ27_RELATIVE_PERMITTIVITY, "", "assumed")
    yield Number("capacitance of a patch", "PZ27", 1e9 * PATCH_CAPACITANCE_F, "nF", "derived")


AREA_M2 = 1e-4


def skin_and_screen() -> Iterator[Number]:
    skin = Skin()
    constants: dict[Origin, dict[str, tuple[float, str]]] = {
        "assumed": {
            "insulator, thickness": (1e6 * skin.insulator_thickness_m, "um"),
            "insulator, relative permittivity": (skin.insulator_permittivity, ""),
            "stratum corneum, thickness": (1e6 * skin.corneum_thickness_m, "um"),
            "stratum corneum, relative permittivity": (skin.corneum_permittivity, ""),
            "stratum corneum, resistivity": (skin.corneum_resistivity_ohm_m, "ohm m"),
            "contact area": (1e4 * AREA_M2, "cm2"),
        },
        "derived": {
            "capacitance of the insulator": (1e9 * skin.insulator_capacitance_f(AREA_M2), "nF"),
            "capacitance of the corneum": (1e9 * skin.corneum_capacitance_f(AREA_M2), "nF"),
            "share of a fast voltage across the corneum": (skin.k, ""),
        },
        "calibrated": {
            "resistance of the corneum": (1e-3 * skin.corneum_resistance_ohm(AREA_M2), "kohm"),
            "time constant": (1e6 * skin.tau_s, "us"),
            "corner of the high-pass": (skin.cutoff_hz, "Hz"),
        },
    }
    for origin, named in constants.items():
        for name, value in named.items():
            yield Number(name, "set P0", *value, origin)


def applied_forces() -> Iterator[Number]:
    from tactometry.analysis.tasks.applied_force import force_of_participants, force_table

    for row in force_table(force_of_participants(touches(), [FORCE]), [FORCE]).to_dict("records"):
        number = partial(Number, condition=f"condition of {row[FORCE]:g} N", origin="assumed")
        yield number("asked", value=row[FORCE], unit="N")
        yield number("mean applied force", value=row["mean"], unit="N")
        yield number("SD between participants", value=row["sd"], unit="N")
        yield number("time in the band", value=100 * row["in_band"], unit="%")


def electrovibration_thresholds() -> Iterator[Number]:
    table: dict[float, dict[float, float]] = {}
    for cell in cells_of(STUDY):
        frequency_hz = float(cell.condition.factors["frequency_hz"])
        table.setdefault(contact_of(cell).force_n, {})[frequency_hz] = threshold_db(cell)
    first_n = min(table)
    for force_n, levels_db in table.items():
        for frequency_hz, level_db in levels_db.items():
            yield Number(f"threshold at {force_n:g} N", f"{frequency_hz:g} Hz", level_db, "dB re 1 V", "derived")
            if force_n != first_n:
                change_db, span = level_db - table[first_n][frequency_hz], f"from {first_n:g} to {force_n:g} N"
                yield Number(span, f"{frequency_hz:g} Hz", change_db, "dB", "derived")


THICK = (
    "A4 sheets of Borofloat, supported edges, eight discs along two sides, tau = 3.5 ms, T = 2 tau, one bit at 30 V; "
    "bands from 0 Hz on (10 and 25 kHz are in the list of figures, the others were chosen here); mean over five foci; "
    "width at half the amplitude. Glass, places of the discs and tau (from finding-2) are unverified defaults. Rows: "
    "thickness of the glass / diameter of the discs, end of the band."
)
EARLIER = "Earlier work, on another plate: eight actuators at 30 V, 10 um, resolution 10 mm (page 36)."
