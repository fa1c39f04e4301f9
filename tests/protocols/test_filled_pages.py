"""Questionnaire pages: going back, and replay with other pages."""

import numpy as np
import pytest
from study_texts import TUTORIAL, wired

from tactometry.errors import Diverged
from tactometry.protocols.session import pages
from tactometry.protocols.tasks.rating import fill_in
from tactometry.questionnaire import load, shipped_names
from tactometry.session.answer import Done, Filled, Marked
from tactometry.session.replay import Replay
from tactometry.session.request import Fill, Show, Wait
from tactometry.session.run import replay

MINI = load("attrakdiff-mini")


def filled(values, *, back=False):
    return Filled(tuple(values), 0.0, 1.0, back=back)


def answered(form, *answers):
    """Return the requested pages and the final replies."""
    course = fill_in(form, np.random.default_rng(0), shuffled=False)
    page = next(course)
    asked = [page, *(course.send(answer) for answer in answers[:-1])]
    with pytest.raises(StopIteration) as end:
        course.send(answers[-1])
    return asked, end.value.value


def test_repeated_page_keeps_marks_and_uses_last_answers():
    ones, twos, some = filled([1.0] * 5), filled([2.0] * 5), filled([3.0, None, None, None, None], back=True)
    asked, replies = answered(MINI, ones, some, twos, filled([4.0] * 5))
    assert [(page.page, page.n_pages) for page in asked] == [(1, 2), (2, 2), (1, 2), (2, 2)]
    assert [page.given for page in asked] == [(), (), ones.values, some.values]
    assert [reply.response for reply in replies] == [2.0] * 5 + [4.0] * 5
    assert [reply.item for reply in replies] == [item.id for item in MINI.items]


def test_replay_ignores_page_layout():
    answers = [filled([1.0] * 5), filled([2.0] * 5)]
    asked, _ = answered(MINI, *answers)
    older = [Fill(page.form, page.questions, page.low, page.high, page.steps) for page in asked]
    entries = list(zip(older, answers, strict=True))
    assert replay(fill_in(MINI, np.random.default_rng(0), shuffled=False), Replay(entries))


def pages_of(text):
    return list(pages(wired(TUTORIAL + text).parts(1, np.random.default_rng(0))))


def test_questionnaire_has_own_page_and_is_not_counted():
    shown = pages_of('[inquiries.end]\nform = "sus"\n')
    assert [page.message for page in shown] == ["welcome", "instructions_yes_no", "block", "block", "questions", "end"]
    assert [(page.values["part"], page.values["n_parts"]) for page in shown[2:4]] == [(1, 2), (2, 2)]
    assert shown[4].values["n_questions"] == 10


def test_practice_is_not_counted_as_part():
    shown = pages_of("[practice]\nlevels = [40]\nn_correct = 1\nn_of = 1\nn_trials = 4\n")
    assert [page.values.get("part") for page in shown if page.message == "block"] == [1, 2]


def course_of(*requests):
    for request in requests:  # noqa: UP028 - an iterator alone takes no answers
        yield request


LATER, OTHERS = (Show("a"), Wait(1.0), Show("b"), Wait(2.0)), (Wait(1.0), Show("new"), Wait(2.0))
EARLIER = (Show("b"), Wait(1.0), Wait(2.0))


@pytest.mark.parametrize("requests", [LATER, OTHERS, EARLIER], ids=["later", "others", "earlier"])
def test_replay_accepts_pages_in_other_places(requests):
    recorded = (Show("a"), Show("b"), Wait(1.0), Show("c"), Wait(2.0))
    entries = [(request, Done(float(n))) for n, request in enumerate(recorded)]
    replay(course_of(*requests), Replay(entries))


def test_replay_continues_when_last_page_was_removed():
    recording = Replay([(Wait(1.0), Done(3.0)), (Show("old"), Done(4.0))])
    assert replay(course_of(Wait(1.0), Wait(2.0)), recording, complete=False) is None
    assert recording.n_left == 0


def test_replay_diverges_on_other_request_despite_pages():
    entries = [(request, Done(1.0)) for request in (Show("a"), Wait(1.0), Show("b"), Wait(3.0))]
    message = "line 4: Wait.duration_s: the recording has 3.0, but the protocol requests 2.0"
    with pytest.raises(Diverged, match=message):
        replay(course_of(Wait(1.0), Wait(2.0)), Replay(entries))


def test_new_page_in_replay_has_previous_time():
    recording = Replay([(Wait(1.0), Done(3.0)), (Wait(2.0), Done(6.0))])
    assert recording.answer(Wait(1.0)) == Done(3.0)
    assert recording.answer(Show("new")) == Done(3.0)


@pytest.mark.parametrize(("form", "given"), [("attrakdiff-mini", (1.0, None)), ("sus", ())])
def test_marks_are_restored_on_their_own_page_only(form, given):
    page = Fill(form, ("a", "b"), 1.0, 7.0, 7)
    recording = Replay([], marked=Marked("attrakdiff-mini", (1.0, None), 2.0))
    assert recording.taken_up(page).given == given


@pytest.mark.parametrize("name", shipped_names())
def test_questionnaire_stem_exists_in_every_language(name):
    assert set(load(name).languages) <= set(load(name).stem)
