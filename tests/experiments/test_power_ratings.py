"""Power of questionnaires: effects on a score and their test."""

from dataclasses import replace

import numpy as np
import pytest
from command_line import call, output

from tactometry.analysis.outcomes.ratings import ratings
from tactometry.experiments.power.design import PowerDesign
from tactometry.experiments.power.effect import parse_effect
from tactometry.experiments.power.replicate import replicate, seed_of, simulated
from tactometry.experiments.power.scenario import check_design, experiment_of, growth
from tactometry.experiments.study.study_file import load

PATTERNS = "time-reversal-patterns"


def design(effect, study="hybrid-button", dependent="", content=None, **changes):
    content = load(study)[1] if content is None else content
    made = PowerDesign(content, study, parse_effect(effect), **{"participants": (4,), "seed": 5, **changes})
    made = replace(made, dependent=dependent)
    return replace(made, dependent=check_design(made))


def changed(study, *lines):
    """Return a study with lines replaced."""
    content = load(study)[1].decode()
    for old, new in lines:
        assert old in content
        content = content.replace(old, new)
    return content.encode()


def test_first_dimension_is_the_default():
    assert design("feedback: 1 points").dependent == "realism"
    assert design("pattern: P3 = 1 points", PATTERNS, "ATT").dependent == "ATT"


@pytest.mark.parametrize("effect", ["pattern: P3 = 1 points", "frequency: 1 points"])
def test_zero_effect_has_equal_attitudes_and_sensations(effect):
    asked = design(effect, PATTERNS, "HQ")
    experiment = experiment_of(asked, asked.cases[1])
    observer = experiment.study.observer
    assert {value for of in observer["raters"]["effects"]["pattern"].values() for value in of.values()} == {0.0}
    shifts_db = observer["people"]["effects_db"]["pattern"]
    felt_db = [growth(experiment, cell)[0] + shifts_db[key[0][1]] for key, cell in experiment.cells.items()]
    assert np.ptp(felt_db) < 1e-9


SPREAD = "attitude_sd = 0.15\ndimension_sd = 0.15\nstimulus_sd = 0.2"
NONE = "liking = 0\nattitude_sd = 0\ndimension_sd = 0\nstimulus_sd = 0\nacquiescence_sd = 0\nextremity_cv = 0"


def test_scores_differ_by_the_effect():
    """Participants differ only in item noise, so the standard error is known."""
    asked = design("frequency: 1 points", PATTERNS, "HQ", changed(PATTERNS, (SPREAD, NONE)), participants=(12,))
    for case, stated in zip(asked.cases, (1.0, 0.0), strict=True):
        (row,) = replicate(asked, case, 0)
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
    asked = design(effect, study, dependent)
    experiment = experiment_of(asked, asked.cases[0])
    form = next(
        form
        for form in ratings(simulated(asked, experiment, seed_of(asked.seed, 0)))
        if dependent in form.form.dimensions
    )
    table = table_of(form)
    (row,) = replicate(asked, asked.cases[0], 0)
    assert row.p == table.loc[table["Source"] == asked.effect.factor, "p_CM_corr"].iloc[0]


def test_patterns_are_tested_against_the_single_focus():
    asked = design("pattern: P3 = 1 points", PATTERNS, "ATT")
    (form,) = ratings(simulated(asked, experiment_of(asked, asked.cases[0]), seed_of(asked.seed, 0)))
    (row,) = replicate(asked, asked.cases[0], 0)
    assert row.p == form.against.loc[form.against["dimension"] == "ATT", "p_corr"].min()


REFUSALS = {
    "decibels": ("hybrid-button", (), "feedback: 2 dB SL", "the unit 'dB SL', expected points, the unit of scores"),
    "points of a threshold": ("tutorial", (), "frequency_hz: 2 points", "the unit 'points', expected one of dB, dB SL"),
    "no such dimension": (PATTERNS, (), "pattern: P3 = 1 points", "--dependent: found 'beauty', expected one of PQ"),
    "envelope of no patterns": ("hybrid-button", (), "envelope: 1 points", "expected a factor of the study (feedback)"),
    "no such envelope": (PATTERNS, (), "envelope: sine = 1 points", "expected a level of envelope (rectangular, "),
    "no attitudes": (
        "hybrid-button",
        (("[observer.raters]", "[texts]\n#"), ("effects.feedback.both = { realism = 0.2 }", "")),
        "feedback: 1 points",
        "observer.raters: found none, expected the table [observer.raters], as an effect on a score changes attitudes",
    ),
}


@pytest.mark.parametrize("case", REFUSALS)
def test_effect_on_no_score_is_refused(capsys, tmp_path, case):
    study, lines, effect, expected = REFUSALS[case]
    path = tmp_path / "study.toml"
    path.write_bytes(changed(study, *lines))
    dependent = ["--dependent", "beauty"] if "dimension" in case else []
    words = ["power", path, "--effect", effect, "--participants", "3", "--seed", "1", "--most", "1", *dependent]
    code, said, _ = call(capsys, *words)
    assert (code, said.count("\n")) == (2, 0)
    assert expected in said


def test_page_states_the_attitudes_of_the_effect(capsys, tmp_path):
    words = ["power", "hybrid-button", "--effect", "feedback: 1 points", "--participants", "3", "--seed", "1"]
    said = output(capsys, *words, "--most", "1", "--out", tmp_path)
    assert "realism of simulated participants, seed 1" in said
    page = (tmp_path / "power.html").read_text("utf-8")
    assert "attitude with the effect (-1 to 1)" in page
    assert "<td>electrovibration</td><td>0.00</td><td>0.00</td><td>0.00</td>" in page
