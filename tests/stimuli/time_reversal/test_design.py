"""The design guide and its sheets: what can be met, what cannot and why, and the command."""

import json
import math

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given, settings, strategies as st
from soak import SOAK

from tactometry.cli.design import command
from tactometry.errors import DeviceFailed, InvalidFile, InvalidParameter
from tactometry.stimuli.time_reversal.design.closed_forms import repetition_amplitude_ratio, resolution_m
from tactometry.stimuli.time_reversal.design.guide import (
    OFF,
    STRESS_MAX_PA,
    Design,
    Target,
    Transducers,
    amplitudes_m,
    contrast_over,
    recommend,
    thickness_for_m,
)
from tactometry.stimuli.time_reversal.design.thickness import SHEETS_M, best_sheet, sheets
from tactometry.stimuli.time_reversal.figures.theory import over_thickness
from tactometry.stimuli.time_reversal.filters import Band
from tactometry.stimuli.time_reversal.focusing.focusing import Emission, drive, focus_amplitude
from tactometry.stimuli.time_reversal.focusing.merit import contrast_whole_of, field, grid, resolution_per_focus_m
from tactometry.stimuli.time_reversal.focusing.pattern import Pattern, focus_samples, pattern_drive
from tactometry.stimuli.time_reversal.plate.dispersion import wavenumber_rad_per_m
from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN, BOROFLOAT_33, read_plate
from tactometry.stimuli.time_reversal.plate.statics import bending_stress_pa, deflection_m
from tactometry.stimuli.time_reversal.screen.attenuation import Attenuation
from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE, Screen
from tactometry.stimuli.time_reversal.screen.transducer import border

BAND, TAU_S = Band(20e3, 60e3), 3.5e-3
POINTS = [(0.121, 0.093), (0.2, 0.143), (0.071, 0.062)]


def simulated_over_laws(design, rng, n_foci=4):
    """Simulation over law, less 1, of amplitude, contrast and width: means over foci in the middle of the plate."""
    plate, patches, band = design.plate, design.transducers, design.band
    screen = Screen(plate, tuple(border(plate, patches.n, patches.side_m)), Attenuation(design.tau_s))
    emission = Emission(band, design.reversal_s, max(4 * band.f_max_hz, 100e3))
    sides = np.array([plate.length_m, plate.width_m])
    foci = [tuple(map(float, place)) for place in rng.uniform(0.2 * sides, 0.8 * sides, (n_foci, 2))]
    h = emission.responses(screen, foci)
    amplitudes, contrasts = [], []
    shortest = 1.2 * math.sqrt(2 * math.pi * emission.f_max_hz / plate.wave_constant_m2_per_s)
    points = grid(screen, *(int(side * shortest) + 20 for side in sides))
    for i in range(n_foci):
        signal = drive(h.at_point(i), patches.voltage_v)
        amplitudes.append(focus_amplitude(signal, h, i))
        u = field(screen, signal, signal.samples.shape[1] - 1, points, emission.f_max_hz)
        contrasts.append(contrast_whole_of(amplitudes[-1], u))
    return {
        "resolution": np.mean(resolution_per_focus_m(screen, foci, emission)) / design.resolution_m - 1,
        "contrast": np.mean(contrasts) / design.contrast - 1,
        "amplitude": np.mean(amplitudes) / design.amplitude_m - 1,
    }


def check_laws(thickness_m, side_m, band, n=32, tau_s=TAU_S, ratio=2.0, size_m=(0.297, 0.21)):
    plate = BOROFLOAT_33.plate(*size_m, thickness_m, "SSSS")
    design = Design(plate, Transducers(n, side_m), band, tau_s, ratio * tau_s)
    if not design.is_diffuse:
        return
    found = simulated_over_laws(design, np.random.default_rng())
    for name, (low, high) in OFF.items():
        assert low <= found[name] <= high, (name, found)


@pytest.mark.parametrize(
    ("thickness_m", "side_m", "band"),
    [
        pytest.param(0.3e-3, 10e-3, BAND, marks=pytest.mark.slow),
        pytest.param(0.5e-3, 10e-3, Band(36e3, 108e3), marks=pytest.mark.slow),
        (1.1e-3, 2e-3, Band(200.0, 60e3)),
        (1.1e-3, 10e-3, BAND),
        (2e-3, 10e-3, BAND),
        (4e-3, 10e-3, Band(1e3, 10e3)),
        (4e-3, 5e-3, Band(36e3, 108e3)),
    ],
)
def test_design_laws_match_simulation_at_chosen_points(thickness_m, side_m, band):
    """The ends of their domain, and where they are worst: patches longer than the wave, and few modes."""
    check_laws(thickness_m, side_m, band)


BANDS = (Band(1e3, 10e3), Band(200.0, 60e3), Band(1e3, 25e3), BAND, Band(36e3, 108e3), Band(20e3, 70e3))


@given(
    thickness_m=st.floats(0.3e-3, 4e-3) if SOAK else st.floats(0.7e-3, 4e-3),
    side_m=st.floats(2e-3, 10e-3),
    band=st.sampled_from(BANDS if SOAK else BANDS[:4]),
    n=st.sampled_from([8, 16, 32, 64]),
    tau_s=st.floats(1e-3, 8e-3),
    ratio=st.floats(0.5, 4.0),
    size_m=st.sampled_from([(0.297, 0.21), (0.21, 0.148)]),
)
@settings(max_examples=300 if SOAK else 12, deadline=None)
def test_design_laws_match_simulation_within_stated_error(thickness_m, side_m, band, n, tau_s, ratio, size_m):
    check_laws(thickness_m, side_m, band, n, tau_s, ratio, size_m)


def test_guide_notes_when_field_is_not_diffuse():
    slow = recommend(BOROFLOAT_33.plate(0.297, 0.21, 0.47e-3, "SSSS"), Transducers(), Band(1e3, 10e3), 0.3e-3, Target())
    assert slow.notes[-1].startswith("laws: in T and tau the waves cross the plate 0.38 times")
    few = recommend(BOROFLOAT_33.plate(0.1, 0.1, 4e-3, "SSSS"), Transducers(8), Band(1e3, 10e3), TAU_S, Target())
    assert "the band has 7 modes" in few.notes[-1]
    assert recommend(A4_SCREEN, Transducers(), BAND, TAU_S, Target()).design.is_diffuse


def test_long_patch_reduces_effective_number_of_modes():
    """Contrast of 36 to 108 kHz on 0.4 mm was 34 % above the simulation with the square of the mean of W^2."""
    plate = BOROFLOAT_33.plate(0.297, 0.21, 0.4e-3, "SSSS")
    design = Design(plate, Transducers(), Band(36e3, 108e3), TAU_S, 2 * TAU_S)
    f = np.linspace(36e3, 108e3, 300)
    half = wavenumber_rad_per_m(plate, f) * 10e-3 / 2
    angle = np.linspace(0, np.pi / 2, 400)
    low_pass = np.sinc(np.outer(half, np.cos(angle)) / np.pi) * np.sinc(np.outer(half, np.sin(angle)) / np.pi)
    squared, fourth = (np.trapezoid(np.mean(low_pass**power, axis=1), f) for power in (2, 4))
    assert design.reverberation.n_modes == pytest.approx(plate.modal_density_s * squared**2 / fourth, rel=0.02)


def test_contrast_of_a_fast_train_meets_the_simulation():
    target = Target(repetition_hz=1000.0)
    design = recommend(A4_SCREEN, Transducers(), BAND, TAU_S, target).design
    h = Emission(BAND, design.reversal_s, 200e3).responses(A4_PROTOTYPE, POINTS[:1])
    pattern = Pattern(1000.0, 20e-3)
    signal = pattern_drive(h, pattern, 30.0)
    last = int(focus_samples(pattern, 200e3, h.n_samples)[-1])
    u = field(A4_PROTOTYPE, signal, last, grid(A4_PROTOTYPE, 150, 106), 66e3)
    here = (np.array([POINTS[0][0]]), np.array([POINTS[0][1]]))
    amplitude = abs(field(A4_PROTOTYPE, signal, last, here, 66e3)[0, 0])
    assert design.contrast == pytest.approx(contrast_whole_of(amplitude, u), rel=0.25)


def test_guide_limits_patches_to_available_edge_length():
    wide = recommend(A4_SCREEN, Transducers(n=8, side_m=35e-3), Band(1e3, 25e3), TAU_S, Target(contrast=15.0))
    assert wide.design.transducers.n <= 24
    assert wide.unreachable[0].startswith("contrast: ")


def test_time_constants():
    alone = recommend(A4_SCREEN, Transducers(), BAND, TAU_S, Target())
    assert alone.design.reversal_s == 2 * TAU_S
    assert alone.design.repetition_s is None
    fast = recommend(A4_SCREEN, Transducers(), BAND, TAU_S, Target(repetition_hz=400.0))
    assert fast.design.reversal_s == fast.design.repetition_s == 2.5e-3
    assert "51%" in fast.notes[-2]


@given(st.floats(1e-3, 2e-2), st.floats(1.0, 60.0), st.floats(1e-7, 1e-4), st.floats(1.0, 3e4))
def test_every_wish_is_met_or_named_as_unreachable(resolution, contrast, amplitude, repetition):
    target = Target(resolution, contrast, amplitude, repetition)
    guide = recommend(A4_SCREEN, Transducers(), BAND, TAU_S, target)
    names = {reason.partition(":")[0] for reason in guide.unreachable}
    design = guide.design
    assert design.resolution_m <= resolution * (1 + 1e-6) or "resolution" in names
    assert design.contrast >= contrast * (1 - 1e-9) or "contrast" in names
    assert design.amplitude_m >= amplitude * (1 - 1e-9) or "amplitude" in names
    assert design.repetition_s >= 2 / design.band.width_hz or "repetition" in names


def test_contrast_beyond_modes_is_refused_with_reason():
    guide = recommend(A4_SCREEN, Transducers(), BAND, TAU_S, Target(contrast=40.0))
    assert len(guide.unreachable) == 1
    assert guide.unreachable[0].startswith("contrast: 40 is above sqrt(N) = 24.")
    assert "modes that the patches excite in the band" in guide.unreachable[0]


def test_thinner_glass_sharpens_as_advised():
    thin_m = thickness_for_m(A4_SCREEN, BAND, 6e-3)
    thin = BOROFLOAT_33.plate(0.297, 0.21, thin_m, "SSSS")
    assert resolution_m(thin, BAND) == pytest.approx(6e-3, rel=1e-9)


def test_guide_raises_band_to_reach_resolution():
    guide = recommend(A4_SCREEN, Transducers(side_m=5e-3), BAND, TAU_S, Target(resolution_m=7e-3))
    assert guide.unreachable == ()
    assert guide.design.resolution_m == pytest.approx(7e-3, rel=1e-6)
    assert guide.design.band.f_min_hz > BAND.f_min_hz


def test_trade_offs_rise_with_t_and_q():
    design = recommend(A4_SCREEN, Transducers(), BAND, TAU_S, Target()).design
    times = np.array([1e-3, 3e-3, 9e-3])
    assert np.all(np.diff(amplitudes_m(design, times)) > 0)
    contrast = contrast_over(design, np.array([1, 8, 64]), times)
    assert np.all(np.diff(contrast, axis=0) > 0)
    assert np.all(np.diff(contrast, axis=1) > 0)
    assert contrast.max() < math.sqrt(design.reverberation.n_modes)


def test_command_prints_the_design_as_json():
    result = CliRunner().invoke(command, ["--contrast", "15", "--repetition-hz", "100", "--json"])
    assert result.exit_code == 0, result.output
    record = json.loads(result.output)
    assert record["reversal_s"] == 0.007
    assert record["unreachable"] == []


def test_command_reports_law_errors_and_omissions():
    shown = CliRunner().invoke(command, [])
    assert shown.exit_code == 0, shown.output
    for said in ("simulation to these laws: resolution -15% to +10%, contrast -25%", "moment per volt", "> 150 um"):
        assert said in shown.output
    record = json.loads(CliRunner().invoke(command, ["--json"]).output)
    assert record["simulation_over_law"] == {name: list(ends) for name, ends in OFF.items()}
    assert [sheet["bends_linearly"] for sheet in record["thicknesses"]][:6] == [False] * 5 + [True]


def test_command_ends_with_1_and_says_why():
    result = CliRunner().invoke(command, ["--contrast", "400"], standalone_mode=False)
    assert result.return_value == 1
    assert "not reached: contrast: 400 is above sqrt(N)" in result.output


def test_command_refuses_a_figure_it_cannot_write(tmp_path):
    unknown = CliRunner().invoke(command, ["--figure", str(tmp_path / "design.doc")])
    assert isinstance(unknown.exception, InvalidParameter)
    assert "expected a name that ends in .png, .pdf, .svg" in str(unknown.exception)
    (tmp_path / "file").write_text("")
    below = CliRunner().invoke(command, ["--figure", str(tmp_path / "file" / "design.png")])
    assert isinstance(below.exception, DeviceFailed)


def test_command_reads_a_plate_and_draws_the_trade_offs(tmp_path):
    plate = tmp_path / "plate.toml"
    plate.write_text(
        'glass = "Borofloat 33"\nlength_m = 0.297\nwidth_m = "210 mm"\nthickness_m = "2 mm"\nboundary = "FFFF"\n'
    )
    figure = tmp_path / "design.png"
    result = CliRunner().invoke(command, ["--plate", str(plate), "--figure", str(figure)])
    assert result.exit_code == 0, result.output
    assert figure.read_bytes().startswith(b"\x89PNG")
    assert read_plate(plate) == BOROFLOAT_33.plate(0.297, 0.21, 2e-3, "FFFF")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("length_m = [", "plate.toml: "),
        ('glass = "Borofloat"', "glass: found 'Borofloat', expected one of Borofloat 33"),
        ('glass = "D263T"\nlenght_m = 0.3', "did you mean 'length_m'?"),
        (
            'glass = "D263T"\nlength_m = 0.3\nwidth_m = 0.2\nthickness_m = -1\nboundary = "SSSS"',
            "thickness_m: found -1",
        ),
    ],
)
def test_broken_plate_files_are_named(tmp_path, content, message):
    path = tmp_path / "plate.toml"
    path.write_text(content)
    with pytest.raises(InvalidFile) as caught:
        read_plate(path)
    assert message in str(caught.value)


def test_overlapping_drives_reduce_design_amplitude():
    alone = Design(A4_SCREEN, Transducers(), Band(20e3, 60e3), 3e-3, 6e-3)
    train = Design(A4_SCREEN, Transducers(), Band(20e3, 60e3), 3e-3, 6e-3, repetition_s=3e-3)
    times = np.array([1e-3, 3e-3, 6e-3, 12e-3])
    penalty = [repetition_amplitude_ratio(float(t), 3e-3, 3e-3) for t in times]
    assert penalty[:2] == [1.0, 1.0]
    assert penalty[3] < penalty[2] < 0.9
    np.testing.assert_allclose(amplitudes_m(train, times), amplitudes_m(alone, times) * penalty, rtol=1e-12)


SMALL = Transducers(side_m=5e-3)


def among(target, plate=A4_SCREEN, transducers=SMALL, thicknesses_m=SHEETS_M):
    return sheets(plate, transducers, BAND, TAU_S, target, thicknesses_m)


def test_best_sheet_keeps_plate_that_meets_target():
    assert best_sheet(among(Target(contrast=20.0)), 1.1e-3).thickness_m == 1.1e-3


def test_high_contrast_target_gets_nearest_thinner_sheet():
    found = among(Target(contrast=28.0))
    best = best_sheet(found, 1.1e-3)
    assert best.thickness_m == 0.9e-3
    assert best.unreachable == ()
    assert best.guide.design.contrast >= 28.0
    assert recommend(A4_SCREEN, SMALL, BAND, TAU_S, Target(contrast=28.0)).unreachable


def test_overstressed_plate_gets_nearest_thicker_sheet():
    thin = BOROFLOAT_33.plate(0.297, 0.21, 0.3e-3, "SSSS")
    best = best_sheet(among(Target(), thin), 0.3e-3)
    assert best.thickness_m == 0.5e-3
    assert best.stress_pa <= STRESS_MAX_PA < among(Target(), thin)[0].stress_pa


def test_stress_and_deflection_of_a_sheet_are_those_of_the_plate():
    for sheet in among(Target(), thicknesses_m=(0.5e-3, 3e-3)):
        plate = BOROFLOAT_33.plate(0.297, 0.21, sheet.thickness_m, "SSSS")
        assert sheet.stress_pa == pytest.approx(bending_stress_pa(plate, 2.0, 10e-3), rel=1e-12)
        bent_m = deflection_m(plate, 2.0, (0.1485, 0.105), 0.1485, 0.105)[0]
        assert sheet.deflection_m == pytest.approx(bent_m, rel=1e-12)


def test_best_sheet_lists_unreachable_targets():
    found = among(Target(resolution_m=6e-3, amplitude_m=10e-6), transducers=Transducers())
    best = best_sheet(found, 1.1e-3)
    assert len(best.unreachable) == min(len(each.unreachable) for each in found) == 1
    assert best.unreachable[0].startswith("resolution: 6 mm")


def test_the_command_lists_every_thickness():
    result = CliRunner().invoke(command, ["--patch-m", "5e-3", "--contrast", "28", "--json"])
    assert result.exit_code == 0, result.output
    record = json.loads(result.output)
    assert record["thickness_m"] == 0.9e-3
    assert [each["thickness_m"] for each in record["thicknesses"]] == sorted(SHEETS_M)
    only = ["--patch-m", "5e-3", "--contrast", "28", "--thickness-m", "1.1e-3"]
    assert CliRunner().invoke(command, only, standalone_mode=False).return_value == 1


def test_the_figure_marks_the_recommended_sheet():
    found = among(Target(contrast=28.0), thicknesses_m=(0.7e-3, 0.9e-3))
    figure = over_thickness(found, best_sheet(found, 1.1e-3))
    ring = figure.axes[0].lines[len(found)]
    assert ring.get_xdata()[0] == pytest.approx(0.9)
