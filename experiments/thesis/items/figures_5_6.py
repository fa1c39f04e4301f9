"""Figures of chapters 5 and 6 and of appendix B about results."""

import math
from typing import Any, get_args

from tactometry.observers.signal_detection import SignalDetectionObserver
from tactometry.stimuli.electrovibration.textures.texture import Grating, Shape

from ...study.cells import WiredCell
from ..figures import electrovibration, perception
from ..figures.gallery import GALLERY
from ..reproduction import Reproduction
from .studies import contact_of, experiment

FOCUS_STUDY, FRICTION_STUDY = "time-reversal-threshold", "electrovibration-threshold"
FOCUS_LEVELS_DB = tuple(float(level) for level in range(8, 36, 2))
FRICTION_LEVEL_DB = 32.0
N_NODES = 41
PEOPLE = "Participants are simulated (signal detection; spread, slope and lapses are unverified defaults)."


def share_of_yes(people: SignalDetectionObserver, sensation_db: float, spread_db: float) -> float:
    """Mean rate of yes over people whose sensitivity differs by `spread_db`, by Gauss and Hermite's rule: lapses / 2 +
    (1 - lapses) Phi(d' - c)."""
    import numpy as np
    from scipy.special import ndtr

    nodes, weights = np.polynomial.hermite_e.hermegauss(N_NODES)
    heard = [people.d_prime(sensation_db + spread_db * float(node)) for node in nodes]
    rates = ndtr(np.array(heard) - people.criterion)
    felt = float(weights @ rates / math.sqrt(2 * math.pi))
    return people.lapse_rate / 2 + (1 - people.lapse_rate) * felt


def _rate(study: str, cell: WiredCell, level_db: float) -> float:
    people = experiment(study).people
    middle = people.middle
    assert isinstance(middle, SignalDetectionObserver), "the built-in studies name no other"
    spread_db = math.hypot(middle.between_sd_db, people.people.deviation_sd_db)
    return share_of_yes(middle, cell.sensation.sensation_db(cell.stimulus.at(level_db), contact_of(cell)), spread_db)


def _against_amplitude() -> Any:
    amplitudes_um = [10 ** (level_db / 20) for level_db in FOCUS_LEVELS_DB]
    curves = {
        f"{contact_of(cell).force_n:g} N": (
            amplitudes_um,
            [_rate(FOCUS_STUDY, cell, level_db) for level_db in FOCUS_LEVELS_DB],
        )
        for cell in experiment(FOCUS_STUDY).cells.values()
    }
    return perception.detection_rate(curves, "Amplitude of the free plate at the focus (µm)")


def _against_frequency() -> Any:
    curves: dict[str, tuple[list[float], list[float]]] = {}
    for cell in experiment(FRICTION_STUDY).cells.values():
        frequencies_hz, rates = curves.setdefault(f"{contact_of(cell).force_n:g} N", ([], []))
        frequencies_hz.append(float(cell.condition.factors["frequency_hz"]))
        rates.append(_rate(FRICTION_STUDY, cell, FRICTION_LEVEL_DB))
    title = f"{FRICTION_LEVEL_DB:g} dB re 1 V peak"
    return perception.detection_rate(curves, "Frequency (Hz)", title, logarithmic=True)


def _textures() -> Any:
    return electrovibration.input_against_position(
        {f"{shape}, 4 mm": Grating(4e-3, shape) for shape in get_args(Shape)}
    )


FIGURE_5_4 = Reproduction(
    title="Loss of amplitude against force, at P1 and at the focus",
    stated="Figures 5.4 and 5.5 by their captions (page 13); 6 % and up to 30 % at 2 N (page 3): finding-2.",
    assumes="The finger is set to these losses; other contactors and the growth with force are unverified defaults.",
    drawing=GALLERY["5.4-force-loss"],
    origin="calibrated",
)
FIGURE_5_7 = Reproduction(
    title="Mean detection rate against amplitude",
    stated="Figure 5.7 by its caption (page 13); a threshold of about 10 um (page 4): finding-1.",
    assumes=f"{PEOPLE} The threshold of 10 um is put in.",
    drawing=_against_amplitude,
    origin="calibrated",
)
FIGURE_5_8 = Reproduction(
    title="Patterns tested",
    stated="Figure 5.8 by its caption (page 13); 200 Hz and a cardinal sine are among them (page 4).",
    assumes="The other frequency and envelopes, and the duration, are unverified defaults.",
    drawing=GALLERY["5.8-patterns"],
    origin="assumed",
)
FIGURE_6_3 = Reproduction(
    title="Input signal against the position of the finger",
    stated="Figure 6.3 by its caption (page 13).",
    assumes="Gratings of 4 mm and a carrier that can be seen.",
    drawing=_textures,
    origin="assumed",
)
FIGURE_6_5 = Reproduction(
    title="Electrostatic force against contact area",
    stated="Figure 6.5 by its caption (page 13).",
    assumes="The parameter set P0 of Table 6.1, a step of 100 V, each of four laws in print.",
    drawing=electrovibration.force_against_area,
)
FIGURE_6_6 = Reproduction(
    title="Resistivity and permittivity of the corneum and of deeper tissue",
    stated="Figure 6.6 by its caption, from Yamamoto and Yamamoto (page 13).",
    assumes="Both tables are unverified defaults.",
    drawing=electrovibration.skin_properties,
    origin="assumed",
)
FIGURE_6_8 = Reproduction(
    title="Electrostatic force of a step, a trapeze and a sine for several areas",
    stated="Figures 6.8 to 6.10 by their captions (pages 13 and 14).",
    assumes="The parameter set P0 of Table 6.1, 40 dB re 1 V, 0.5 to 1.5 cm2, the law of the corneum's layer.",
    drawing=electrovibration.force_for_inputs,
)
FIGURE_6_15 = Reproduction(
    title="Mean detection rate against frequency for three forces",
    stated="Figure 6.15 by its caption (page 14); the lowest thresholds at 240 Hz (page 4): finding-3.",
    assumes=f"{PEOPLE} All at {FRICTION_LEVEL_DB:g} dB re 1 V peak, at which some are felt and some not; forces and "
    "frequencies of the built-in study are unverified defaults. No constant is set to a voltage, but the input was "
    "chosen for where its force vibrates, and with it the frequency that is felt most. Over "
    "which levels the thesis's mean is taken, our sources do not say.",
    drawing=_against_frequency,
    origin="assumed",
)
FIGURE_B_1 = Reproduction(
    title="Inked surface against force, as ellipses",
    stated="Figures B.1 and B.2 by their captions: 0.2, 1.5, 3.0 and 7.0 N, the surface of an ellipse (page 14).",
    assumes="The axes of the prints are unverified defaults.",
    drawing=electrovibration.contact_ellipse,
    origin="assumed",
)
