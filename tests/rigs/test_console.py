"""The console: what counts as an answer, and when it gives up."""

import io
from dataclasses import replace

import catalogue
import pytest

from tactometry.errors import Stopped
from tactometry.rigs.console import N_TRIES, Console
from tactometry.rigs.texts import texts_in
from tactometry.session.request import Choose, Record
from tactometry.trials.trial import Trial

FELT = Choose("felt", (0, 1), ("no", "yes"))


def console(text, language="en", texts=None):
    said = io.StringIO()
    rig = Console(
        catalogue.silent(catalogue.AnyStimulus(), catalogue.LIMITS),
        texts_in(language, texts or {}),
        source=io.StringIO(text),
        output=said,
    )
    return rig, said


@pytest.mark.parametrize(
    ("typed", "language", "option"),
    [
        ("1", "en", 1),
        ("0", "en", 0),
        ("yes", "en", 1),
        ("YES", "en", 1),
        ("No", "en", 0),
        ("oui", "fr", 1),
        ("Non", "fr", 0),
        ("1", "fr", 1),
    ],
)
def test_an_answer_is_the_number_or_the_word_that_is_shown(typed, language, option):
    rig, said = console(f"{typed}\n", language)
    assert rig.answer(FELT).option == option
    assert f"{option} = {typed.lower()}" in said.getvalue() or typed in "01"


def test_what_is_no_answer_is_asked_again():
    rig, said = console("maybe\n\n7\nyes\n")
    assert rig.answer(FELT).option == 1
    assert said.getvalue().count("expected an answer to") == 3


def test_after_twenty_lines_that_are_none_the_session_stops():
    rig, _ = console("x\n" * (N_TRIES - 1) + "1\n")
    assert rig.answer(FELT).option == 1
    rig, _ = console("x\n" * N_TRIES + "1\n")
    with pytest.raises(Stopped, match="20 lines were no answers; what was recorded is safe: go on with"):
        rig.answer(FELT)


def test_a_block_that_is_aborted_is_told_at_once():
    rig, said = console("")
    rig.answer(Record(Trial(1, 1, {}, "staircase", 5.0, "V", "yes_no", 1), aborted="block 1 is aborted: so"))
    assert said.getvalue().endswith("\n! block 1 is aborted: so\n")


def test_trials_are_counted_and_rows_of_questionnaires_are_not():
    rig, said = console("yes\n")
    item = Trial(1, 1, {}, "sus", None, "", "rating", 3.0, item="SUS1")
    rig.resume([item, replace(item, task="yes_no", level=5.0)], 10.0)
    rig.answer(Record(replace(item, item="SUS2")))
    rig.answer(FELT)
    assert "[trial 2]" in said.getvalue()
