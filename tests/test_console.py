"""The console: what counts as an answer, and when it gives up."""

import io

import catalogue
import pytest

from tactometry.errors import Stopped
from tactometry.request import Choose
from tactometry.rigs.console import N_TRIES, Console
from tactometry.rigs.texts import texts_in

FELT = Choose("felt", (0, 1), ("no", "yes"))


def console(text, language="en", texts=None):
    said = io.StringIO()
    rig = Console(
        catalogue.AnyStimulus(),
        catalogue.LIMITS,
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
    assert rig.choose(FELT).option == option
    assert f"{option} = {typed.lower()}" in said.getvalue() or typed in "01"


def test_what_is_no_answer_is_asked_again():
    rig, said = console("maybe\n\n7\nyes\n")
    assert rig.choose(FELT).option == 1
    assert said.getvalue().count("expected an answer to") == 3


def test_after_twenty_lines_that_are_none_the_session_stops():
    rig, _ = console("x\n" * (N_TRIES - 1) + "1\n")
    assert rig.choose(FELT).option == 1
    rig, _ = console("x\n" * N_TRIES + "1\n")
    with pytest.raises(Stopped, match="20 lines in trial 1 were no answers: the 0 trials before are safe"):
        rig.choose(FELT)
