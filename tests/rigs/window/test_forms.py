"""Questionnaires and typed numbers in a real window."""

import threading
from dataclasses import replace

import pytest

from tactometry.errors import InvalidParameter
from tactometry.protocols.session import question_of, words_of
from tactometry.protocols.tasks.rating import pages
from tactometry.questionnaire import load, load_choices
from tactometry.rigs.bench import Bench
from tactometry.rigs.device_rig import Equipment
from tactometry.rigs.pages import form
from tactometry.rigs.texts import texts_in
from tactometry.session.request import Enter, Show

HAPTIC = load("attrakdiff-haptic")
(PAGE,) = pages(HAPTIC, HAPTIC.items)
(VAS,) = pages(load("pleasantness-vas"), load("pleasantness-vas").items)
FIRST, SECOND = pages(load("attrakdiff-mini"), load("attrakdiff-mini").items)
TO_THE_END = ("Down", "End")
OK = (0.0, form.FOOT_Y)
ASPECT = 1.6


def drawn(request=PAGE):
    return form.Form(request, texts_in("en", {}))


def place(row, k, request=PAGE):
    """Return the screen coordinates of position `k` of a row."""
    page = drawn(request)
    pitch = (form.TOP - form.BOTTOM) / len(page.rows)
    y = form.scale_y(page, row, form.TOP - (row + 0.5) * pitch, pitch)
    return ((k + 0.5) / page.n_positions - 0.5) * form.scale_extent(page, ASPECT), y


@pytest.mark.parametrize(("pressed", "code"), [("3", 3), ("0", 0), ((0.0, 0.24), 1)])
def test_demographics_accept_digit_or_touch(watched, output, participant, pressed, code):
    form = load_choices("demographics")
    bench = Bench(watched, Equipment(output, {}), texts_in("fr", words_of(form, "fr")))
    participant.answers(pressed)
    assert bench.answer(question_of(form, form.items[0])).option == code
    bench.close()


@pytest.mark.parametrize(
    ("acts", "values"),
    [
        ([*"1234567", "Return"], (1, 2, 3, 4, 5, 6, 7)),
        ([*(place(row, row) for row in (6, 2, 0, 1, 5, 4, 3)), place(6, 0), 0.05, OK], (1, 2, 3, 4, 5, 6, 1)),
        (
            [*"1111111", "Up", "Right", "Right", "Up", "End", "Up", "End", "Home", "Right", "Return"],
            (1, 1, 1, 2, 7, 3, 1),
        ),
        (["Right", "Down", "Left", "Down", *"11111", "Return"], (1, 7, 1, 1, 1, 1, 1)),
        ([*["Return"] * 4, *"2222222", "Return"], (2,) * 7),
    ],
    ids=["digits", "touches in any order", "arrows", "arrows from each end", "return on open rows"],
)
def test_form_accepts_digits_touches_and_arrows(bench, participant, acts, values):
    participant.answers(*acts)
    filled = bench.answer(PAGE)
    assert filled.values == values
    assert filled.latency_s > 0
    assert filled.timestamp_utc.endswith("+00:00")


def test_leaving_incomplete_page_requires_separate_key(bench, participant, watched):
    hint, asked = texts_in("en", {}).message("hint_gaps"), threading.Event()

    def refresh(page):
        if hint in {getattr(item, "words", None) for item in page.items}:
            asked.set()
        return watched.wrapped.refresh(page)

    watched.refresh = refresh
    participant.answers("4", "0", "Return", asked, "0")
    assert bench.answer(PAGE).values == (4.0, *(None,) * 6)


def test_touch_sets_value_on_continuous_line(bench, participant):
    participant.answers(place(0, 75, VAS), place(1, 50, VAS), 0.05, OK)
    assert bench.answer(VAS).values == pytest.approx((75, 50), abs=1)


def test_drag_sets_its_row_at_release_point(bench, participant, hands):
    (x, _), (far, low) = place(0, 20, VAS), place(1, 90, VAS)
    participant.answers(  # a click is stamped when it is read, so the keys wait for it
        lambda: hands.drag(place(0, 20, VAS), (0.5 * (x + far), low), (far, low)), 0.3, *TO_THE_END, "Return"
    )
    assert bench.answer(VAS).values == pytest.approx((90, 100), abs=1)


def test_held_arrow_key_keeps_moving(bench, participant, hands):
    participant.answers("Home", lambda: hands.tap("Right", hold_s=1.0), *TO_THE_END, "Return")
    moved, _ = bench.answer(VAS).values
    assert 5 <= moved < 100


def test_held_key_answers_once(bench, participant, hands):
    participant.answers(lambda: hands.tap("Return", hold_s=0.8), *"1111111", "Return")
    assert bench.answer(PAGE).values == (1.0,) * 7


def test_going_back_restores_previous_page_marks(bench, participant):
    participant.answers("3", "BackSpace")
    left = bench.answer(SECOND)
    assert (left.back, left.values[:2]) == (True, (3.0, None))
    participant.answers("BackSpace", *"45555", "Return")
    again = bench.answer(replace(FIRST, given=(1.0, 2.0, None, None, None)))
    assert (again.back, again.values) == (False, (1.0, 2.0, 4.0, 5.0, 5.0))


def test_form_page_shows_prompt_and_page_number():
    page = form.form_page(drawn(SECOND), form.Marks((None,) * 5), ASPECT)
    words = {getattr(item, "words", "") for item in page.items}
    assert {"The surface that you felt was …", "Page 2 of 2", *"1234567"} <= words


@pytest.mark.parametrize(
    ("acts", "value"),
    [
        (("1", "2", "period", "5", "Return"), 12.5),
        (("9", "BackSpace", "3", "KP_Enter"), 3.0),
        (("Return", "7", "space"), 7.0),
        (((-0.16, 0.12), (0.0, -0.21), 0.05, (0.42, -0.21)), 70.0),
    ],
    ids=["keys", "corrected", "not empty", "touch"],
)
def test_number_accepts_keys_or_touch(bench, participant, acts, value):
    participant.answers(*acts)
    assert bench.answer(Enter("how_strong", 0.0)).value == value


def test_number_out_of_bounds_is_ignored(bench, participant):
    participant.answers("5", "0", "Return", 0.1, "BackSpace", "Return")
    assert bench.answer(Enter("how_strong", 0.0, 10.0)).value == 5.0


def test_timed_page_closes_itself(bench):
    before_s = bench.answer(Show("right", duration_s=0.1)).at_s
    assert bench.answer(Show("wrong", duration_s=0.3)).at_s - before_s >= 0.3


def test_questionnaire_without_session_language_is_refused(bench, watched, output):
    italian = Bench(watched, Equipment(output, {}), replace(texts_in("en", {}), language="it"))
    with pytest.raises(InvalidParameter, match="item 'ATT1': found no texts in 'it', expected texts in one of"):
        italian.answer(PAGE)
