"""Demographic questions and study texts in a PsychoPy script's window."""

import queue

import pytest
from patience import LONGEST_WAIT_S
from study_texts import TUTORIAL, changed

from tactometry.errors import InvalidParameter, Stopped
from tactometry.experiments.psychopy_plugin.script import PsychoPyStudy
from tactometry.rigs.pages.page import Text
from tactometry.rigs.window import Window

FRENCH = '[screen]\nfullscreen = false\nlanguage = "fr"\n'
HABITS = """
[forms.habits]
kind = "choices"
title = "Habits"
reference = "own wording"

[[forms.habits.items]]
id = "screens"
prompt = { en = "How often do you use a touch screen?" }
options = [{ code = 1, words = { en = "daily" } }, { code = 2, words = { en = "less often" } }]

[[forms.habits.items]]
id = "age_years"
prompt = { en = "How old are you?" }
low = 18.0
high = 99.0
"""
ASKED = '[inquiries.habits]\nform = "habits"\nafter = "start"\nidentifies = true\n'
TOLD = 'kind = "yes_no"\nprompt = { en = "Was there a buzz?", fr = "Y avait-il un bourdonnement ?" }'


@pytest.fixture
def pages(monkeypatch):
    shown, present = queue.Queue(), Window.present

    def noted(window, page):
        flipped_s = present(window, page)
        shown.put([item.words for item in page.items if isinstance(item, Text)])
        return flipped_s

    monkeypatch.setattr(Window, "present", noted)
    return shown


@pytest.fixture
def presses(pages, hands, in_background):
    """A function that presses keys on each page and returns the page texts."""

    def start(*keys):
        seen = []

        def press():
            for of_page in keys:
                seen.append(" ".join(pages.get(timeout=LONGEST_WAIT_S)))
                for key in of_page:
                    hands.tap(key)

        in_background(press)
        return seen

    return start


@pytest.fixture
def study_with(screen, tmp_path):
    made = []

    def make(study, bench=""):
        (tmp_path / "s.toml").write_text(study, "utf-8")
        (tmp_path / "b.toml").write_text(bench, "utf-8")
        made.append(PsychoPyStudy(screen._window, tmp_path / "s.toml", tmp_path / "b.toml" if bench else None))
        return made[-1]

    yield make
    for each in made:
        each.close()


@pytest.fixture
def experiment(screen):
    """A PsychoPy experiment handler; its import requires a display."""
    del screen
    from psychopy import data

    return data.ExperimentHandler("mine", savePickle=False, saveWideText=False)


def rows_of(experiment, form):
    return [tuple(row.get(f"{form}.{name}") for name in ("item", "response", "category")) for row in experiment.entries]


def test_demographics_rows_include_category_labels(study_with, presses, experiment):
    study = study_with(TUTORIAL, FRENCH)
    seen = presses("3", "1", "0")
    assert study.questionnaire("demographics", experiment) == {"age_band": 3.0, "handedness": 1.0, "gender": 0.0}
    rows = [("age_band", 3.0, "25 to 34"), ("handedness", 1.0, "right"), ("gender", 0.0, "")]
    assert rows_of(experiment, "demographics") == rows
    assert "De quelle main" in seen[1]


def test_answers_before_escape_are_kept(study_with, presses, experiment, monkeypatch):
    monkeypatch.setattr("tactometry.rigs.experimenter.supervisor.STOPPED_S", 0.05)
    study = study_with(TUTORIAL)
    presses("1", ["Escape"])
    with pytest.raises(Stopped):
        study.questionnaire("demographics", experiment)
    assert [item for item, *_ in rows_of(experiment, "demographics")] == ["age_band"]


def test_identifying_number_is_asked_when_study_permits(study_with, presses, experiment):
    study = study_with(TUTORIAL + HABITS + ASKED)
    presses("2", "1", ["4", "2", "Return"])
    assert study.questionnaire("habits", experiment) == {"screens": 2.0, "age_years": 42.0}
    assert rows_of(experiment, "habits") == [("screens", 2.0, "less often"), ("age_years", 42.0, "")]


def test_identifying_number_is_refused_by_default(study_with):
    study = study_with(TUTORIAL + HABITS)
    with pytest.raises(InvalidParameter, match="questionnaire habits: found age_years, which could identify"):
        study.questionnaire("habits")


def test_form_without_bench_language_is_refused(study_with):
    study = study_with(TUTORIAL + HABITS + ASKED, FRENCH)
    with pytest.raises(InvalidParameter, match="questionnaire habits: found no words in 'fr', expected one of en; "):
        study.questionnaire("habits")


def test_trial_shows_the_study_prompt(study_with, pages, hands, in_background):
    study = study_with(changed(TUTORIAL, {'kind = "yes_no"': TOLD}), FRENCH)
    asked = "Y avait-il un bourdonnement ?"

    def answer():
        while asked not in pages.get(timeout=LONGEST_WAIT_S):
            pass
        hands.tap("1")

    in_background(answer)
    assert study.trial(34.0, frequency_hz=60).replies[0].response == 1
