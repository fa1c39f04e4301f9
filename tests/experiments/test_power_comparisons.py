"""Power of effects on the PSE, the JND and exponents."""

from dataclasses import replace

import pytest
from scipy.special import ndtr, ndtri
from study_texts import TUTORIAL, changed

from tactometry.analysis.reading.trials import used_rows
from tactometry.errors import InvalidParameter
from tactometry.experiments.power.design import Case, PowerDesign
from tactometry.experiments.power.effect import parse_effect
from tactometry.experiments.power.level_map import LevelMap, with_levels
from tactometry.experiments.power.replicate import studied
from tactometry.experiments.power.scenario import check_design, experiment_of, maps_of
from tactometry.experiments.study.study_file import load, parse

EXACT = {
    'kind = "yes_no"\ncatch_rate = 0.2': 'kind = "comparison"\nstandard_level = 30',
    "levels = [22, 28, 34, 40]                       # dB re 1 V peak\nrepeats = 4": (
        "levels = [24, 27, 30, 33, 36]\nrepeats = 150"
    ),
    "[observer]\nbetween_sd_db = 4.0": (
        '[observer]\nkind = "psychometric"\nthreshold = 10.0\nwidth = 8.0\nlapse_rate = 0.0\nbetween_sd_db = 0.0'
    ),
    "condition_sd_db = 3.5\n": "",
    "criterion_sd = 0.3": "# criterion_sd",
    "exponent_cv = 0.2": "exponent_cv = 0.0",
}
JND = ndtri(0.75) * 8 / (2 * ndtri(0.95))


def design(effect, text, **options):
    made = PowerDesign(text.encode(), "study", parse_effect(effect), (3,), seed=4, **options)
    return replace(made, dependent=check_design(made))


@pytest.fixture(scope="module")
def exact():
    return changed(TUTORIAL, EXACT)


@pytest.mark.parametrize(
    ("effect", "pses", "jnds"),
    [
        ("frequency_hz: 2 dB PSE", (30, 32), (JND, JND)),
        ("frequency_hz: -2 dB PSE", (32, 30), (JND, JND)),
        ("frequency_hz: 60 % JND", (30, 30), (JND, 1.6 * JND)),
        ("frequency_hz: 60 = 25 % JND", (30, 30), (1.25 * JND, JND)),
    ],
)
def test_simulated_answers_have_stated_effect(exact, effect, pses, jnds):
    asked = design(effect, exact)
    _, trials = studied(asked, asked.cases[0], 0)
    used = used_rows(trials)
    for frequency, pse, jnd in zip((60, 240), pses, jnds, strict=True):
        rows = used[used["frequency_hz"].astype(float) == frequency]
        rate = rows["response"].astype(float).groupby(rows["level"].astype(float)).mean()
        assert sorted(rate.index) == [24, 27, 30, 33, 36]
        expected = ndtr((rate.index.to_numpy() - pse) / jnd * ndtri(0.75)).tolist()
        assert rate.tolist() == pytest.approx(expected, abs=4.5 * 0.5 / 450**0.5)


def test_effects_are_tested_on_their_own_value():
    text = load("texture-discrimination")[1].decode()
    assert design("period_m: 20 % JND", text).dependent == "jnd"
    assert design("period_m: 1 dB PSE", text).dependent == "pse"


@pytest.mark.parametrize("effect", ["period_m: 20 % JND", "period_m: 1 dB PSE"])
def test_played_levels_do_not_exceed_stated_levels(effect):
    asked = design(effect, load("texture-discrimination")[1].decode())
    for case in asked.cases:
        played = [cell.procedure.rule.bounds for cell in experiment_of(asked, case).cells.values()]
        assert max(high for _, high in played) == pytest.approx(46.0)


def test_exponents_differ_by_the_stated_share():
    asked = design("period_m: 44 % exponent", load("grating-roughness")[1].decode())
    first, *_, last = maps_of(asked, Case(None, True)).values()
    none_first, *_, none_last = maps_of(asked, Case(None, False)).values()
    ratio = (first.factor / none_first.factor) / (last.factor / none_last.factor)
    assert ratio == pytest.approx(1.44)


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        (
            {'counterbalance = ["period_m"]': "", "[observer]": '[plan]\ninterleave = ["period_m"]\n[observer]'},
            "is interleaved",
        ),
        ({"levels = [31, 34, 37, 39, 41, 43, 46]": 'shape = "weibull"'}, "shape"),
    ],
)
def test_levels_that_cannot_be_mapped_are_refused(changes, why):
    with pytest.raises(InvalidParameter, match=why):
        design("period_m: 20 % JND", changed(load("texture-discrimination")[1].decode(), changes))


QUEST = {"kind": "quest", "start": 30.0, "start_sd": 4.0, "low": 10.0, "high": 50.0, "step": 1.0}


def test_level_map_converts_every_number_of_the_procedure():
    study = replace(parse(load("tutorial")[1], "t"), procedure=QUEST)
    (tables,) = with_levels(study, "frequency_hz", {"60": LevelMap(30.0, 2.0, 2.0)}).variants["frequency_hz"].values()
    expected = {"start": 29.0, "start_sd": 2.0, "low": 19.0, "high": 39.0, "step": 0.5, "decade": 10.0}
    assert tables["procedure"] == expected
