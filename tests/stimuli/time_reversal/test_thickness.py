"""The design guide's thickness: the nearest sheet that meets the target, with what each would give."""

import json

import pytest
from click.testing import CliRunner

from tactometry.cli.design import command
from tactometry.stimuli.time_reversal.design.guide import STRESS_MAX_PA, Target, Transducers, recommend
from tactometry.stimuli.time_reversal.design.thickness import SHEETS_M, best_sheet, sheets
from tactometry.stimuli.time_reversal.figures.theory import over_thickness
from tactometry.stimuli.time_reversal.filters import Band
from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN, BOROFLOAT_33
from tactometry.stimuli.time_reversal.plate.statics import bending_stress_pa, deflection_m

BAND, TAU_S, SMALL = Band(20e3, 60e3), 3.5e-3, Transducers(side_m=5e-3)


def among(target, plate=A4_SCREEN, transducers=SMALL, thicknesses_m=SHEETS_M):
    return sheets(plate, transducers, BAND, TAU_S, target, thicknesses_m)


def test_best_sheet_keeps_plate_that_meets_target():
    assert best_sheet(among(Target(contrast=20.0)), 1.1e-3).thickness_m == 1.1e-3


def test_more_contrast_than_the_plate_holds_gets_the_nearest_thinner_sheet():
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
