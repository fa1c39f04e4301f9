"""The design guide: it meets what can be met, says what cannot and why, and the command shows it."""

import json
import math

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

from tactometry.cli.design import command
from tactometry.errors import DeviceFailed, InvalidFile, InvalidParameter
from tactometry.stimuli.time_reversal.attenuation import Attenuation
from tactometry.stimuli.time_reversal.closed_forms import resolution_m
from tactometry.stimuli.time_reversal.design import (
    Design,
    Target,
    Transducers,
    amplitude_over_reversal,
    contrast_over,
    recommend,
    thickness_for_m,
)
from tactometry.stimuli.time_reversal.field import field, grid
from tactometry.stimuli.time_reversal.finger import Emission
from tactometry.stimuli.time_reversal.focusing import drive, focus_amplitude
from tactometry.stimuli.time_reversal.glass import A4_SCREEN, BOROFLOAT_33
from tactometry.stimuli.time_reversal.merit import contrast_whole_of
from tactometry.stimuli.time_reversal.pattern import Pattern, focus_samples, pattern_drive
from tactometry.stimuli.time_reversal.plate_file import read_plate
from tactometry.stimuli.time_reversal.screen import A4_PROTOTYPE, Screen
from tactometry.stimuli.time_reversal.spectrum import Band
from tactometry.stimuli.time_reversal.transducer import border
from tactometry.stimuli.time_reversal.variability import resolution_per_focus_m

BAND, TAU_S = Band(20e3, 60e3), 3.5e-3
POINTS = [(0.121, 0.093), (0.2, 0.143), (0.071, 0.062)]


@pytest.mark.parametrize("band", [Band(200.0, 60e3), Band(20e3, 60e3), Band(1e3, 25e3)])
def test_amplitude_law_meets_the_simulation_within_15_percent(band):
    predicted = Design(A4_SCREEN, Transducers(), band, TAU_S, 2 * TAU_S).amplitude_m
    h = Emission(band, 2 * TAU_S, 200e3).responses(A4_PROTOTYPE, POINTS)
    simulated = np.mean([focus_amplitude(drive(h.at_point(i), 30.0), h, i) for i in range(3)])
    assert predicted == pytest.approx(simulated, rel=0.15)


@pytest.mark.parametrize(("side_m", "band"), [(10e-3, Band(36e3, 108e3)), (10e-3, BAND), (2e-3, BAND)])
def test_contrast_and_resolution_meet_the_simulation(side_m, band):
    """Contrast scatters by 2 % over places and lies up to 14 % below the law; widths by 1 % and 5 %."""
    design = Design(A4_SCREEN, Transducers(side_m=side_m), band, TAU_S, 2 * TAU_S)
    screen = Screen(A4_SCREEN, tuple(border(A4_SCREEN, 32, side_m)), Attenuation(TAU_S))
    emission, f_max = Emission(band, 2 * TAU_S, 300e3), band.f_max_hz * 1.1
    h = emission.responses(screen, POINTS[:1])
    signal = drive(h, 30.0)
    u = field(screen, signal, signal.samples.shape[1] - 1, grid(screen, 150, 106), f_max)
    assert design.contrast == pytest.approx(contrast_whole_of(focus_amplitude(signal, h), u), rel=0.2)
    assert design.resolution_m == pytest.approx(np.mean(resolution_per_focus_m(screen, POINTS, emission)), rel=0.08)


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


def test_more_patches_than_the_edges_hold_are_not_promised():
    wide = recommend(A4_SCREEN, Transducers(n=8, side_m=35e-3), Band(1e3, 25e3), TAU_S, Target(contrast=15.0))
    assert wide.design.transducers.n <= 24
    assert wide.unreachable[0].startswith("contrast: ")


def test_time_constants():
    alone = recommend(A4_SCREEN, Transducers(), BAND, TAU_S, Target())
    assert alone.design.reversal_s == 2 * TAU_S
    assert alone.repetition_s is None
    fast = recommend(A4_SCREEN, Transducers(), BAND, TAU_S, Target(repetition_hz=400.0))
    assert fast.design.reversal_s == fast.repetition_s == 2.5e-3
    assert "51%" in fast.notes[-2]


@given(
    st.floats(1e-3, 2e-2),
    st.floats(1.0, 60.0),
    st.floats(1e-7, 1e-4),
    st.floats(1.0, 3e4),
)
def test_every_wish_is_met_or_named_as_unreachable(resolution, contrast, amplitude, repetition):
    target = Target(resolution, contrast, amplitude, repetition)
    guide = recommend(A4_SCREEN, Transducers(), BAND, TAU_S, target)
    names = {reason.partition(":")[0] for reason in guide.unreachable}
    design = guide.design
    assert design.resolution_m <= resolution * (1 + 1e-6) or "resolution" in names
    assert design.contrast >= contrast * (1 - 1e-9) or "contrast" in names
    assert design.amplitude_m >= amplitude * (1 - 1e-9) or "amplitude" in names
    assert guide.repetition_s >= 2 / design.band.width_hz or "repetition" in names


def test_contrast_beyond_the_modes_is_refused_with_the_reason():
    guide = recommend(A4_SCREEN, Transducers(), BAND, TAU_S, Target(contrast=40.0))
    assert len(guide.unreachable) == 1
    assert guide.unreachable[0].startswith("contrast: 40 is above sqrt(N) = 24.")
    assert "modes that the patches excite in the band" in guide.unreachable[0]


def test_thinner_glass_sharpens_as_advised():
    thin_m = thickness_for_m(A4_SCREEN, BAND, 6e-3)
    thin = BOROFLOAT_33.plate(0.297, 0.21, thin_m, "SSSS")
    assert resolution_m(thin, BAND) == pytest.approx(6e-3, rel=1e-9)


def test_band_is_moved_up_for_resolution_while_the_wave_is_longer_than_a_patch():
    guide = recommend(A4_SCREEN, Transducers(side_m=5e-3), BAND, TAU_S, Target(resolution_m=7e-3))
    assert guide.unreachable == ()
    assert guide.design.resolution_m == pytest.approx(7e-3, rel=1e-6)
    assert guide.design.band.f_min_hz > BAND.f_min_hz


def test_trade_offs_rise_with_t_and_q():
    design = recommend(A4_SCREEN, Transducers(), BAND, TAU_S, Target()).design
    times = np.array([1e-3, 3e-3, 9e-3])
    assert np.all(np.diff(amplitude_over_reversal(design, times)) > 0)
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


def test_command_ends_with_1_and_says_why():
    result = CliRunner().invoke(command, ["--contrast", "400"])
    assert result.exit_code == 1
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


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Target(contrast=-1.0), "Target.contrast: found -1.0"),
        (
            lambda: recommend(A4_SCREEN, Transducers(5000, 30e-3), BAND, TAU_S, Target()),
            "Transducers: found 5000 patches of 30 mm, expected at most 28",
        ),
        (
            lambda: recommend(A4_SCREEN, Transducers(1, 0.5), BAND, TAU_S, Target()),
            "Transducers: found 1 patches of 500 mm, expected at most 0",
        ),
        (lambda: Transducers(0), "Transducers.n: found 0, expected a finite number above 0"),
        (lambda: recommend(A4_SCREEN, Transducers(), BAND, 0.0, Target()), "recommend.tau_s: found 0.0"),
    ],
)
def test_bad_input_is_refused_in_one_sentence(call, message):
    with pytest.raises(InvalidParameter) as caught:
        call()
    assert str(caught.value).startswith(message)
