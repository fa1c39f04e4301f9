"""Findings 1, 2 and 4 of the thesis."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from statistics import fmean

import numpy as np
from scipy.signal import resample

from tactometry.observers import decisions
from tactometry.stimuli.defaults import RESISTANCE_N_S_PER_M
from tactometry.stimuli.scenes.default_scenes import default_scene
from tactometry.stimuli.time_reversal.finger import PULP_MASS_KG, amplitude_loss, ejection_force_n
from tactometry.stimuli.time_reversal.fingertip import Fingertip
from tactometry.stimuli.time_reversal.focusing.pattern import HIGH_HZ, LOW_HZ, PATTERNS
from tactometry.stimuli.time_reversal.lift_off import ContactCourse, one_sided_contact
from tactometry.stimuli.time_reversal.screen.attenuation import TAU_S, Attenuation
from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE, Screen
from tactometry.stimuli.time_reversal.stimulus.focus_train import FocusTrain
from tactometry.stimuli.time_reversal.stimulus.sensation import TimeReversalSensation, free_displacement

from ..study.felt_scene import felt
from .predicted_threshold import PRESSED_N, focus_course, predicted_loss, predicted_threshold
from .reproduction import Number, Origin
from .setups import ELSEWHERE, FOCUS, RIG_BAND
from .spread import N_DRAWS, PULP, RANGES, SEED, of_ranges
from .studies import cells_of, contact_of, sensation_db, threshold_db

BAND_ASSUMES = f"5 to 95 % of {N_DRAWS} draws with seed {SEED}"
OF_FOCUS, OF_PULP = of_ranges(RANGES), of_ranges(PULP)
FOCUS_STUDY = "time-reversal-threshold"
NO_CHANGE_DB = 0.5
FOCUS_M, FOCUS_DB, MEAN_HZ = 10e-6, 20.0, 12.5e3
"""10 um, in dB re 1 um, and its mean frequency."""
FINER, RINGING_S = 8, 2e-3
"""Steps of a contact per sample of the drive, and its time after the drive."""
Levels = Sequence[tuple[float, float]]


def threshold_of_focus() -> Iterator[Number]:
    of_study = [(contact_of(cell).force_n, threshold_db(cell)) for cell in cells_of(FOCUS_STUDY)]
    of_free_plate = _levels(criterion="unloaded")
    of_loaded_plate = _levels(criterion="loaded")
    of_mass = _levels(criterion="loaded", resistance_n_s_per_m=0.0, mass_kg=PULP_MASS_KG)
    for force_n, level_db in of_study:
        is_near = abs(level_db - FOCUS_DB) < 1
        found_um = 10 ** (level_db / 20)
        yield Number("threshold", f"{force_n:g} N", found_um, "um", "calibrated", "about 10 um", is_near)

    yield _change("the built-in study", of_study, "assumed" if of_study == of_free_plate else "derived")
    opened = {force_n: opened_contact(force_n) for force_n, _ in of_study}
    at_loss = [(force_n, FOCUS_DB + _loss_db(contact)) for force_n, contact in opened.items()]
    yield replace(_change("criterion unloaded", of_free_plate, "assumed"), is_variant=True)
    for model, levels in {
        "criterion loaded": of_loaded_plate,
        "criterion loaded, by a mass of 0.1 g alone": of_mass,
        "criterion loaded, contact that opens (loss at 10 um)": at_loss,
    }.items():
        yield replace(_change(model, levels, "derived"), is_variant=True)
    for force_n, contact in opened.items():
        lost_s = np.count_nonzero(contact.apart) / (FINER * _focus().setup.rate_hz)
        yield Number("contact lost at 10 um", f"{force_n:g} N", 1e6 * lost_s, "us", "derived")
    lifted_n = ejection_force_n(FOCUS_M, MEAN_HZ)
    yield Number("force that a focus lifts", "10 um at 12.5 kHz under 0.1 g", lifted_n, "N", "derived")

    setup = _focus().setup
    free_m = free_displacement(_focus().at(FOCUS_DB), setup, setup.focus_m)
    yield from predicted_threshold(focus_course(free_m, setup.rate_hz))


def opened_contact(force_n: float) -> ContactCourse:
    """Simulate a focus of 10 um under a finger that cannot pull."""
    setup, signal = _focus().setup, _focus().at(FOCUS_DB)
    n_played = int(np.flatnonzero(signal.samples.any(axis=0))[-1]) + 1
    free_m = free_displacement(signal, setup, setup.focus_m)
    kept = resample(free_m, FINER * len(free_m))[: FINER * (n_played + round(RINGING_S * setup.rate_hz))]
    return one_sided_contact(setup.screen, setup.focus_m, kept, FINER * setup.rate_hz, setup.modes_to_hz, force_n)


def _focus() -> FocusTrain:
    stimulus = cells_of(FOCUS_STUDY)[0].stimulus
    assert isinstance(stimulus, FocusTrain), "the built-in study plays a focus"
    return stimulus


def _loss_db(contact: ContactCourse) -> float:
    return -20 * math.log10(float(np.abs(contact.displacement_m).max()) / FOCUS_M)


def _levels(**model: object) -> Levels:
    """Return force (N) and threshold (dB re 1 um) by a fixed amplitude."""
    skin = felt(default_scene(TimeReversalSensation(**model)))  # type: ignore[arg-type]
    return [(contact_of(cell).force_n, threshold_db(cell, skin)) for cell in cells_of(FOCUS_STUDY)]


def _change(model: str, levels: Levels, origin: Origin) -> Number:
    (first_n, first_db), *_, (last_n, last_db) = sorted(levels)
    change_db, quantity = last_db - first_db, f"threshold from {first_n:g} to {last_n:g} N"
    is_constant = abs(change_db) < NO_CHANGE_DB
    return Number(quantity, model, change_db, "dB", origin, "force has no influence", is_constant)


DEFAULT = (RESISTANCE_N_S_PER_M, TAU_S)
FINGERS = (DEFAULT, (5.0, TAU_S), (20.0, TAU_S), (RESISTANCE_N_S_PER_M, 2e-3), (RESISTANCE_N_S_PER_M, 5e-3))
"""Resistance (N s/m) and tau (s)."""
STATED = {"at the focus": ("up to 30 %", 0.25, 0.33), "elsewhere": ("about 6 %", 0.04, 0.08)}


def loss_under_finger() -> Iterator[Number]:
    for resistance, tau_s in FINGERS:
        condition = f"R = {resistance:g} N s/m, tau = {tau_s * 1e3:g} ms"
        screen = Screen(A4_PROTOTYPE.plate, A4_PROTOTYPE.sources, Attenuation(tau_s))
        for place, at_m in {"at the focus": (FOCUS,), "elsewhere": ELSEWHERE}.items():
            loss = _loss(screen, at_m, resistance)
            if (resistance, tau_s) == DEFAULT:
                stated, low, high = STATED[place]
                yield Number(place, condition, 100 * loss, "%", "calibrated", stated, low <= loss <= high)
            else:
                yield Number(place, condition, 100 * loss, "%", "derived")
        if (resistance, tau_s) == DEFAULT:
            relearnt = _loss(screen, (FOCUS,), resistance, relearn=True)
            yield Number("at the focus, learnt again", condition, 100 * relearnt, "%", "calibrated")
    yield from predicted_loss()


def _loss(screen: Screen, places: Sequence[tuple[float, float]], resistance: float, *, relearn: bool = False) -> float:
    loads = [Fingertip(resistance).load(at_m, PRESSED_N) for at_m in places]
    return fmean(amplitude_loss(screen, FOCUS, [load], RIG_BAND, relearn=relearn) for load in loads)


PATTERN_STUDY = "time-reversal-patterns"
SAME_DB = 1.0
"""Smaller differences are no order."""
FUSED_S = 10e-3
"""Foci closer than this are one onset; no source, of the order of a gap that touch detects."""
LEAST = "P0"
BEST = ("200 Hz", "sinc")
"""Frequency and envelope that please most, stated separately."""


def pleasant_patterns() -> Iterator[Number]:
    felt_db = levels_db()
    liked = {name: decisions.liking(level_db) for name, level_db in felt_db.items()}
    order = sorted(liked, key=lambda name: -liked[name])
    is_order = max(felt_db.values()) - min(felt_db.values()) >= SAME_DB
    for name, level_db in felt_db.items():
        compared = ("last: pleases least", is_order and order[-1] == name) if name == LEAST else ()
        yield Number("sensation level", pattern_name(name), level_db, "dB", "calibrated")
        yield Number("over the single focus", pattern_name(name), level_db - felt_db[LEAST], "dB", "derived")
        pattern, condition = PATTERNS[name], pattern_name(name)  # without a model of answers
        yield Number("energy of the foci", condition, 10 * math.log10(np.sum(pattern.weights**2)), "dB", "derived")
        felt_s = pattern.times_s[np.abs(pattern.weights) > 10 ** (-felt_db[LEAST] / 20)]
        yield Number("foci above threshold", condition, len(felt_s), "", "calibrated")
        onsets = 1 + np.count_nonzero(np.diff(felt_s) > FUSED_S)
        yield Number("onsets", condition, float(onsets), "", "calibrated")
        yield Number("pleasantness", pattern_name(name), liked[name], "of 1", "assumed")
        yield Number("place", pattern_name(name), order.index(name) + 1.0, "", "assumed", *compared)
    yield from _by_factor(liked, is_order=is_order)


def _by_factor(liked: Mapping[str, float], *, is_order: bool) -> Iterator[Number]:
    trains = {name: pattern_name(name).split(", ")[1:] for name in liked if name != LEAST}
    for column in range(2):
        values = dict.fromkeys(train[column] for train in trains.values())
        means = {value: fmean(liked[name] for name in trains if trains[name][column] == value) for value in values}
        most = max(means, key=lambda value: means[value])
        for value, mean in means.items():
            compared = ("pleases most", is_order and value == most) if value in BEST else ()
            yield Number("mean pleasantness", f"trains, {value}", mean, "of 1", "assumed", *compared)


def levels_db() -> dict[str, float]:
    """Return the sensation level of each pattern of the built-in study."""
    return {
        str(cell.condition.factors["pattern"]): sensation_db(cell, cell.procedure.rule.bounds[1])
        for cell in cells_of(PATTERN_STUDY)
    }


def pattern_name(name: str) -> str:
    """Return a pattern's name with its frequency and envelope."""
    pattern = PATTERNS[name]
    if pattern.n_foci == 1:
        return f"{name}, a single focus"
    rate_hz = LOW_HZ if pattern.repetition_hz == LOW_HZ else HIGH_HZ
    return f"{name}, {rate_hz:g} Hz, {type(pattern.envelope).__name__.lower()}"
