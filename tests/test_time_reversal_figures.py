"""Figures: each draws, has units on its axes, and shows the numbers that it was given."""

import os

import numpy as np
import pytest

from tactometry.errors import InvalidParameter
from tactometry.stimuli.time_reversal.closed_forms import Reverberation, resolution_m
from tactometry.stimuli.time_reversal.figures import drives, focus, prototype, theory
from tactometry.stimuli.time_reversal.figures.gallery import FOCI, FOCUS, GALLERY, UNFILTERED, rig
from tactometry.stimuli.time_reversal.figures.style import save
from tactometry.stimuli.time_reversal.finger import Emission
from tactometry.stimuli.time_reversal.force_loss import LossRow
from tactometry.stimuli.time_reversal.glass import A4_SCREEN
from tactometry.stimuli.time_reversal.screen import A4_PROTOTYPE
from tactometry.stimuli.time_reversal.sound import NoiseSpectrum
from tactometry.stimuli.time_reversal.spectrum import Band
from tactometry.stimuli.time_reversal.variability import (
    amplitude_by_subset_m,
    amplitude_over_count_m,
    contributions_m,
    resolution_per_focus_m,
)

SLOW = {"3.8-focus-map", "3.13-scans-per-band", "4.15-four-signals", "4.25-sound", "4.34-resolution-of-foci"}
SLOW |= {"5.3-force-loss"}
SMALL = Emission(Band(500.0, 12e3), 4e-3, 50e3)


@pytest.mark.parametrize("name", GALLERY)
def test_gallery_draws_with_a_label_on_every_axis(name, tmp_path):
    if name in SLOW and "TACTOMETRY_SOAK" not in os.environ:
        pytest.skip("full size: set TACTOMETRY_SOAK=1; a reduced form is drawn below")
    figure = GALLERY[name]()
    save(figure, tmp_path / "figure.png")
    assert (tmp_path / "figure.png").read_bytes().startswith(b"\x89PNG")
    for axes in figure.axes:
        assert axes.get_ylabel() or axes.get_xlabel() or not axes.axison


def test_reduced_focus_figures(tmp_path):
    for i, figure in enumerate(
        (
            focus.displacement_map(A4_PROTOTYPE, FOCUS, SMALL),
            focus.scans_per_band(A4_PROTOTYPE, FOCUS, [Band(0.0, 4e3), Band(4e3, 12e3)], SMALL),
            focus.four_signals(A4_PROTOTYPE, FOCUS, {"1 bit": SMALL}),
        )
    ):
        save(figure, tmp_path / f"{i}.svg")
        assert all("(" in axes.get_xlabel() for axes in figure.axes if axes.get_xlabel())


def test_loss_figure_has_a_line_for_each_contactor():
    rows = [LossRow(c, 5e-3, p, f, 0.1 * f) for c in ("finger", "soft") for p in ("F", "P1") for f in (0.0, 2.0)]
    figure = prototype.loss_over_force(rows)
    assert [len(axes.lines) for axes in figure.axes] == [2, 2]
    assert list(figure.axes[0].lines[0].get_ydata()) == [0.0, 20.0]


def test_sound_figure_names_the_level():
    f = np.arange(0.0, 125e3, 50.0)
    figure = drives.sound_spectra({"quiet": NoiseSpectrum(f, np.full(f.size, 1e-9))})
    assert "dBA" in figure.axes[0].get_title()


def test_measured_points_are_drawn():
    figure = theory.resolution_over_mean_frequency(A4_SCREEN, [(12.5e3, 15e-3), (20e3, 12e-3)])
    drawn = [line for line in figure.axes[0].lines if line.get_marker() == "s"]
    assert [float(line.get_ydata()[0]) for line in drawn] == [15.0, 12.0]


def test_measured_losses_and_contrasts_are_drawn_beside_their_model():
    rows = [LossRow(kind, 1e-2, "F", force_n, 0.1 * force_n) for kind in ("finger", "soft") for force_n in (1.0, 2.0)]
    (axes, *_) = prototype.loss_over_force(rows, [LossRow("finger", 1e-2, "F", 1.5, 0.2)]).axes
    drawn = [line for line in axes.lines if line.get_fillstyle() == "none"]
    assert [(float(line.get_xdata()[0]), float(line.get_ydata()[0])) for line in drawn] == [(1.5, pytest.approx(20.0))]
    room = Reverberation(32, 25e3, 3.5e-3, 7e-3, 0.018, 1.25)
    (axes,) = theory.contrast_over_transducers(room, (8,), np.linspace(1e-3, 9e-3, 5), {8: [(2e-3, 9.0)]}).axes
    assert [float(line.get_ydata()[0]) for line in axes.lines if line.get_marker() == "o"] == [9.0]


def test_contributions_add_up_to_the_focus():
    from tactometry.stimuli.time_reversal.focusing import drive, focus_amplitude

    h = SMALL.responses(A4_PROTOTYPE, FOCI[:3])
    contributions = contributions_m(h, 30.0)
    for i in range(3):
        assert contributions[i].sum() == pytest.approx(focus_amplitude(drive(h.at_point(i), 30.0), h, i), rel=1e-12)


def test_amplitude_grows_with_each_transducer_to_the_same_end():
    contributions = np.random.default_rng().uniform(0.5, 1.5, (4, 8))
    grown = amplitude_over_count_m(contributions, np.random.default_rng(), 5)
    assert np.all(np.diff(grown, axis=2) > 0)
    assert grown[:, :, -1] == pytest.approx(np.broadcast_to(contributions.sum(axis=1), (5, 4)))


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
