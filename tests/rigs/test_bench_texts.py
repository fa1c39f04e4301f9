"""Texts of the participant's pages."""

import re
import string

import pytest

from tactometry.errors import InvalidParameter
from tactometry.rigs.texts import languages, phrases_in, texts_in
from tactometry.trials.trial import REASONS


def places(text):
    return {name for _, name, _, _ in string.Formatter().parse(text) if name is not None}


@pytest.mark.parametrize("language", languages())
def test_every_language_has_the_same_messages(language):
    """A failure lists the missing and the superfluous messages."""
    english, other = texts_in("en", {}), texts_in(language, {})
    assert sorted(english.labels.keys() ^ other.labels.keys()) == [], f"labels in messages_{language}.toml"
    assert sorted(english.messages.keys() ^ other.messages.keys()) == [], f"messages in messages_{language}.toml"
    told, said = phrases_in("en"), phrases_in(language)
    assert sorted(told.keys() ^ said.keys()) == [], f"console in messages_{language}.toml"
    pairs = [(text, english.messages[name]) for name, text in other.messages.items()]
    pairs += [(text, told[name]) for name, text in said.items()]
    unlike = [text for text, in_english in pairs if places(text) != places(in_english)]
    assert unlike == [], f"messages_{language}.toml fills other places in these"


@pytest.mark.parametrize("language", languages())
def test_every_invalid_reason_has_a_message(language):
    told = [texts_in(language, {}).message(f"lost_{reason}") for reason in REASONS]
    assert len(set(told)) == len(REASONS)
    assert not set(told) & {f"lost_{reason}" for reason in REASONS}


@pytest.mark.parametrize(("one", "other", "same"), [("en", "fr", ["right"]), ("en", "de", []), ("de", "fr", [])])
def test_languages_do_not_share_texts(one, other, same):
    first, second = texts_in(one, {}).messages, texts_in(other, {}).messages
    assert [name for name in first if first[name] == second[name]] == same


@pytest.mark.parametrize(
    ("language", "words"),
    [
        ("fr", "tu|te|toi|ton|ta|tes|prêt|prêts|sûr|certain"),
        ("de", "du|dir|dich|dein|deine|deinen|Teilnehmer|Proband"),
    ],
)
def test_texts_are_formal_and_gender_neutral(language, words):
    texts = texts_in(language, {})
    found = {name: re.findall(rf"\b(?:{words})\b", text) for name, text in texts.messages.items()}
    assert {name: told for name, told in found.items() if told} == {}


@pytest.mark.parametrize("language", languages())
def test_every_line_fits_on_a_narrow_screen(language):
    """A line fits 70 letters of text or 90 of a hint at 1280 x 800.

    A touch page at 1024 x 768 fits 62.
    """
    for name, text in texts_in(language, {}).messages.items():
        longest = max(map(len, text.splitlines()))
        most = 62 if name.startswith("lost_") else 90 if name.startswith(("hint", "meaning")) else 70
        assert longest <= most, name


def test_study_texts_override_built_in_texts():
    texts = texts_in("fr", {"felt": "Alors ?", "yes": "si"})
    assert (texts.message("felt"), texts.label("yes"), texts.label("no")) == ("Alors ?", "si", "non")


def test_untranslated_label_is_unchanged():
    assert texts_in("fr", {}).label("rugueux") == "rugueux"


@pytest.mark.parametrize(
    ("name", "texts", "values", "message"),
    [
        ("welcom", {}, {}, r"message 'welcom': found no text of this name, .*did you mean 'welcome'\?"),
        ("block", {}, {"part": 1}, r"message 'block': .*\('n_parts'\), expected the names part in braces"),
        ("mine", {"mine": "{0}"}, {}, r"message 'mine': .*expected the names \(none\) in braces"),
        ("mine", {"mine": "{"}, {}, "message 'mine': found a place that cannot be filled"),
        ("mine", {"mine": "{a.b}"}, {"a": 1}, "message 'mine': found a place that cannot be filled"),
    ],
)
def test_invalid_messages_are_rejected(name, texts, values, message):
    with pytest.raises(InvalidParameter, match=message):
        texts_in("en", texts).message(name, values)


def test_an_unknown_language_is_refused():
    with pytest.raises(InvalidParameter, match="language: found 'fl', expected one of de, en, fr"):
        texts_in("fl", {})
