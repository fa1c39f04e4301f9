"""Figures of the thesis: axes have units and curves show the computed numbers."""

import re
from functools import lru_cache

import numpy as np
import pytest

from tactometry.experiments.thesis.figures import electrovibration, focus, focus as focus_figures
from tactometry.experiments.thesis.figures.plates import DRAWN
from tactometry.experiments.thesis.setups import FOCI, FOCUS, rig
from tactometry.stimuli.electrovibration import Bump, Grating, Skin, Velvet, electrostatic_force_n
from tactometry.stimuli.electrovibration.attraction.contact_area import Print
from tactometry.stimuli.time_reversal.figures.theory import save
from tactometry.stimuli.time_reversal.filters import Band
from tactometry.stimuli.time_reversal.finger import LossRow
from tactometry.stimuli.time_reversal.focusing.focusing import Emission, drive, focus_amplitude
from tactometry.stimuli.time_reversal.focusing.pattern import PATTERNS
from tactometry.stimuli.time_reversal.focusing.sigma_delta import SigmaDelta
from tactometry.stimuli.time_reversal.focusing.sound import NoiseSpectrum

SMALL = Emission(Band(500.0, 12e3), 4e-3, 50e3)
SHORT = {
    "1 bit": Emission(Band(200.0, 60e3), 2e-3, 250e3),
    "SDM, filtered": Emission(Band(20e3, 60e3), 2e-3, 500e3, quantiser=SigmaDelta(1)),
}
SIZES: dict[str, dict[str, object]] = {
    "3.8": {"emission": SMALL},
    "3.13": {"emission": SMALL},
    "4.15": {"emissions": SHORT},
    "4.25": {"emissions": SHORT},
    "4.34": {"foci": FOCI[6:9]},
    "5.4": {"forces_n": (0.0, 2.0)},
}
"""Arguments that make drawings smaller than those of the items."""

NO_UNIT = {"", "Transducer", "Focus", "Number of transducers Q", "Contrast, A / rms of the plate", "Signal / V"}
NO_UNIT |= {"relative permittivity", "Characteristic time (ms) = modes per kHz", *PATTERNS}


DRAWN_FAST = {
    "6.3": lambda: electrovibration.input_against_position({"square": Grating(4e-3), "bump": Bump(0.02, 4e-3)}),
    "6.5": electrovibration.force_against_area,
    "6.6": electrovibration.skin_properties,
    "6.8": electrovibration.force_for_inputs,
    "B.1": electrovibration.contact_ellipse,
}


@lru_cache
def drawn(name):
    drawing = DRAWN_FAST[name] if name in DRAWN_FAST else DRAWN[name]
    figure = drawing(**SIZES.get(name, {}))
    figure.draw_without_rendering()
    return figure


@pytest.mark.parametrize("name", [*DRAWN, *DRAWN_FAST])
def test_figure_has_labels_with_units_on_every_axis(name):
    for axes in drawn(name).axes:
        for label in (axes.get_xlabel(), axes.get_ylabel()):
            assert label in NO_UNIT or re.search(r"\(.+\)$|^dB re ", label), label


@pytest.mark.parametrize("kind", ["png", "svg"])
def test_figure_is_saved_in_the_suffix_format(kind, tmp_path):
    save(drawn("4.28"), tmp_path / "deep" / f"figure.{kind}")
    start = (tmp_path / "deep" / f"figure.{kind}").read_bytes()[:8]
    assert start == (b"\x89PNG\r\n\x1a\n" if kind == "png" else b"<?xml ve")


def curve(name, axes=0, line=0):
    found = drawn(name).axes[axes].lines[line]
    return np.asarray(found.get_xdata(), float), np.asarray(found.get_ydata(), float)


def test_high_values_are_below_the_upper_edge():
    (axes,) = drawn("4.34").axes
    assert max(line.get_ydata().max() for line in axes.lines[:2]) < 0.97 * axes.get_ylim()[1]


def test_focus_map_shows_focus_amplitude_in_micrometres():
    h = SMALL.responses(rig(35e-3), [FOCUS])
    x_mm, u_um = curve("3.8", axes=1)
    assert np.interp(FOCUS[0] * 1e3, x_mm, u_um) == pytest.approx(focus_amplitude(drive(h, 30.0), h) * 1e6, rel=3e-2)
    assert u_um.max() == pytest.approx(np.interp(FOCUS[0] * 1e3, x_mm, u_um), rel=2e-2)


def test_four_signals_peak_at_time_and_place_0():
    for column in range(2):
        for axes, unit in ((column, 1.0 / 250), (2 + column, 100.0 / 300)):
            x, u = curve("4.15", axes)
            assert x[np.argmax(u)] == pytest.approx(0.0, abs=2 * unit)


def test_prototype_stress_and_deflection_match_notes():
    """Science 1.8 states 178, 29.6 and 8.8 um at 1.1, 2 and 3 mm.

    Deflection and stress fall with the cube and the square of the thickness.
    """
    h_mm, deflection_um = curve("3.15", axes=1)
    found = np.exp(np.interp(np.log([1.1, 2.0, 3.0]), np.log(h_mm), np.log(deflection_um)))
    assert found == pytest.approx([178, 29.6, 8.8], rel=5e-3)
    _, stress_mpa = curve("3.15", axes=0)
    assert np.polyfit(np.log(h_mm), np.log(stress_mpa), 1)[0] == pytest.approx(-2.0, abs=1e-9)


def test_amplitude_at_twice_tau_is_86_and_98():
    for line, expected in ((0, 86.5), (1, 98.2)):
        t_ms, percent = curve("3.18", line=line)
        assert np.interp(7.0, t_ms, percent) == pytest.approx(expected, abs=0.1)


def test_fitted_decay_is_that_of_the_screen():
    t_ms, envelope = curve("4.11", line=1)
    assert -1 / np.polyfit(t_ms[:100], np.log(envelope[:100]), 1)[0] == pytest.approx(3.5, rel=0.1)


def test_one_discs_amplitude_grows_with_its_bandwidth():
    for line in (0, 1):
        _, amplitude_um = curve("3.11", line=line)
        assert amplitude_um[-1] > 1.5 * amplitude_um[0]


def test_sound_above_what_is_drawn_does_not_count_in_the_last_band():
    f = np.linspace(0.0, 500e3, 5001)
    figure = focus_figures.sound_spectra({"SDM": NoiseSpectrum(f, np.where(f < 125e3, 1e-9, 0.0))})
    levels_db = figure.axes[0].lines[0].get_ydata()
    assert levels_db == pytest.approx(levels_db[0])
    assert "dBA" in figure.axes[0].get_title()


def test_measured_losses_are_drawn_next_to_their_model():
    kinds, places = ("finger", "soft"), ("F", "P1")
    rows = [LossRow(kind, 1e-2, place, n, 0.1 * n) for kind in kinds for place in places for n in (1.0, 2.0)]
    modelled = focus.loss_over_force(rows).axes
    assert [len(axes.lines) for axes in modelled] == [2, 2]
    assert list(modelled[0].lines[0].get_ydata()) == [10.0, 20.0]
    (axes, *_) = focus.loss_over_force(rows, [LossRow("finger", 1e-2, "F", 1.5, 0.2)]).axes
    drawn = [line for line in axes.lines if line.get_fillstyle() == "none"]
    assert [(float(line.get_xdata()[0]), float(line.get_ydata()[0])) for line in drawn] == [(1.5, pytest.approx(20.0))]


def test_input_against_position_follows_force_share():
    velvet = Velvet()
    figure = electrovibration.input_against_position({"velvet": velvet, "grating": Grating(4e-3)}, voltage_v=80.0)
    for ax, share in zip(figure.axes, (velvet.force_share_along, Grating(4e-3).force_share), strict=True):
        carrier, envelope = ax.get_lines()
        x_m = envelope.get_xdata() * 1e-3
        np.testing.assert_allclose(envelope.get_ydata(), 80 * np.sqrt(share(x_m)), atol=1e-12)
        expected_v = envelope.get_ydata() * np.sin(2 * np.pi * 100 * x_m / 0.05)
        np.testing.assert_allclose(carrier.get_ydata(), expected_v, atol=1e-9)
    assert "carrier of 100 Hz" in figure.axes[-1].get_xlabel()


def test_force_against_area_is_the_force_of_each_law():
    figure = electrovibration.force_against_area(voltage_v=50.0)
    for line in figure.axes[0].get_lines():
        area_m2 = line.get_xdata()[-1] * 1e-4
        expected_n = electrostatic_force_n([50.0], rate_hz=1.0, skin=Skin(), area_m2=area_m2, law=line.get_label())
        assert line.get_ydata()[-1] == pytest.approx(float(expected_n[0]))


def test_force_over_area_is_one_curve_without_body_resistance():
    figure = electrovibration.force_for_inputs((1e-4, 2e-4))
    for ax in figure.axes[3:]:
        one, two = (line.get_ydata() for line in ax.get_lines())
        np.testing.assert_allclose(two, 2 * one, rtol=1e-12)


def test_ellipses_have_the_measured_axes():
    figure = electrovibration.contact_ellipse([Print(1.0, 0.012, 0.01), Print(2.0, 0.014, 0.011)])
    axes_mm = [(patch.width, patch.height) for patch in figure.axes[0].patches]
    np.testing.assert_allclose(axes_mm, [(10.0, 12.0), (11.0, 14.0)])
    one, two = (line.get_xydata()[0] for line in figure.axes[1].get_lines()[:2])
    np.testing.assert_allclose([one, two], [(1.0, np.pi / 4 * 1.2), (2.0, np.pi / 4 * 1.4 * 1.1)])


def test_more_curves_than_colours_are_all_drawn():
    prints = [Print(float(n), 0.01 + 1e-4 * n, 0.01) for n in range(1, 10)]
    assert len(electrovibration.contact_ellipse(prints).axes[0].patches) == 9
    forces = electrovibration.force_for_inputs([1e-5 * n for n in range(1, 10)]).axes[3]
    assert len(forces.get_lines()) == 9
