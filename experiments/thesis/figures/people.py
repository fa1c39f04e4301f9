"""Figures of chapters 5 and 6 and of the appendices."""

import math
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any, get_args

import numpy as np
from matplotlib.figure import Figure
from scipy.special import ndtr

from tactometry.observers.signal_detection import SignalDetectionObserver
from tactometry.stimuli.electrovibration.textures.texture import Grating, Shape
from tactometry.stimuli.time_reversal.figures.theory import colours, label, sheet

from ...study.cells import WiredCell
from ..studies import (
    FORCE,
    cells_of,
    contact_of,
    experiment,
    sensation_db,
    simulated_trials,
    touches,
)
from . import electrovibration

if TYPE_CHECKING:
    from tactometry.analysis.outcomes.ratings import Ratings

Curve = tuple[Sequence[float], Sequence[float]]
FOCUS_STUDY, FRICTION_STUDY = "time-reversal-threshold", "electrovibration-threshold"
FOCUS_LEVELS_DB, FRICTION_LEVEL_DB = tuple(float(level) for level in range(8, 36, 2)), 32.0
N_NODES, BIN_N = 41, 0.04
PEOPLE = "Participants are simulated (signal detection; spread, slope and lapses are unverified defaults)."


def share_of_yes(people: SignalDetectionObserver, level_db: float, spread_db: float) -> float:
    """Return the mean rate of "yes" if sensitivities vary by `spread_db`.

    The rate is lapses / 2 + (1 - lapses) Phi(d' - c), integrated by the Gauss-Hermite rule.
    """
    nodes, weights = np.polynomial.hermite_e.hermegauss(N_NODES)
    d_primes = [people.d_prime(level_db + spread_db * float(node)) for node in nodes]
    felt = float(weights @ ndtr(np.array(d_primes) - people.criterion) / math.sqrt(2 * math.pi))
    return people.lapse_rate / 2 + (1 - people.lapse_rate) * felt


def _rate(study: str, cell: WiredCell, level_db: float) -> float:
    people = experiment(study).people
    middle = people.middle
    assert isinstance(middle, SignalDetectionObserver), "the built-in studies name no other"
    spread_db = math.hypot(middle.between_sd_db, people.people.deviation_sd_db)
    return share_of_yes(middle, sensation_db(cell, level_db), spread_db)


def rate_by_amplitude() -> Figure:
    """Draw the detection rate against the amplitude of a focus (5.7)."""
    amplitudes_um, curves = [10 ** (level_db / 20) for level_db in FOCUS_LEVELS_DB], {}
    for cell in cells_of(FOCUS_STUDY):
        rates = [_rate(FOCUS_STUDY, cell, level_db) for level_db in FOCUS_LEVELS_DB]
        curves[f"{contact_of(cell).force_n:g} N"] = (amplitudes_um, rates)
    return detection_rate(curves, "Amplitude of the free plate at the focus (µm)")


def rate_by_frequency() -> Figure:
    """Draw the detection rate against frequency, a curve per force (6.15)."""
    curves: dict[str, tuple[list[float], list[float]]] = {}
    for cell in cells_of(FRICTION_STUDY):
        frequencies_hz, rates = curves.setdefault(f"{contact_of(cell).force_n:g} N", ([], []))
        frequencies_hz.append(float(cell.condition.factors["frequency_hz"]))
        rates.append(_rate(FRICTION_STUDY, cell, FRICTION_LEVEL_DB))
    title = f"{FRICTION_LEVEL_DB:g} dB re 1 V peak"
    return detection_rate(curves, "Frequency (Hz)", title, logarithmic=True)


def detection_rate(curves: Mapping[str, Curve], x_label: str, title: str = "", *, logarithmic: bool = False) -> Figure:
    """Draw rates with markers of falling size."""
    figure, (axes,) = sheet()
    looks = zip(colours(), "osD^v<>", (11, 8, 5, 4, 4, 4, 4), strict=False)
    for (name, (x, rates)), (colour, marker, size) in zip(curves.items(), looks, strict=False):
        axes.plot(x, np.multiply(100, rates), f"{marker}-", color=colour, markersize=size, label=name)
    if logarithmic:
        ticks = next(iter(curves.values()))[0]
        axes.set_xscale("log")
        axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
        axes.minorticks_off()
    axes.set_ylim(-3, 103)
    label(axes, x_label, "Mean detection rate (%)", title)
    return figure


def mean_force_by_condition() -> Figure:
    """Draw the mean applied force of each condition by frequency (6.12)."""
    from tactometry.analysis.figures.psychophysics import threshold_figure
    from tactometry.analysis.tasks.applied_force import force_of_participants, force_table

    factors = [FORCE, "frequency_hz"]
    individuals = force_of_participants(touches(), factors)
    targets = sorted(set(individuals[FORCE]))
    values = force_table(individuals, factors), individuals, factors, "force_mean_n"
    return threshold_figure(*values, "Mean applied force (N)", targets=targets, from_zero=True).figure


def forces_of_trials() -> Figure:
    """Draw the distribution of applied forces per condition (6.13)."""
    figure, (axes,) = sheet(width_in=7.2)
    for (target, forces), colour in zip(touches().groupby(FORCE)["force_mean_n"], colours(), strict=False):
        target_n = float(str(target))
        shares, edges_n = np.histogram(forces, BIN_N * np.arange(np.ceil(1.3 * target_n / BIN_N) + 1))
        middles_n = (edges_n[:-1] + edges_n[1:]) / 2
        axes.plot(middles_n, 100 * shares / len(forces), color=colour, drawstyle="steps-mid", label=f"{target_n:g} N")
        axes.axvline(target_n, color=colour, linestyle="--", linewidth=0.8)
    label(axes, "Mean applied force of a trial (N)", "Trials of the condition (%)", "Dashed: asked", from_zero=True)
    return figure


PATTERN_STUDY, N_RATERS = "time-reversal-patterns", 10


@lru_cache(maxsize=1)
def ratings_of_patterns() -> "Ratings":
    """Return the ratings of patterns by simulated participants."""
    from tactometry.analysis.outcomes.ratings import ratings

    [form] = ratings(simulated_trials(PATTERN_STUDY, N_RATERS))
    return form


def word_pairs(*patterns: str) -> Figure:
    """Draw the profile of some patterns (5.9 to 5.11, appendix A)."""
    return _profile(ratings_of_patterns().profile, patterns)


def grouped_word_pairs(factor: str) -> Figure:
    """Draw the mean profiles by frequency or envelope (5.12, 5.13)."""
    grouped = ratings_of_patterns().grouped
    assert grouped is not None, "the built-in study rates all patterns"
    profile = grouped[grouped["of"] == factor]
    return _profile(profile, tuple(dict.fromkeys(profile["condition"])))


def _profile(profile: Any, names: tuple[str, ...]) -> Figure:
    from tactometry.analysis.figures.attrakdiff import profile_figure

    form = ratings_of_patterns().form
    return profile_figure(profile, names, form.score_low, form.score_high).figure


def textures() -> Figure:
    """Draw the input of gratings against position (6.3)."""
    gratings = {f"{shape}, 4 mm": Grating(4e-3, shape) for shape in get_args(Shape)}
    return electrovibration.input_against_position(gratings)


ASSUMES = (
    f"{N_RATERS} simulated participants of the built-in study {PATTERN_STUDY} with seed 1, and its form: the items of "
    "the thesis were inspired by the AttrakDiff, our sources do not say which. One rating model, an inverted U of the "
    "sensation level (unverified), answers each item: word pairs of a pattern differ by chance alone."
)
DRAWN: Mapping[str, Callable[[], Figure]] = {
    "5.7": rate_by_amplitude,
    "5.9": partial(word_pairs, "P0"),
    "5.10": partial(word_pairs, "P0", "P1", "P2", "P3"),
    "5.11": partial(word_pairs, "P0", "P4", "P5", "P6"),
    "5.12": partial(grouped_word_pairs, "frequency"),
    "5.13": partial(grouped_word_pairs, "envelope"),
    "6.3": textures,
    "6.5": electrovibration.force_against_area,
    "6.6": electrovibration.skin_properties,
    "6.8": electrovibration.force_for_inputs,
    "6.12": mean_force_by_condition,
    "6.13": forces_of_trials,
    "6.15": rate_by_frequency,
    **{f"A.{n + 1}": partial(word_pairs, f"P{n}") for n in range(7)},
    "B.1": electrovibration.contact_ellipse,
}
"""Function that returns each figure."""
