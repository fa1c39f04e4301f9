"""Page layouts: answers, and positions of items on the screen."""

from itertools import combinations

import pytest
from hypothesis import given, strategies as st

from tactometry.rigs.keyboard import FreshPresses
from tactometry.rigs.pages import entry, form, layout
from tactometry.rigs.pages.page import Box, Click, Disc, KeyDown, Page, Text
from tactometry.session.request import value_at

ASPECTS = [4 / 3, 16 / 10, 16 / 9, 21 / 9]


def pages(aspect):
    return [
        layout.message_page("Heading\n\nbody", "hint", aspect),
        layout.question_page("felt?", (0, 1), ("no", "yes"), "hint", aspect),
        layout.question_page("which?", (1, 2, 3, 4), ("1", "2", "3", "4"), "hint", aspect),
        layout.adjust_page("set", "hint", aspect),
        entry.entry_page("how strong?", "12", "hint", aspect, ready=True),
        layout.bar_page("Heading\n\nbody", "hint", aspect, 0.5),
        layout.track_page(layout.force_page(layout.marker_page(1, playing=True), 9.0, 1.0, 0.9), 1.0, 1 / 3),
        layout.track_page(layout.force_page(layout.marker_page(1, playing=True), 9.0, 1.0, 0.9), 1.0, 0.7, 2.0),
    ]


def extent(item):
    return (item.radius, item.radius) if isinstance(item, Disc) else (item.width / 2, item.height / 2)


@pytest.mark.parametrize("aspect", ASPECTS)
def test_every_shape_lies_within_the_screen(aspect):
    shapes = [item for page in pages(aspect) for item in page.items if isinstance(item, Box | Disc)]
    assert len(shapes) > 20
    for item in shapes:
        width, height = extent(item)
        assert abs(item.x) + width < aspect / 2, item
        assert abs(item.y) + height < 0.5, item


@pytest.mark.parametrize("aspect", ASPECTS)
def test_buttons_do_not_overlap(aspect):
    for page in pages(aspect):
        boxes = [button for button in page.buttons if button.width]
        for k, one in enumerate(boxes):
            for other in boxes[k + 1 :]:
                apart_x = abs(one.x - other.x) - (one.width + other.width) / 2
                apart_y = abs(one.y - other.y) - (one.height + other.height) / 2
                assert max(apart_x, apart_y) > -1e-9, (one, other)


US_KEY_OF = {
    "US": {},
    "German": {"y": "z", "z": "y"},
    "French": {"a": "q", "q": "a", "w": "z", "z": "w", "m": "semicolon"},
}
"""For each keyboard, the US name of the key on which a letter is printed."""


@pytest.mark.parametrize("keyboard", US_KEY_OF)
def test_displayed_letter_selects_its_answer_on_every_keyboard(keyboard):
    for first, second in combinations("abcdefghijklmnopqrstuvwxyz", 2):
        page = layout.question_page("?", (0, 1), (first * 2, second * 2), "hint", 1.6)
        for button in page.buttons:
            shown = button.keys[0]
            assert Text in {type(item) for item in page.items if getattr(item, "words", "") == shown.upper()}
            assert page.answer(KeyDown(US_KEY_OF[keyboard].get(shown, shown), 0.0)) == button.answer


@pytest.mark.parametrize("aspect", ASPECTS)
def test_buttons_respond_to_keys_and_clicks(aspect):
    for page in pages(aspect):
        clicked = [button for button in page.buttons if button.width]
        for button in page.buttons:
            assert all(page.answer(KeyDown(key, 0.0)) == button.answer for key in button.keys)
        for button in clicked:
            assert page.answer(Click(button.x, button.y, 0.0)) == button.answer
        answers = {button.answer for button in page.buttons}
        assert answers == {button.answer for button in clicked}
        assert answers == {button.answer for button in page.buttons if button.keys}


def test_each_key_has_one_meaning():
    for page in pages(1.6):
        keys = [key for button in page.buttons for key in button.keys]
        assert len(keys) == len(set(keys))


@pytest.mark.parametrize("event", [KeyDown("q", 0.0), Click(0.0, 0.45, 0.0)])
def test_question_ignores_other_events(event):
    assert layout.question_page("felt?", (0, 1), ("no", "yes"), "", 1.6).answer(event) is None
    assert Page().answer(event) is None


@pytest.mark.parametrize(
    ("options", "labels", "shown"),
    [
        ((0, 1), ("no", "yes"), ["n", "y"]),
        ((0, 1), ("non", "oui"), ["n", "o"]),
        ((0, 1), ("nein", "ja"), ["n", "j"]),
        ((0, 1), ("no", "néant"), ["0", "1"]),
        ((1, 2), ("émoussé", "aigu"), ["e", "a"]),
        ((1, 2), ("1", "2"), ["1", "2"]),
        ((1, 2), ("second", "premier"), ["s", "p"]),
    ],
)
def test_displayed_keys_are_unambiguous(options, labels, shown):
    keys = layout.option_keys(options, labels)
    assert [key[0] for key in keys] == shown
    assert [key[-1] for key in keys] == [f"num_{option}" for option in options]


@pytest.mark.parametrize(("force_n", "held"), [(None, False), (0.79, False), (0.8, True), (1.2, True), (1.3, False)])
def test_force_band_is_shown_by_colour_and_shape(force_n, held):
    marker = layout.marker_page(1, playing=False)
    items = layout.force_page(marker, force_n, 1.0, 0.2).items[len(marker.items) :]
    assert any(isinstance(item, Box) and item.width == item.height for item in items) is held
    assert any(isinstance(item, Box) and item.fill == layout.GOOD for item in items) is held


@given(st.floats(-1e3, 1e3), st.floats(1e-3, 1e3))
def test_scale_ends_have_end_values(low, span):
    assert value_at(0, form.N_POSITIONS_CONTINUOUS, low, low + span) == low
    assert value_at(100, form.N_POSITIONS_CONTINUOUS, low, low + span) == low + span


@given(st.lists(st.tuples(st.sampled_from("yn"), st.integers(0, 50)), unique=True), st.data())
def test_fresh_presses_pass_each_press_once(presses, data):
    fresh = FreshPresses()
    seen = []
    for _ in range(3):
        seen += fresh.of(data.draw(st.lists(st.sampled_from(presses))) if presses else [])
    seen += fresh.of(presses)
    assert sorted(seen) == sorted(presses)


@pytest.mark.parametrize("length", [0.2, 1 / 3, 0.5, 0.51, 0.9])
def test_track_does_not_overlap_bar_or_circle(length):
    marker = layout.marker_page(1, playing=True)
    bar = layout.force_page(marker, 1.0, 1.0, 0.2).items[len(marker.items) :]
    track = [item for item in layout.track_page(marker, 1.0, length, 2.0).items if item not in marker.items]
    assert len(track) == 3
    for one in (*bar, *marker.items[:1]):
        for other in track:
            apart = [abs(getattr(one, axis) - getattr(other, axis)) for axis in "xy"]
            reach = [a + b for a, b in zip(extent(one), extent(other), strict=True)]
            assert any(gap > both for gap, both in zip(apart, reach, strict=True)), (one, other)
