"""The words of the participant's pages."""

import string

import pytest

from tactometry.errors import InvalidParameter
from tactometry.rigs.texts import languages, texts_in
from tactometry.trials.trial import REASONS


def places(text):
    return {name for _, name, _, _ in string.Formatter().parse(text) if name is not None}


@pytest.mark.parametrize("language", languages())
def test_every_language_has_the_same_messages_with_the_same_places(language):
    english, other = texts_in("en", {}), texts_in(language, {})
    assert set(other.labels) == set(english.labels)
    assert {name: places(text) for name, text in other.messages.items()} == {
        name: places(text) for name, text in english.messages.items()
    }


@pytest.mark.parametrize("language", languages())
def test_every_reason_for_which_a_touch_does_not_count_is_told(language):
    told = [texts_in(language, {}).message(f"lost_{reason}") for reason in REASONS]
    assert len(set(told)) == len(REASONS)
    assert not set(told) & {f"lost_{reason}" for reason in REASONS}


def test_a_language_is_a_translation():
    english, french = texts_in("en", {}), texts_in("fr", {})
    alike = [name for name in english.messages if english.messages[name] == french.messages[name]]
    assert alike == ["right"], "of all words 'Correct' alone is the same"


@pytest.mark.parametrize("language", languages())
def test_every_line_fits_on_a_narrow_screen(language):
    """The pictures at 1280 x 800 hold 70 letters of a text, and the more that a hint has."""
    for name, text in texts_in(language, {}).messages.items():
        longest = max(map(len, text.splitlines()))
        assert longest <= (90 if name.startswith(("hint", "meaning")) else 70), name


def test_the_study_s_text_stands_above_the_shipped_one():
    texts = texts_in("fr", {"felt": "Alors ?", "yes": "si"})
    assert (texts.message("felt"), texts.label("yes"), texts.label("no")) == ("Alors ?", "si", "non")


def test_a_label_that_nobody_translates_stays_as_it_is():
    assert texts_in("fr", {}).label("rugueux") == "rugueux"


@pytest.mark.parametrize(
    ("name", "texts", "values", "message"),
    [
        ("welcom", {}, {}, r"message 'welcom': found no text of this name, .*did you mean 'welcome'\?"),
        ("block", {}, {"block": 1}, r"message 'block': .*\('n_blocks'\), expected the names block in braces"),
        ("mine", {"mine": "{0}"}, {}, r"message 'mine': .*expected the names \(none\) in braces"),
        ("mine", {"mine": "{"}, {}, "message 'mine': found a place that cannot be filled"),
        ("mine", {"mine": "{a.b}"}, {"a": 1}, "message 'mine': found a place that cannot be filled"),
    ],
)
def test_a_message_that_cannot_be_shown_is_refused(name, texts, values, message):
    with pytest.raises(InvalidParameter, match=message):
        texts_in("en", texts).message(name, values)


def test_an_unknown_language_is_refused():
    with pytest.raises(InvalidParameter, match="language: found 'fl', expected one of en, fr"):
        texts_in("fl", {})
