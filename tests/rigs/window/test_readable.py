"""Accessibility of pages: text size, colour blindness, and input devices."""

import math

import numpy as np
import pytest
import screens

from tactometry.rigs.pages import form, layout, page
from tactometry.rigs.pages.page import Click, KeyDown, Page, Text
from tactometry.rigs.texts import languages, texts_in
from tactometry.session.request import Fill, Question

READ_AT_M, LEAST_ARCMIN = 2.0, 20.0
SAID_ON_M, ALL_ON_M = 0.40, 0.52
"""Heights of 32-inch and 42-inch screens (16:9)."""


@pytest.fixture(scope="module")
def capital(screen):
    """Drawn height of a capital letter, in units of its text height."""
    drawn = np.asarray(screen.picture(Page((Text("H", 0, 0, 0.5),))).convert("L"))
    lit = np.flatnonzero((drawn > drawn[0, 0] + 50).any(axis=1))
    return (lit[-1] - lit[0] + 1) / drawn.shape[0] / 0.5


def arcmin(letter_m):
    return 60 * math.degrees(math.atan(letter_m / READ_AT_M))


def texts_on(shown):
    return [item for item in shown.items if isinstance(item, Text) and item.words.strip()]


@pytest.mark.parametrize("language", languages())
def test_text_subtends_20_arcmin_at_two_metres(capital, language):
    """The screen is 0.40 m high; hints and questionnaire words require 0.52 m."""
    said = [item.height for shown in screens.all_pages(language, 16 / 9).values() for item in texts_on(shown)]
    large = [height for height in said if height != layout.HINT]
    assert len(large) > 50
    assert arcmin(capital * min(large) * SAID_ON_M) >= LEAST_ARCMIN
    assert arcmin(capital * min(*said, form.WORDS) * ALL_ON_M) >= LEAST_ARCMIN


# Linear sRGB as seen without one cone type, by the method of Vienot, Brettel and
# Mollon (1999), Color Research and Application 24, 243-252
WITHOUT = {
    "all cones": np.eye(3),
    "L": np.array([[0.11238, 0.88762, 0.0], [0.11238, 0.88762, 0.0], [0.00401, -0.00401, 1.0]]),
    "M": np.array([[0.29275, 0.70725, 0.0], [0.29275, 0.70725, 0.0], [-0.02234, 0.02234, 1.0]]),
}
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def linear(colour):
    parts = np.array([int(colour[k : k + 2], 16) for k in (1, 3, 5)]) / 255
    return np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)


def contrast(one, other, cones):
    low, high = sorted(float(LUMINANCE @ (WITHOUT[cones] @ linear(colour))) for colour in (one, other))
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("cones", WITHOUT)
def test_colours_have_contrast_for_colour_blind_participants(cones):
    """WCAG 2.1 requires 4.5 for letters (1.4.3) and 3 for lines (1.4.11)."""
    for colour in (page.INK, page.QUIET, page.ACCENT, page.GOOD):
        assert contrast(colour, page.PAPER, cones) >= 4.5, colour
    assert contrast(page.EDGE, page.PAPER, cones) >= 3
    assert contrast(page.PAPER, page.ACCENT, cones) >= 4.5, "the number in a filled circle"


def seven_steps(*rows):
    questions = tuple(Question(f"q{k}", {"en": row}) for k, row in enumerate(rows))
    return form.Form(Fill("form", questions, 1.0, 7.0, steps=7), texts_in("en", {}))


SEVEN = seven_steps(("warm?", "cold", "warm"))


def shapes(shown):
    return sorted((type(item).__name__, item.fill is None) for item in shown.items if not isinstance(item, Text))


def test_states_differ_by_shape_and_colour():
    """States: playing, held, and marked, each compared with its opposite."""
    ready, playing = (layout.marker_page(1, playing=on) for on in (False, True))
    assert shapes(ready) != shapes(playing)
    held, light = (layout.force_page(ready, force_n, 1.0, 0.2) for force_n in (1.0, 0.5))
    assert shapes(held) != shapes(light)
    blank, marked = (form.form_page(SEVEN, form.Marks((place,)), 1.6) for place in (None, 3))
    assert shapes(blank) != shapes(marked)


@pytest.mark.parametrize("place", range(7))
def test_every_scale_position_works_by_arrows_or_mouse(place):
    """A touch screen has no keys; its touches are mouse presses."""
    marks = SEVEN.begun()
    for key in ["right"] * 8 + ["left"] * (6 - place):
        marks, _ = form.after(SEVEN, marks, form.form_page(SEVEN, marks, 1.6).answer(KeyDown(key, 0.0)))
    assert marks.places == (place,)
    marks, _ = after_click(SEVEN, SEVEN.begun(), (0, place))
    marks, left = after_click(SEVEN, marks, layout.CONFIRM)
    assert (marks.places, left) == ((place,), True)


def after_click(asked, marks, answer):
    shown = form.form_page(asked, marks, 1.6)
    return form.after(asked, marks, shown.answer(Click(*at(shown, answer), 0.0)))


def at(shown, answer):
    """Return a point where a mouse press gives this answer."""
    places = ((x / 100, y / 100) for x in range(-80, 81) for y in range(-50, 51))
    return next(place for place in places if shown.answer(Click(*place, 0.0)) == answer)
