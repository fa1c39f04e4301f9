"""Answers given at page onset, before the program has its onset time."""

import os
import subprocess
import sys
import time

import pytest
from patience import LONGEST_WAIT_S

from tactometry.rigs.pages.page import PAPER
from tactometry.session.request import Choose, Enter, Wait

N_PAGES, PATIENCE_S = 50, 5.0
HOW_MUCH, FELT, BETWEEN = Enter("how_strong", 0.0), Choose("felt", (0, 1), ("no", "yes")), Wait(0.01)
OF_NUMBER_PX = (640, 164)
"""A point on the border of the number box, blank on the page in between."""
OF_NO = (-0.23, -0.06)
"""A point in the box of the answer "no", in screen heights from the centre."""


@pytest.fixture(autouse=True, params=["quiet", pytest.param("busy", marks=pytest.mark.slow)])
def machine(request):
    n_busy = (os.cpu_count() or 1) + 1 if request.param == "busy" else 0
    busy = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(n_busy)]
    yield
    for process in busy:
        process.kill()
        process.wait()


def stands(hands, *, within_s=LONGEST_WAIT_S, wanted=True):
    deadline_s = time.perf_counter() + within_s
    paper = tuple(bytes.fromhex(PAPER[1:]))
    while (hands.sees_at(*OF_NUMBER_PX) != paper) != wanted:
        if time.perf_counter() > deadline_s:
            return not wanted
    return wanted


def type_number(hands, number):
    """Type a number at page onset, then 0 if lost keys keep the page open."""
    assert stands(hands)
    for key in (*str(number), "Return"):
        hands.tap(key, hold_s=0.0)
    while stands(hands, within_s=PATIENCE_S, wanted=False):
        hands.tap("0")
        hands.tap("Return")


def test_number_typed_at_page_onset_is_complete(bench, hands, in_background):
    said = [12 + n for n in range(N_PAGES)]

    def type_all():
        for number in said:
            type_number(hands, number)

    bench.answer(BETWEEN)
    in_background(type_all)
    entered = []
    for _ in said:
        entered.append(bench.answer(HOW_MUCH))
        bench.answer(BETWEEN)
    assert [each.value for each in entered] == said
    assert min(each.latency_s for each in entered) >= 0.0


def test_touch_before_question_is_ignored(bench, hands, participant):
    bench.answer(BETWEEN)
    hands.touch(*OF_NO)
    participant.answers(0.3, "y")
    assert bench.answer(FELT).option == 1
