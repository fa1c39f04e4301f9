"""Power of effects on scores, the PSE, the JND and exponents."""

from dataclasses import replace

import numpy as np
import pytest
from command_line import output, refused
from scipy.special import ndtr, ndtri
from study_texts import TUTORIAL, changed as replaced

from tactometry.analysis.outcomes.ratings import ratings
from tactometry.analysis.reading.trials import used_rows
from tactometry.errors import InvalidParameter
from tactometry.experiments.power.design import Case, PowerDesign
from tactometry.experiments.power.effect import parse_effect
from tactometry.experiments.power.level_map import LevelMap, with_levels
from tactometry.experiments.power.replicate import replicate, seed_of, simulated, studied
from tactometry.experiments.power.scenario import check_design, experiment_of, growth, maps_of
from tactometry.experiments.study.study_file import load, parse

PATTERNS = "time-reversal-patterns"


def design(effect, study="hybrid-button", dependent="", content=None, participants=(4,)):
    content = content or load(study)[1]
    made = PowerDesign(content, study, parse_effect(effect), participants, seed=5, dependent=dependent)
    return replace(made, dependent=check_design(made))


def changed(study, *lines):
    return replaced(load(study)[1].decode(), dict(lines)).encode()


def test_first_dimension_is_the_default():
    assert design("feedback: 1 points").dependent == "realism"
    assert design("pattern: P3 = 1 points", PATTERNS, "ATT").dependent == "ATT"


@pytest.mark.parametrize("effect", ["pattern: P3 = 1 points", "frequency: 1 points"])
def test_zero_effect_has_equal_attitudes_and_sensations(effect):
    planned = design(effect, PATTERNS, "HQ")
    experiment = experiment_of(planned, planned.cases[1])
    observer = experiment.study.observer
    assert {value for of in observer["raters"]["effects"]["pattern"].values() for value in of.values()} == {0.0}
    shifts_db = observer["people"]["effects_db"]["pattern"]
    felt_db = [growth(experiment, cell)[0] + shifts_db[key[0][1]] for key, cell in experiment.cells.items()]
    assert np.ptp(felt_db) < 1e-9


SPREAD = "attitude_sd = 0.15\ndimension_sd = 0.15\nstimulus_sd = 0.2"
NONE = "liking = 0\nattitude_sd = 0\ndimension_sd = 0\nstimulus_sd = 0\nacquiescence_sd = 0\nextremity_cv = 0"


def test_scores_differ_by_the_effect():
    """Participants differ only in item noise, so the standard error is known."""
    planned = design("frequency: 1 points", PATTERNS, "HQ", changed(PATTERNS, (SPREAD, NONE)), participants=(12,))
    for case, stated in zip(planned.cases, (1.0, 0.0), strict=True):
        (row,) = replicate(planned, case, 0)
        error = 3 * 0.35 * (2 / (12 * 14 * 3)) ** 0.5  # 14 items and three patterns on either side, 3 points a unit
        rounding = (2 * (1 / 12) / (12 * 14 * 3)) ** 0.5  # of an answer to the steps of the scale
        assert row.found == pytest.approx(stated, abs=3.9 * np.hypot(error, rounding))


@pytest.mark.parametrize(
    ("study", "effect", "dependent", "table_of"),
    [
        ("hybrid-button", "feedback: 1 points", "realism", lambda form: form.outcomes["realism"].effects),
        (PATTERNS, "envelope: sinc = 1 points", "PQ", lambda form: form.crossed[form.crossed["dimension"] == "PQ"]),
    ],
)
def test_p_value_equals_that_of_the_analysis(study, effect, dependent, table_of):
    planned = design(effect, study, dependent)
    experiment = experiment_of(planned, planned.cases[0])
    form = next(
        form
        for form in ratings(simulated(planned, experiment, seed_of(planned.seed, 0)))
        if dependent in form.form.dimensions
    )
    table = table_of(form)
    (row,) = replicate(planned, planned.cases[0], 0)
    assert row.p == table.loc[table["Source"] == planned.effect.factor, "p_CM_corr"].iloc[0]


def test_patterns_are_tested_against_the_single_focus():
    planned = design("pattern: P3 = 1 points", PATTERNS, "ATT")
    (form,) = ratings(simulated(planned, experiment_of(planned, planned.cases[0]), seed_of(planned.seed, 0)))
    (row,) = replicate(planned, planned.cases[0], 0)
    assert row.p == form.against.loc[form.against["dimension"] == "ATT", "p_corr"].min()


def test_effect_on_score_needs_attitudes_of_participants(capsys, tmp_path):
    lines = ("[observer.raters]", "[texts]\n#"), ("effects.feedback.both = { realism = 0.2 }", "")
    (tmp_path / "study.toml").write_bytes(changed("hybrid-button", *lines))
    words = ("--effect", "feedback: 1 points", "--participants", "3", "--seed", "1", "--most", "1")
    said = refused(capsys, "power", tmp_path / "study.toml", *words)
    assert "observer.raters: found none, expected the table [observer.raters], as an effect on a score" in said


def test_page_states_the_attitudes_of_the_effect(capsys, tmp_path):
    words = ["power", "hybrid-button", "--effect", "feedback: 1 points", "--participants", "3", "--seed", "1"]
    said = output(capsys, *words, "--most", "1", "--out", tmp_path)
    assert "realism of simulated participants, seed 1" in said
    page = (tmp_path / "power.html").read_text("utf-8")
    assert "attitude with the effect (-1 to 1)" in page
    assert "<td>electrovibration</td><td>0.00</td><td>0.00</td><td>0.00</td>" in page


# --- effects on the PSE, the JND and exponents

TEXTURE = "texture-discrimination"
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


@pytest.fixture(scope="module")
def exact():
    return replaced(TUTORIAL, EXACT).encode()


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
    planned = design(effect, content=exact, participants=(3,))
    _, trials = studied(planned, planned.cases[0], 0)
    used = used_rows(trials)
    for frequency, pse, jnd in zip((60, 240), pses, jnds, strict=True):
        rows = used[used["frequency_hz"].astype(float) == frequency]
        rate = rows["response"].astype(float).groupby(rows["level"].astype(float)).mean()
        assert sorted(rate.index) == [24, 27, 30, 33, 36]
        expected = ndtr((rate.index.to_numpy() - pse) / jnd * ndtri(0.75)).tolist()
        assert rate.tolist() == pytest.approx(expected, abs=4.5 * 0.5 / 450**0.5)


def test_effects_are_tested_on_their_own_value():
    assert design("period_m: 20 % JND", TEXTURE).dependent == "jnd"
    assert design("period_m: 1 dB PSE", TEXTURE).dependent == "pse"


@pytest.mark.parametrize("effect", ["period_m: 20 % JND", "period_m: 1 dB PSE"])
def test_played_levels_do_not_exceed_stated_levels(effect):
    planned = design(effect, TEXTURE)
    for case in planned.cases:
        played = [cell.procedure.rule.bounds for cell in experiment_of(planned, case).cells.values()]
        assert max(high for _, high in played) == pytest.approx(46.0)


def test_exponents_differ_by_the_stated_share():
    planned = design("period_m: 44 % exponent", "grating-roughness")
    first, *_, last = maps_of(planned, Case(None, True)).values()
    none_first, *_, none_last = maps_of(planned, Case(None, False)).values()
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
        design("period_m: 20 % JND", content=changed(TEXTURE, *changes.items()))


QUEST = {"kind": "quest", "start": 30.0, "start_sd": 4.0, "low": 10.0, "high": 50.0, "step": 1.0}


def test_level_map_converts_every_number_of_the_procedure():
    study = replace(parse(load("tutorial")[1], "t"), procedure=QUEST)
    (tables,) = with_levels(study, "frequency_hz", {"60": LevelMap(30.0, 2.0, 2.0)}).variants["frequency_hz"].values()
    expected = {"start": 29.0, "start_sd": 2.0, "low": 19.0, "high": 39.0, "step": 0.5, "decade": 10.0}
    assert tables["procedure"] == expected
