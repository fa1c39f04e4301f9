"""Figures: each draws, has units on its axes, and shows the numbers that it was given."""

import re
from functools import lru_cache

import numpy as np
import pytest

from tactometry.errors import InvalidParameter
from tactometry.stimuli.time_reversal.design.closed_forms import Reverberation, resolution_m
from tactometry.stimuli.time_reversal.figures import focus as focus_figures, prototype, theory
from tactometry.stimuli.time_reversal.figures.gallery import FOCI, FOCUS, GALLERY, UNFILTERED, rig
from tactometry.stimuli.time_reversal.figures.style import save
from tactometry.stimuli.time_reversal.filters import Band
from tactometry.stimuli.time_reversal.finger import LossRow
from tactometry.stimuli.time_reversal.focusing.focusing import Emission, drive, focus_amplitude
from tactometry.stimuli.time_reversal.focusing.merit import (
    amplitude_by_subset_m,
    amplitude_over_count_m,
    contributions_m,
    resolution_per_focus_m,
)
from tactometry.stimuli.time_reversal.focusing.pattern import PATTERNS
from tactometry.stimuli.time_reversal.focusing.sigma_delta import SigmaDelta
from tactometry.stimuli.time_reversal.focusing.sound import NoiseSpectrum
from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN
from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE

SMALL = Emission(Band(500.0, 12e3), 4e-3, 50e3)
SHORT = {
    "1 bit": Emission(Band(200.0, 60e3), 2e-3, 250e3),
    "SDM, filtered": Emission(Band(20e3, 60e3), 2e-3, 500e3, quantiser=SigmaDelta(1)),
}
SIZES: dict[str, dict[str, object]] = {
    "3.8-focus-map": {"emission": SMALL},
    "3.13-scans-per-band": {"emission": SMALL},
    "4.15-four-signals": {"emissions": SHORT},
    "4.25-sound": {"emissions": SHORT},
    "4.34-resolution-of-foci": {"foci": FOCI[6:9]},
    "5.4-force-loss": {"forces_n": (0.0, 2.0)},
}
"""What is drawn smaller here than in the gallery."""

NO_UNIT = {"", "Transducer", "Focus", "Number of transducers Q", "Contrast, A / rms of the plate", "Signal / V"}
NO_UNIT |= set(PATTERNS)


@lru_cache
def drawn(name):
    figure = GALLERY[name](**SIZES.get(name, {}))
    figure.draw_without_rendering()
    return figure


@pytest.mark.parametrize("name", GALLERY)
def test_gallery_draws_with_a_label_and_its_unit_on_every_axis(name):
    for axes in drawn(name).axes:
        assert axes.get_ylabel() or axes.get_xlabel() or not axes.axison
        for label in (axes.get_xlabel(), axes.get_ylabel()):
            assert label in NO_UNIT or re.search(r"\(.+\)$|^dB re ", label), label


@pytest.mark.parametrize("kind", ["png", "svg"])
def test_a_figure_is_saved_in_the_format_of_its_suffix(kind, tmp_path):
    save(drawn("4.28-layout"), tmp_path / "deep" / f"figure.{kind}")
    start = (tmp_path / "deep" / f"figure.{kind}").read_bytes()[:8]
    assert start == (b"\x89PNG\r\n\x1a\n" if kind == "png" else b"<?xml ve")


def curve(name, axes=0, line=0):
    """The points of a drawn line, x and y, as numbers."""
    found = drawn(name).axes[axes].lines[line]
    return np.asarray(found.get_xdata(), float), np.asarray(found.get_ydata(), float)


def test_values_far_above_zero_stand_below_the_upper_edge():
    (axes,) = drawn("4.34-resolution-of-foci").axes
    assert max(line.get_ydata().max() for line in axes.lines[:2]) < 0.97 * axes.get_ylim()[1]


def test_the_focus_map_shows_the_amplitude_of_the_focus_in_micrometres():
    h = SMALL.responses(rig(35e-3), [FOCUS])
    x_mm, u_um = curve("3.8-focus-map", axes=1)
    assert np.interp(FOCUS[0] * 1e3, x_mm, u_um) == pytest.approx(focus_amplitude(drive(h, 30.0), h) * 1e6, rel=3e-2)
    assert u_um.max() == pytest.approx(np.interp(FOCUS[0] * 1e3, x_mm, u_um), rel=2e-2)


def test_the_four_signals_peak_at_time_0_and_place_0():
    for column in range(2):
        for axes, unit in ((column, 1.0 / 250), (2 + column, 100.0 / 300)):
            x, u = curve("4.15-four-signals", axes)
            assert x[np.argmax(u)] == pytest.approx(0.0, abs=2 * unit)


def test_stress_and_deflection_of_the_prototype_under_2_n_are_those_of_the_notes():
    """Science 1.8: 178, 29.6 and 8.8 um at 1.1, 2 and 3 mm; both fall with the thickness, by its cube and square."""
    h_mm, deflection_um = curve("3.15-stress-and-deflection", axes=1)
    found = np.exp(np.interp(np.log([1.1, 2.0, 3.0]), np.log(h_mm), np.log(deflection_um)))
    assert found == pytest.approx([178, 29.6, 8.8], rel=5e-3)
    _, stress_mpa = curve("3.15-stress-and-deflection", axes=0)
    assert np.polyfit(np.log(h_mm), np.log(stress_mpa), 1)[0] == pytest.approx(-2.0, abs=1e-9)


def test_the_amplitude_at_twice_tau_is_86_and_98_percent():
    for line, expected in ((0, 86.5), (1, 98.2)):
        t_ms, percent = curve("3.18-amplitude-over-reversal", line=line)
        assert np.interp(7.0, t_ms, percent) == pytest.approx(expected, abs=0.1)


def test_the_decay_that_is_fitted_is_the_one_of_the_screen():
    t_ms, envelope = curve("4.11-decay-fit", line=1)
    assert -1 / np.polyfit(t_ms[:100], np.log(envelope[:100]), 1)[0] == pytest.approx(3.5, rel=0.1)


def test_one_discs_amplitude_grows_with_its_bandwidth():
    for line in (0, 1):
        _, amplitude_um = curve("3.11-amplitude-over-bandwidth", line=line)
        assert amplitude_um[-1] > 1.5 * amplitude_um[0]


def test_loss_figure_has_a_line_for_each_contactor():
    rows = [LossRow(c, 5e-3, p, f, 0.1 * f) for c in ("finger", "soft") for p in ("F", "P1") for f in (0.0, 2.0)]
    figure = prototype.loss_over_force(rows)
    assert [len(axes.lines) for axes in figure.axes] == [2, 2]
    assert list(figure.axes[0].lines[0].get_ydata()) == [0.0, 20.0]


def test_sound_figure_names_the_level():
    f = np.arange(0.0, 125e3, 50.0)
    figure = focus_figures.sound_spectra({"quiet": NoiseSpectrum(f, np.full(f.size, 1e-9))})
    assert "dBA" in figure.axes[0].get_title()


def test_sound_above_what_is_drawn_does_not_count_in_the_last_band():
    f = np.linspace(0.0, 500e3, 5001)
    figure = focus_figures.sound_spectra({"SDM": NoiseSpectrum(f, np.where(f < 125e3, 1e-9, 0.0))})
    levels_db = figure.axes[0].lines[0].get_ydata()
    assert levels_db == pytest.approx(levels_db[0])


def test_measured_points_are_drawn():
    figure = theory.resolution_over_mean_frequency(A4_SCREEN, [(12.5e3, 15e-3), (20e3, 12e-3)])
    (drawn,) = [line for line in figure.axes[0].lines if line.get_marker() == "s"]
    assert drawn.get_xydata().tolist() == [[12.5, 15.0], [20.0, 12.0]]


def test_measured_losses_and_contrasts_are_drawn_beside_their_model():
    rows = [LossRow(kind, 1e-2, "F", force_n, 0.1 * force_n) for kind in ("finger", "soft") for force_n in (1.0, 2.0)]
    (axes, *_) = prototype.loss_over_force(rows, [LossRow("finger", 1e-2, "F", 1.5, 0.2)]).axes
    drawn = [line for line in axes.lines if line.get_fillstyle() == "none"]
    assert [(float(line.get_xdata()[0]), float(line.get_ydata()[0])) for line in drawn] == [(1.5, pytest.approx(20.0))]
    room = Reverberation(32, 25e3, 3.5e-3, 7e-3, 0.018, 1.25)
    (axes,) = theory.contrast_over_transducers(room, (8,), np.linspace(1e-3, 9e-3, 5), {8: [(2e-3, 9.0)]}).axes
    assert [float(line.get_ydata()[0]) for line in axes.lines if line.get_marker() == "o"] == [9.0]


def test_contributions_add_up_to_the_focus():
    h = SMALL.responses(A4_PROTOTYPE, FOCI[:3])
    contributions = contributions_m(h, 30.0)
    for i in range(3):
        assert contributions[i].sum() == pytest.approx(focus_amplitude(drive(h.at_point(i), 30.0), h, i), rel=1e-12)


def test_amplitude_grows_with_each_transducer_to_the_same_end():
    contributions = np.random.default_rng().uniform(0.5, 1.5, (4, 8))
    grown = amplitude_over_count_m(contributions, np.random.default_rng(), 5)
    assert np.all(np.diff(grown, axis=2) > 0)
    assert grown[:, :, -1] == pytest.approx(np.broadcast_to(contributions.sum(axis=1), (5, 4)))


def test_transducers_are_added_in_orders_that_differ():
    contributions = np.arange(1.0, 9.0)[None]
    grown = amplitude_over_count_m(contributions, np.random.default_rng(), 60)
    assert len(set(grown[:, 0, 0])) > 3
    assert set(grown[:, 0, 0]) <= set(contributions[0])


def test_subsets():
    contributions = np.arange(6.0).reshape(2, 3)
    found = amplitude_by_subset_m(contributions, {"ends": [0, 2], "all": range(3)})
    assert list(found["ends"]) == [2.0, 8.0]
    with pytest.raises(InvalidParameter, match=r"subsets\['none'\]: found \[3\], expected channels from 0 to 2"):
        amplitude_by_subset_m(contributions, {"none": [3]})


def test_resolution_of_every_focus_is_near_the_model():
    widths = resolution_per_focus_m(A4_PROTOTYPE, FOCI[:4], SMALL)
    assert widths.shape == (4, 2)
    assert np.mean(widths) == pytest.approx(resolution_m(A4_SCREEN, SMALL.band), rel=0.2)


def test_rig_of_chapter_3_has_its_discs_on_the_plate():
    assert len(rig(35e-3).sources) == 8
    assert UNFILTERED.f_max_hz == pytest.approx(66e3)
