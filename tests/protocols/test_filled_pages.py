"""Pages of a questionnaire: what comes of going back, and of pages that a recording shows in other places."""

import numpy as np
import pytest
from study_texts import TUTORIAL

from tactometry.errors import Diverged
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.study_file import parse
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
    """The pages that come, and the replies in the end."""
    course = fill_in(form, np.random.default_rng(0), shuffled=False)
    page = next(course)
    asked = [page, *(course.send(answer) for answer in answers[:-1])]
    with pytest.raises(StopIteration) as end:
        course.send(answers[-1])
    return asked, end.value.value


def test_a_page_that_comes_again_has_its_marks_and_counts_as_it_was_left_last():
    ones, twos, some = filled([1.0] * 5), filled([2.0] * 5), filled([3.0, None, None, None, None], back=True)
    asked, replies = answered(MINI, ones, some, twos, filled([4.0] * 5))
    assert [(page.page, page.n_pages) for page in asked] == [(1, 2), (2, 2), (1, 2), (2, 2)]
    assert [page.given for page in asked] == [(), (), ones.values, some.values]
    assert [reply.response for reply in replies] == [2.0] * 5 + [4.0] * 5
    assert [reply.item for reply in replies] == [item.id for item in MINI.items]


def test_how_a_page_is_shown_is_no_part_of_what_a_recording_is_held_against():
    asked, _ = answered(MINI, filled([1.0] * 5), filled([2.0] * 5))
    older = [Fill(page.form, page.questions, page.low, page.high, page.steps) for page in asked]
    answers = [filled([1.0] * 5), filled([2.0] * 5)]
    entries = list(zip(older, answers, strict=True))
    assert replay(fill_in(MINI, np.random.default_rng(0), shuffled=False), Replay(entries))


def test_a_questionnaire_has_a_page_of_its_own_where_it_comes_and_is_no_part_that_is_counted():
    study = parse(f'{TUTORIAL}[inquiries.end]\nform = "sus"\n'.encode(), "s.toml")
    shown = list(pages(wire(study, "s.toml").parts(1, np.random.default_rng(0))))
    assert [page.message for page in shown] == ["welcome", "instructions_yes_no", "block", "block", "questions", "end"]
    assert [(page.values["part"], page.values["n_parts"]) for page in shown[2:4]] == [(1, 2), (2, 2)]
    assert shown[4].values["n_questions"] == 10


def test_practice_is_no_part_that_is_counted():
    practice = "[practice]\nlevels = [40]\nn_correct = 1\nn_of = 1\nn_trials = 4\n"
    shown = list(pages(wire(parse(f"{TUTORIAL}{practice}".encode(), "s"), "s").parts(1, np.random.default_rng(0))))
    assert [page.values.get("part") for page in shown if page.message == "block"] == [1, 2]


def course_of(*requests):
    for request in requests:  # noqa: UP028 - an iterator alone takes no answers
        yield request


@pytest.mark.parametrize(
    "asked",
    [
        (Show("a"), Wait(1.0), Show("b"), Wait(2.0)),
        (Wait(1.0), Show("new"), Wait(2.0)),
        (Show("b"), Wait(1.0), Wait(2.0)),
    ],
    ids=["later", "others", "earlier"],
)
def test_a_recording_whose_pages_stood_elsewhere_replays(asked):
    recorded = (Show("a"), Show("b"), Wait(1.0), Show("c"), Wait(2.0))
    entries = [(request, Done(float(n))) for n, request in enumerate(recorded)]
    replay(course_of(*asked), Replay(entries))


def test_a_recording_that_stopped_at_a_page_which_is_shown_no_more_goes_on():
    recording = Replay([(Wait(1.0), Done(3.0)), (Show("old"), Done(4.0))])
    assert replay(course_of(Wait(1.0), Wait(2.0)), recording, complete=False) is None
    assert recording.n_left == 0


def test_a_recording_with_another_request_diverges_however_its_pages_stand():
    entries = [(request, Done(1.0)) for request in (Show("a"), Wait(1.0), Show("b"), Wait(3.0))]
    with pytest.raises(Diverged, match=r"line 4: Wait.duration_s: the recording holds 3.0, the protocol asks for 2.0"):
        replay(course_of(Wait(1.0), Wait(2.0)), Replay(entries))


def test_a_page_that_is_not_in_the_recording_has_the_time_of_what_was_before():
    recording = Replay([(Wait(1.0), Done(3.0)), (Wait(2.0), Done(6.0))])
    assert recording.answer(Wait(1.0)) == Done(3.0)
    assert recording.answer(Show("new")) == Done(3.0)


@pytest.mark.parametrize(("form", "given"), [("attrakdiff-mini", (1.0, None)), ("sus", ())])
def test_marks_are_taken_up_by_the_page_that_they_stood_on_alone(form, given):
    page = Fill(form, ("a", "b"), 1.0, 7.0, 7)
    recording = Replay([], marked=Marked("attrakdiff-mini", (1.0, None), 2.0))
    assert recording.taken_up(page).given == given


@pytest.mark.parametrize("name", shipped_names())
def test_every_shipped_questionnaire_says_in_each_of_its_languages_what_it_is_about(name):
    assert set(load(name).languages) <= set(load(name).stem)
