"""Console rig: valid answers, printed texts, and stopping."""

import io
from dataclasses import replace

import catalogue
import pytest

from tactometry.errors import Stopped
from tactometry.rigs.console import N_TRIES, Console
from tactometry.rigs.texts import phrases_in, texts_in
from tactometry.session.request import Adjust, Choose, Enter, Fill, Play, Press, Question, Record, Show, Slide
from tactometry.trials.trial import Trial

FELT = Choose("felt", (0, 1), ("no", "yes"))
POLES = {"en": ("warm", "not", "much"), "de": ("warm", "nicht", "sehr"), "fr": ("chaud", "pas", "très")}


def console(text, language="en", texts=None, source=None):
    said = io.StringIO()
    rig = Console(
        catalogue.silent(catalogue.AnyStimulus(), catalogue.LIMITS),
        texts_in(language, texts or {}),
        source=source or io.StringIO(text),
        output=said,
    )
    return rig, said


@pytest.mark.parametrize(
    ("typed", "language", "option"),
    [("1", "en", 1), ("0", "en", 0), ("YES", "en", 1), ("No", "en", 0), ("oui", "fr", 1), ("1", "fr", 1)],
)
def test_console_accepts_option_number_or_label(typed, language, option):
    rig, said = console(f"{typed}\n", language)
    assert rig.answer(FELT).option == option
    assert f"{option} = {typed.lower()}" in said.getvalue() or typed in "01"


def test_console_repeats_question_after_invalid_answer():
    rig, said = console("maybe\n\n7\nyes\n")
    assert rig.answer(FELT).option == 1
    assert said.getvalue().count("[trial 1] Did you feel something?") == 4


REFUSED = (
    (FELT, "2\n1\n", "en", "expected 0 or 1, found '2'"),
    (FELT, "vielleicht\n1\n", "de", "erwartet wird 0 oder 1, nicht 'vielleicht'"),
    (FELT, "x\n1\n", "fr", "réponse attendue : 0 ou 1, au lieu de 'x'"),
    (Choose("which_place", (1, 2, 3), ("a", "b", "c")), "4\n1\n", "en", "expected 1, 2 or 3, found '4'"),
    (Enter("how_strong", 0.0), "-1\n1\n", "en", "expected a number from 0, found '-1'"),
    (Adjust("tone", 5.0, 1.0, 0.0, 10.0), "x\n5\n", "en", "expected a number from 0 to 10, found 'x'"),
    (
        Fill("f", (Question("a", POLES),), 0.0, 1.0, 5),
        "0.3\n0.25\n",
        "en",
        "expected a number from 0 to 1, in steps of 0.25 (- leaves it open, < goes back), found '0.3'",
    ),
)


@pytest.mark.parametrize(("request_", "typed", "language", "told"), REFUSED)
def test_console_states_expected_answer_after_invalid_line(request_, typed, language, told):
    rig, said = console(typed, language)
    rig.answer(request_)
    assert said.getvalue().count(told) == 1


class Typed(io.StringIO):
    def isatty(self):
        return True


def test_page_waits_only_at_a_terminal():
    rig, said = console("1\n")
    rig.answer(Show("rest"))
    assert rig.answer(FELT).option == 1
    assert "Press return to continue" not in said.getvalue()
    rig, said = console("", source=Typed("\n1\n"))
    rig.answer(Show("rest"))
    rig.answer(Show("right", duration_s=0.001))
    rig.answer(Show("end"))
    assert rig.answer(FELT).option == 1
    assert said.getvalue().count("Press return to continue") == 1


def test_consent_question_has_no_trial_number():
    rig, said = console("yes\nyes\n")
    rig.answer(Choose("agree", (0, 1), ("no", "yes")))
    assert "[trial" not in said.getvalue()
    rig.answer(FELT)
    assert "[trial 1]" in said.getvalue()


def test_escape_on_a_page_stops_the_session():
    rig, _ = console("", source=Typed("\x1b\n"))
    with pytest.raises(Stopped, match="Escape was typed"):
        rig.answer(Show("rest"))


def test_session_stops_after_twenty_invalid_lines():
    rig, _ = console("x\n" * (N_TRIES - 1) + "1\n")
    assert rig.answer(FELT).option == 1
    rig, _ = console("x\n" * N_TRIES + "1\n")
    with pytest.raises(Stopped, match="20 invalid answers in a row; recorded data are safe: continue with"):
        rig.answer(FELT)


ASKED = (
    Press("tone", None, 0.5, target_n=1.0, tolerance=0.2, hold_s=0.1, timeout_s=5.0, interval=2),
    Slide("tone", None, 0.5, 1.0, 0.2, 0.1, 5.0, speed_m_per_s=0.05),
    Play("tone", None, 0.01),
    Enter("how_strong", 0.0),
    Fill("f", (Question("a", POLES),), 0.0, 1.0, 5),
    Adjust("tone", 5.0, 1.0, 0.0, 10.0),
    Record(Trial(4, 7, {}, "staircase", 5.0, "V", "yes_no", None, valid=False, invalid_reason="too_light", attempt=2)),
)
IN_GERMAN = [
    "Strg-C hält an (bei einer Frage auch Strg-D, oder Escape und Eingabe); was aufgezeichnet ist, ist sicher.",
    "[Durchgang 1] 0.5 s lang mit 1 N drücken, Intervall 2",
    "[Durchgang 1] 0.5 s lang mit 1 N und 50 mm/s gleiten",
    "[Durchgang 1] spielt 0.01 s lang",
    "Wie stark war es? (eine Zahl ab 0): erwartet wird eine Zahl ab 0, nicht 'x'",
    "Wie stark war es? (eine Zahl ab 0): "
    "warm (0 = nicht, 1 = sehr, in Schritten von 0.25; - lässt sie offen, < geht zurück): "
    "Pegel von tone (0 bis 10): "
    "[Durchgang 1] zählt nicht: zu leicht (Durchgang 7, Versuch 2)",
]


def test_console_prints_in_the_session_language():
    rig, said = console("x\n3,5\n0,25\n5\n", "de")
    answers = [rig.answer(request) for request in ASKED]
    assert (answers[3].value, answers[4].values) == (3.5, (0.25,))
    first, *others = said.getvalue().splitlines()
    assert (first, others) == (phrases_in("de")["silent"].strip(), IN_GERMAN)


@pytest.mark.parametrize(("language", "heading"), [("en", "Stopped"), ("de", "Angehalten"), ("fr", "Arrêt")])
def test_stopped_page_names_the_experimenter(language, heading):
    rig, said = console("\x1b\n", language)
    with pytest.raises(Stopped, match="Escape was typed; recorded data are safe: continue with --resume"):
        rig.answer(FELT)
    experimenter = texts_in(language, {}).label("experimenter")
    assert said.getvalue().partition(f"{heading}\n\n")[2].count(experimenter) == 1


def test_aborted_block_is_reported_immediately():
    rig, said = console("")
    rig.answer(Record(Trial(1, 1, {}, "staircase", 5.0, "V", "yes_no", 1), aborted="block 1 is aborted: so"))
    assert said.getvalue().endswith("\n! block 1 is aborted: so\n")


def test_trial_number_excludes_questionnaire_rows():
    rig, said = console("yes\n")
    item = Trial(1, 1, {}, "sus", None, "", "rating", 3.0, item="SUS1")
    rig.resume([item, replace(item, task="yes_no", level=5.0)], 10.0)
    rig.answer(Record(replace(item, item="SUS2")))
    rig.answer(FELT)
    assert "[trial 2]" in said.getvalue()
