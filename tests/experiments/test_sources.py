"""Parameters with their sources, and what a study rests on."""

import json
import math
from dataclasses import fields, is_dataclass, replace
from inspect import getsource, ismodule

import pytest
from command_line import output, refused

from tactometry.experiments.reference import sources as page
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.felt_scene import FeltScene
from tactometry.experiments.study.influence import groups, parameters, sources_of
from tactometry.experiments.study.study_file import load, shipped
from tactometry.stimuli.electrovibration.skin.skin import Skin
from tactometry.stimuli.time_reversal.stimulus.setup import Setup

GROUPS = groups()
NUMBERS = [one for one in parameters() if not isinstance(one.value, str)]
CHOICES = [one for one in parameters() if one.status == "choice"]
OFF = {"corneum_resistivity_ohm_m", "gap_m", "body_resistance_ohm"}
"""Layers of the skin that effects of a scene add."""


def study(name):
    return wire(load(name)[0], name)


@pytest.fixture(scope="module")
def electrovibration():
    return sources_of(study("electrovibration-threshold"))


@pytest.mark.parametrize("group", GROUPS, ids=lambda group: group.name)
def test_each_value_is_the_default_in_the_code(group):
    assert {one.key: group.default(one) for one in group.parameters} == {one.key: one.value for one in group.parameters}


@pytest.mark.parametrize("one", NUMBERS, ids=lambda one: one.key)
def test_each_range_contains_its_default_and_is_wide_without_a_source(one):
    assert one.low <= one.value <= one.high
    assert not one.is_unverified or one.high > one.low
    assert one.source
    assert one.read


@pytest.mark.parametrize("one", CHOICES, ids=lambda one: one.key)
def test_choice_has_nothing_to_verify(one):
    assert not one.is_unverified
    assert one.source.startswith("choice: ")


def test_at_most_16_defaults_are_unverified():
    assert sum(one.is_unverified for one in parameters()) <= 16


def numbers_of(thing):
    return {one.name for one in fields(thing) if isinstance(getattr(thing, one.name), float)}


@pytest.mark.parametrize("name", shipped())
def test_each_number_of_a_felt_scene_has_a_source(name):
    rows = {kind: {one.path[0] for one in group.parameters} for group in GROUPS for kind in group.classes}
    cells = study(name).cells.values()
    for scene in (cell.sensation.scene for cell in cells if isinstance(cell.sensation, FeltScene)):
        surfaces = [scene.surface, *(part for part in vars(scene.surface).values() if is_dataclass(part))]
        held = [part for each in surfaces for part in vars(each).values() if isinstance(part, Skin | Setup)]
        for part in (*scene.effects, *held):
            assert numbers_of(part) - OFF <= rows.get(type(part), set()), type(part)


def test_code_of_the_table_calls_no_default_unverified():
    for group in GROUPS:
        code = group.target if group.classes or ismodule(group.target) else type(group.target)
        assert "unverified default" not in getsource(code), group.name


def test_scales_change_the_level_by_their_ratio(electrovibration):
    found = {one.parameter.key: one for one in electrovibration.influences}
    signs = {"contact_area.area_at_1n_m2": 1, "friction.coefficient": 1, "sensitivity.reference_m": -1}
    for key, of_level in signs.items():
        one = found[key]
        at_low_db = 20 * of_level * math.log10(one.parameter.low / one.parameter.value)
        assert one.at_low_db == pytest.approx(at_low_db, abs=1e-6), key
    octaves = math.log2(30.0 / 3.0)
    assert found["channels.NP_I_DB_PER_OCTAVE"].at_high_db == pytest.approx(4 * octaves, abs=1e-5)


def test_area_exponent_changes_nothing_at_1_n():
    found = {one.parameter.key: one for one in sources_of(study("tutorial")).influences}
    assert (found["contact_area.exponent"].at_low_db, found["contact_area.exponent"].at_high_db) == (0.0, 0.0)


def test_three_largest_changes_come_first_and_are_marked(electrovibration):
    sizes = [one.largest_db for one in electrovibration.influences]
    assert sizes == sorted(sizes, reverse=True)
    assert [one.is_marked for one in electrovibration.influences] == [True] * 3 + [False] * (len(sizes) - 3)
    assert electrovibration.is_threshold


def test_constants_are_as_before_after_they_were_varied(electrovibration):
    assert sources_of(study("electrovibration-threshold")) == electrovibration


def test_values_of_the_study_are_the_starting_point():
    tutorial, _ = load("tutorial")
    stated = replace(tutorial, sensation={"reference_m": 2e-7})
    found = {one.parameter.key: one for one in sources_of(wire(stated, "tutorial")).influences}
    assert found["sensitivity.reference_m"].set_to == 2e-7
    assert found["sensitivity.reference_m"].at_low_db == pytest.approx(20 * math.log10(20), abs=1e-9)


def test_command_prints_the_same_parameters_as_json(capsys):
    said = output(capsys, "sources", "tutorial")
    record = json.loads(output(capsys, "sources", "tutorial", "--json"))
    assert said.startswith("tutorial at frequency_hz 60: ")
    assert [one["key"] for one in record["parameters"] if one["key"] not in said] == []
    assert next(one["key"] for one in record["parameters"] if one["is_marked"]) == "force_law.law"


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("no-such-study", "no-such-study: found no such file or built-in study"),
        ("force-loss", "STUDY: found 'force-loss', which has no simulated participants"),
    ],
)
def test_command_refuses_studies_without_simulated_sensation(name, words, capsys):
    assert words in refused(capsys, "sources", name)


def test_page_of_sources_is_up_to_date():
    assert page.PAGE.read_text(encoding="utf-8") == page.text(), "run make keys"
