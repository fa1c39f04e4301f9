"""Finding 3 over the spread of the sources of its parameters.

Each threshold is that of the built-in scene, moved by what a draw changes in the gain from voltage to skin. The gain is
a product of closed forms, so that thousands of draws cost less than one scene. They agree with scenes to 0.05 dB: the
gain of the layers is taken at the frequency of the carrier. Seeds change the ends of a band by some 0.1 dB.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from math import pi

import numpy as np

from tactometry.stimuli.arrays import FloatArray
from tactometry.stimuli.defaults import THRESHOLD_M, VACUUM_PERMITTIVITY_F_PER_M as E0
from tactometry.stimuli.electrovibration.attraction.contact_area import PowerLawArea
from tactometry.stimuli.electrovibration.motion.coulomb_friction import CoulombFriction
from tactometry.stimuli.electrovibration.motion.friction_lag import FrictionLag
from tactometry.stimuli.electrovibration.motion.skin_mobility import SkinMobility
from tactometry.stimuli.electrovibration.skin.skin import Skin
from tactometry.stimuli.scenes.effects.carrier import Carrier

from .reproduction import Number, band_of
from .spread import SourcedRange, draw, rank_correlations

N_DRAWS, SEED = 2000, 35
FREQUENCIES_HZ = (30.0, 60.0, 120.0, 180.0, 240.0, 320.0, 400.0, 480.0)
SHOWN_HZ = (60.0, 120.0, 240.0, 480.0)
FORCES_N = (0.5, 1.5, 3.0)
SPEED_M_PER_S = 0.05
BEST_HZ, LIMITED_DB = 240.0, 1.0
SURFACE, ABLATION = "Thresholds over the spread of the sources", "What changes with force"
CORRELATIONS = "Rank correlation of the change from 0.5 to 3 N with each range"
BOTH = "limited to 240 Hz and falls above"
MOST = 50.0
"""Percentage of draws above which a statement holds."""
STEPS = {
    "the area alone": "area_exponent",
    "+ stiffness": "stiffness_exponent",
    "+ damping": "damping_exponent",
    "+ coefficient of friction": "load_exponent",
    "+ resistance of the body (all ranges)": "body_ohm",
}
"""Rows of the ablation: each adds a range through which force acts."""
ALL = list(STEPS)[-1]
MINDLIN = "all ranges, stiffness and damping as the radius of the contact"
Draws = Mapping[str, FloatArray]

RANGES: Mapping[str, SourcedRange] = {
    "area_exponent": SourcedRange("exponent of the contact area", "", 0.0, 2 / 3,
        "0: the area of one finger was largest at 1 N (Tomlinson, Lewis and Carre, Wear, 2009, abstract); 2/3: Hertz "
        "(textbook), which the gross deformation does not follow (Dzidek et al. 2017, abstract); the apparent area, as "
        "the model has no other"),
    "stiffness_exponent": SourcedRange("exponent of the stiffness", "", 0.0, 1.0,
        "1: varies linearly with normal force after relaxation (Pataky et al. 2005, abstract; in proportion, if the "
        "intercept is 0, which we could not read); 1/3: Mindlin under a Hertz contact (textbook); 0: none"),
    "damping_exponent": SourcedRange("exponent of the damping", "", 0.0, 1.0,
        "no source; the range of the stiffness, of which it is a multiple in a material of one relaxation time"),
    "stiffness_n_per_m": SourcedRange("stiffness at 1 N", "N/m", 200.0, 3000.0,
        "200: 4.04 N/m per mm/s at 50 mm/s, its intercept left out (Balasubramanian et al. 2025, abstract); 3000: no "
        "source, three times the default", "log"),
    "crossover_hz": SourcedRange("frequency from which the skin is viscous", "Hz", 50.0, 200.0,
        "some 100 Hz (Wiertlewski and Hayward 2012, abstract), with a factor of 2 without a source; it fixes the "
        "damping at 1 N by the stiffness", "log"),
    "mass_kg": SourcedRange("moving mass", "kg", 1e-4, 1.6e-3,
        "1.6 g: 3.23e-5 kg per mm/s at 50 mm/s (Balasubramanian et al. 2025, abstract); 0.1 g: no source, near the "
        "default; the same at all forces", "log"),
    "load_exponent": SourcedRange("exponent of the coefficient of friction", "", -1 / 3, 0.0,
        "0: Coulomb, found for a finger pad except after 10 s on smooth glass, where the coefficient falls with load "
        "(Dzidek et al. 2017, abstract, without an exponent); -1/3: a smooth Hertz contact (textbook); between: -0.21, "
        "from a fall of 46 % from 1 to 20 N (Seo et al. 2009, abstract)"),
    "body_ohm": SourcedRange("resistance of body and source", "ohm", 100.0, 10e3, "no source", "log"),
    "area_at_1n_m2": SourcedRange("contact area at 1 N", "m^2", 0.5e-4, 2e-4, "no source, a factor of 2", "log"),
    "coefficient": SourcedRange("coefficient of friction at 1 N", "", 0.2, 1.5,
        "0.6 on aluminium, 0.9 on rubber (Seo et al. 2009, abstract); on glass no source, a factor of 2 more", "log"),
    "cutoff_hz": SourcedRange("cut-off of the lag of friction", "Hz", 345.0, 1380.0,
        "690 Hz: 13.8 Hz per mm/s at 50 mm/s (Balasubramanian et al. 2025, abstract), a factor of 2 without a source; "
        "the same at all forces", "log"),
    "reference_m": SourcedRange("displacement at threshold at 250 Hz", "m", 1e-8, 3e-7,
        "0.01 um: some people who grasp a cylinder (Brisben et al. 1999, abstract); 0.3 um: no source; the same at all "
        "forces: tangential thresholds at 250 Hz were the same at 0.5 and 4.9 N (De Pra et al. 2022, abstract)", "log"),
}  # fmt: skip


def central() -> dict[str, FloatArray]:
    """Return the values of the built-in scene, without body resistance."""
    area, friction, skin = PowerLawArea(), CoulombFriction(), SkinMobility()
    values = {
        "area_exponent": area.exponent,
        "area_at_1n_m2": area.area_at_1n_m2,
        "stiffness_n_per_m": skin.stiffness_n_per_m,
        "stiffness_exponent": skin.stiffness_exponent,
        "damping_exponent": skin.damping_exponent,
        "crossover_hz": skin.stiffness_n_per_m / (2 * pi * skin.damping_n_s_per_m),
        "mass_kg": skin.mass_kg,
        "coefficient": friction.coefficient,
        "load_exponent": friction.load_exponent,
        "body_ohm": 0.0,
        "cutoff_hz": FrictionLag().cutoff_hz(SPEED_M_PER_S),
        "reference_m": THRESHOLD_M,
    }
    return {name: np.array([value]) for name, value in values.items()}


def gain_db(draws: Draws, frequencies_hz: Sequence[float], forces_n: Sequence[float]) -> FloatArray:
    """Return displacement per squared voltage over that at threshold.

    The shape is (n_draws, n_frequencies, n_forces), in dB up to a constant.
    """
    of = {name: values[:, None, None] for name, values in draws.items()}
    f_hz, force_n = np.reshape(frequencies_hz, (-1, 1)), np.asarray(forces_n)
    area_m2 = of["area_at_1n_m2"] * force_n ** of["area_exponent"]
    layer = 1 / np.abs(1 + of["body_ohm"] * area_m2 * admittance_s_per_m2())
    friction = of["coefficient"] * force_n ** of["load_exponent"] / np.hypot(1.0, f_hz / of["cutoff_hz"])

    stiffness = of["stiffness_n_per_m"] * force_n ** of["stiffness_exponent"]
    damping = of["stiffness_n_per_m"] / (2 * pi * of["crossover_hz"]) * force_n ** of["damping_exponent"]
    omega = 2 * pi * f_hz
    mobility = 1 / np.hypot(stiffness - of["mass_kg"] * omega**2, damping * omega)
    return np.asarray(20 * np.log10(area_m2 * layer**2 * friction * mobility / of["reference_m"]))


def admittance_s_per_m2() -> complex:
    """Return the admittance of insulator and corneum at the carrier."""
    skin, s = Skin(), 2j * pi * Carrier().carrier_hz
    insulator = skin.insulator_equivalent_m / (s * E0)
    leak = 1 / skin.corneum_resistivity_ohm_m + s * E0 * skin.corneum_permittivity
    return 1 / (insulator + skin.corneum_thickness_m / leak)


def thresholds_db(draws: Draws, built_in_db: Mapping[float, float], forces_n: Sequence[float]) -> FloatArray:
    """Return thresholds (n_draws, n_frequencies, n_forces), dB re 1 V.

    Attraction is quadratic: 1 dB of voltage is 2 dB of displacement.

    - `built_in_db`: Threshold of the built-in scene at 1 N by frequency.
    """
    moved_db = gain_db(draws, list(built_in_db), forces_n) - gain_db(central(), list(built_in_db), (1.0,))
    return np.asarray(np.reshape(list(built_in_db.values()), (-1, 1)) - moved_db / 2)


def changes_db(draws: Draws) -> FloatArray:
    """Return threshold changes (n_draws, n_frequencies), 0.5 to 3 N."""
    low_db, high_db = np.moveaxis(gain_db(draws, FREQUENCIES_HZ, (FORCES_N[0], FORCES_N[-1])), -1, 0)
    return np.asarray((low_db - high_db) / 2)


def numbers(built_in_db: Mapping[float, float]) -> Iterator[Number]:
    """Yield all numbers, from the built-in scene's thresholds at 1 N."""
    drawn = draw(RANGES, N_DRAWS, SEED)
    levels_db = thresholds_db(drawn, built_in_db, FORCES_N)
    yield from _surface(levels_db)
    for name, draws in ablation(drawn).items():
        yield from _changed(name, changes_db(draws))
    is_best = levels_db[..., 0].argmin(axis=1) == FREQUENCIES_HZ.index(BEST_HZ)
    share = 100 * float(np.mean(is_best))
    yield Number(f"draws: lowest at {BEST_HZ:g} Hz", ALL, share, "%", "assumed", is_variant=True, part=ABLATION)
    changed_db = changes_db(drawn)
    for f_hz in SHOWN_HZ:
        correlations = rank_correlations(drawn, changed_db[:, FREQUENCIES_HZ.index(f_hz)])
        for name, rho in correlations.items():
            yield Number(f"{f_hz:g} Hz", RANGES[name].name, round(rho, 3), "", "derived", part=CORRELATIONS)


def ablation(drawn: Draws) -> dict[str, Draws]:
    """Return draws in which ever more depends on force."""
    current = {**drawn, **{name: np.zeros(N_DRAWS) for name in STEPS.values()}}
    rows: dict[str, Draws] = {}
    for row, name in STEPS.items():
        current = {**current, name: drawn[name]}
        rows[row] = current
    radius = drawn["area_exponent"] / 2
    return {**rows, MINDLIN: {**drawn, "stiffness_exponent": radius, "damping_exponent": radius}}


def _surface(levels_db: FloatArray) -> Iterator[Number]:
    changed_db = levels_db[..., -1:] - levels_db[..., :1]
    columns = [f"threshold, {force_n:g} N" for force_n in FORCES_N] + [_span()]
    for i, f_hz in enumerate(FREQUENCIES_HZ):
        for name, values in zip(columns, np.concatenate([levels_db, changed_db], axis=-1)[:, i].T, strict=True):
            unit = "dB" if name == _span() else "dB re 1 V"
            yield band_of(values).number(name, f"{f_hz:g} Hz", unit, part=SURFACE)


def _changed(row: str, changed_db: FloatArray) -> Iterator[Number]:
    """Yield changes of an ablation row, and shares of draws that agree."""
    for f_hz in SHOWN_HZ:
        of_row = band_of(changed_db[:, FREQUENCIES_HZ.index(f_hz)])
        yield of_row.number(f"{_span()}, {f_hz:g} Hz", row, "dB", is_variant=True, part=ABLATION)
    is_above = np.array(FREQUENCIES_HZ) > BEST_HZ
    limited = (np.abs(changed_db[:, ~is_above]) < LIMITED_DB).all(axis=1)
    falls = (changed_db[:, is_above] < 0).all(axis=1)
    shares = {"limited to 240 Hz": limited, "falls above": falls, BOTH: limited & falls}
    for name, agrees in shares.items():
        share = 100 * float(np.mean(agrees))
        number = Number(f"draws: {name}", row, share, "%", "derived", is_variant=row != ALL, part=ABLATION)
        compared = replace(number, stated="limited influence, falls above 240 Hz", holds=share > MOST)
        yield compared if name == BOTH else number


def _span() -> str:
    return f"from {FORCES_N[0]:g} to {FORCES_N[-1]:g} N"
