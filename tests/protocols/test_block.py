"""Blocks: several tracks, delivered levels, lost trials, rests, feedback and endings."""

from collections import Counter
from dataclasses import replace
from functools import partial

import catalogue
import numpy as np
import pytest
from examples import examples
from hypothesis import given, strategies as st
from memory import Memory

from tactometry.errors import InvalidParameter, LimitExceeded
from tactometry.observers.finger import SimulatedFinger
from tactometry.protocols import Block, Condition, ConstantStimuli, Track, YesNo
from tactometry.protocols.block import run_block
from tactometry.protocols.block_state import BlockOptions, BlockState, Slot, catch_schedule
from tactometry.protocols.tasks.task import Reply, TrialOutcome
from tactometry.safety.limits import Limits
from tactometry.session.answer import Chosen, Touched
from tactometry.session.request import Choose, Press, Record, Show, Slide
from tactometry.session.run import run


def lived(protocol, rig=None):
    memory = Memory()
    ended = run(protocol, rig or catalogue.simulated(1), memory)
    return ended, memory


def two_tracks(**how):
    condition = Condition({}, "tone", "dB re 1 V", catalogue.TOUCHES["press"])
    rules = {"a": ConstantStimuli((10.0, 20.0), 10), "b": ConstantStimuli((30.0,), 20)}
    tracks = tuple(Track(condition, rule, name) for name, rule in rules.items())
    return Block(tracks, catalogue.TASKS["yes_no"], BlockOptions(**how))


def blocks_of(*, rig=None, **how):
    return lived(run_block(two_tracks(**how), 1, 1, np.random.default_rng(1)), rig)


def pages(memory):
    return [request.message for request, _ in memory.entries if isinstance(request, Show)]


def test_balanced_interleaving_presents_every_track_once_a_round():
    _, memory = blocks_of(interleaving="balanced")
    order = [trial.track for trial in memory.trials]
    assert all(set(order[n : n + 2]) == {"a", "b"} for n in range(0, 40, 2))


def test_rests_follow_valid_trial_count_except_at_end():
    _, memory = blocks_of(rest_after=10)
    assert len(pages(memory)) == 3


def test_rests_follow_elapsed_time_since_last_rest():
    _, memory = blocks_of(rest_every_s=10.0)
    rested_s, begun_s = [], []
    for request, answer in memory.entries:
        if isinstance(request, Show):
            rested_s.append(answer.at_s)
        if isinstance(request, Record):
            begun_s.append(request.trial.onset_s)
    assert len(rested_s) >= 2
    begins = [begun_s[0], *(next(s for s in begun_s if s > rest) for rest in rested_s)]
    for begin, rest in zip(begins, rested_s, strict=False):
        last = max(s for s in begun_s if s < rest)
        assert last - begin >= 10.0
        assert all(s - begin < 10.0 for s in begun_s if begin <= s < last)


def test_lost_trials_do_not_count_towards_rests():
    _, memory = blocks_of(rest_after=10, rig=Faulty({1, 12}))
    assert [trial.valid for trial in memory.trials].count(False) == 2
    assert len(pages(memory)) == 3


def test_rest_counts_down_before_it_can_end():
    _, memory = blocks_of(rest_after=10, rest_s=30.0)
    shown = [(request.message, request.duration_s) for request, _ in memory.entries if isinstance(request, Show)]
    assert shown == [("resting", 30.0), ("rest", None)] * 3


def test_block_is_aborted_when_time_is_over():
    ((first, second), _), _ = blocks_of(longest_s=10.0)
    assert {first.ending, second.ending} == {"aborted"}


def test_feedback_says_whether_the_answer_was_right():
    _, memory = blocks_of(feedback=True)
    assert pages(memory) == ["right" if trial.correct else "wrong" for trial in memory.trials if trial.valid]


TWICE = ConstantStimuli(levels=(10.0,), repeats=2)


class Faulty:
    """A rig that loses touches and answers of these numbers (from 1), shifts levels, or gives these answers."""

    def __init__(self, lost=(), *, lost_answers=(), shift_db=0.0, options=None):
        self._rig, self._counts, self._shift_db = catalogue.simulated(7), Counter(), shift_db
        self._lost, self._options = {"touch": lost, "answer": lost_answers}, options and iter(options)

    def answer(self, request):
        answer = self._rig.answer(request)
        if not isinstance(request, Press | Slide | Choose):
            return answer
        kind = "answer" if isinstance(request, Choose) else "touch"
        self._counts[kind] += 1
        answer = replace(answer, valid=self._counts[kind] not in self._lost[kind])
        if kind == "answer":
            return replace(answer, option=next(self._options)) if self._options else answer
        delivered = answer.level_delivered
        return replace(answer, level_delivered=None if delivered is None else delivered + self._shift_db)

    def __getattr__(self, name):
        return getattr(self._rig, name)


@given(lost=st.sets(st.integers(1, 48), max_size=12))
@examples(30, deadline=None)
def test_lost_trials_are_repeated_unless_track_aborts(lost):
    block = two_tracks(catch_rate=0.25)
    (tracks, next_trial), memory = lived(run_block(block, 1, 1, np.random.default_rng(2)), Faulty(lost))
    assert next_trial == 1 + max(trial.trial for trial in memory.trials)
    attempts = Counter((trial.trial, trial.attempt) for trial in memory.trials)
    assert set(attempts.values()) == {1}
    for track, given_ in zip(tracks, block.tracks, strict=True):
        own = [trial for trial in memory.trials if trial.track == track.name]
        if track.ending != "aborted":
            valid = [trial for trial in own if trial.valid]
            assert sorted(t.level for t in valid if not t.catch) == sorted(given_.procedure.begin().order)
            assert {t.trial for t in own} == {t.trial for t in valid}


def test_repeated_trial_counts_for_the_ending():
    track = replace(catalogue.block("yes_no", "constant_stimuli", "press").tracks[0], procedure=TWICE)
    course = run_block(Block((track,), YesNo()), 1, 1, np.random.default_rng(2))
    ((track,), _), _ = lived(course, Faulty({2}, options=[1, 0]))
    assert (track.procedure.ending, track.ending) == ("trials", "trials")


@pytest.mark.parametrize("task", ["rating", "adjustment", "preference"])
def test_tasks_without_threshold_never_end_censored(task):
    block = catalogue.block(task, "constant_stimuli", "press")
    ((track,), _), _ = lived(run_block(block, 1, 1, np.random.default_rng(2)))
    assert track.ending == "trials"


@pytest.mark.parametrize(
    ("how", "sentence"),
    [
        ({"tracks": ()}, "Block.tracks: found none, expected at least one"),
        ({"catch_rate": 0.6}, "BlockOptions.catch_rate: found 0.6, expected a number from 0 to 0.5"),
        ({"interleaving": "rounds"}, "BlockOptions.interleaving: found 'rounds', expected one of random, balanced"),
        ({"n_attempts": 0}, "BlockOptions.n_attempts: found 0, expected a whole number, at least 1"),
        ({"rest_s": 0.0}, "BlockOptions.rest_s: found 0.0, expected a finite number above 0"),
    ],
)
def test_an_impossible_block_is_refused(how, sentence):
    with pytest.raises(InvalidParameter, match=sentence):
        replace(two_tracks(), **how) if "tracks" in how else two_tracks(**how)


def test_block_factors_are_shared_by_all_tracks():
    conditions = (
        Condition({"force_n": 1.0, "frequency_hz": hz}, "tone", "dB re 1 V", catalogue.TOUCHES["press"])
        for hz in (60.0, 60.0, 240.0)
    )
    tracks = tuple(Track(condition, ConstantStimuli((10.0,), 1)) for condition in conditions)
    assert Block(tracks, YesNo()).factors == {"force_n": 1.0}


LOST = TrialOutcome((), replies=(Reply(Chosen(1, 0.0, 0.0, valid=False)),))
KEPT = TrialOutcome((), replies=(Reply(Chosen(1, 0.0, 0.0), 1.0, correct=True),), success=True)


def aborted_after(*came):
    block = two_tracks(n_attempts=2)
    standing = BlockState(block.options, block.tracks, 1)
    for asked, outcome in came:
        standing = standing.after(asked, outcome)
    return [track.aborted for track in standing.tracks]


def test_valid_trial_resets_count_of_lost_trials():
    first, second, third = (Slot(0, trial, 10.0) for trial in (1, 2, 3))
    assert aborted_after((first, LOST), (second, KEPT), (third, LOST)) == [False, False]
    assert aborted_after((first, LOST), (second, LOST)) == [True, False]


def test_attempts_of_one_trial_are_limited():
    asked = Slot(0, 1, 10.0)
    assert aborted_after((asked, LOST), (Slot(0, 2, 20.0), KEPT), (replace(asked, attempt=2), LOST)) == [True, False]


rig = partial(catalogue.simulated, 7)
SLIDE = Slide("tone", 20.0, 0.2, 1.0, 0.2, 0.5, 5.0, 0.05)


def a_block(task="yes_no", procedure="constant_stimuli"):
    return run_block(catalogue.block(task, procedure), 1, 1, np.random.default_rng(1))


def test_simulated_rig_checks_signals_against_limits():
    with pytest.raises(LimitExceeded, match="found a peak of"):
        rig(limits=Limits(voltage_peak_v=1.0)).answer(SLIDE)


class Noting(catalogue.Loudness):
    def __init__(self):
        self.contacts = []

    def sensation_db(self, signal, contact):
        self.contacts.append(contact)
        return super().sensation_db(signal, contact)


def test_sensation_uses_measured_force_and_speed():
    noting = Noting()
    touched = rig(sensation=noting).answer(SLIDE)
    (contact,) = noting.contacts
    assert contact.force_n == pytest.approx(touched.force_mean_n, abs=1e-6)
    assert contact.speed_m_per_s == pytest.approx(touched.speed_mean_m_per_s, abs=1e-6)
    assert contact.force_n != SLIDE.target_n
    assert contact.speed_m_per_s != SLIDE.speed_m_per_s


def test_holding_the_force_and_playing_take_their_time():
    simulated_rig = rig()
    first, second = simulated_rig.answer(SLIDE), simulated_rig.answer(SLIDE)
    assert first.onset_s == SLIDE.hold_s
    assert second.onset_s - first.onset_s == pytest.approx(SLIDE.hold_s + SLIDE.duration_s)


def test_touch_is_invalid_when_force_leaves_band():
    assert not rig(finger=SimulatedFinger(waver_cv=0.9)).answer(SLIDE).valid


def test_procedure_learns_delivered_level():
    ((track,), _), memory = lived(a_block(procedure="staircase_1_up_1_down"), Faulty(shift_db=-3.0))
    trials = [trial for trial in memory.trials if not trial.catch]
    assert list(track.procedure.delivered) == [trial.level_delivered for trial in trials]
    assert all(trial.level_delivered == trial.level - 3.0 for trial in trials)


def test_staircase_repeats_invalid_touch_at_once():
    _, memory = lived(a_block(procedure="staircase_1_up_1_down"), Faulty({1, 2}))
    first = [(trial.trial, trial.attempt, trial.valid, trial.response is None) for trial in memory.trials[:3]]
    assert first == [(1, 1, False, True), (1, 2, False, True), (1, 3, True, False)]
    assert len({trial.level for trial in memory.trials[:3]}) == 1


def test_constant_stimuli_repeat_invalid_touches_at_end():
    _, memory = lived(a_block(), Faulty({1, 2}))
    lost, again = memory.trials[:2], memory.trials[-2:]
    assert [(trial.trial, trial.attempt, trial.valid) for trial in lost] == [(1, 1, False), (2, 1, False)]
    assert [(trial.trial, trial.attempt, trial.valid) for trial in again] == [(1, 2, True), (2, 2, True)]
    assert [trial.level for trial in again] == [trial.level for trial in lost]


def test_block_is_aborted_when_no_touch_is_valid():
    ((track,), _), memory = lived(a_block(), Faulty(range(1, 10**6)))
    assert track.ending == "aborted"
    assert [trial.trial for trial in memory.trials] == [1, 2, 3, 4, 5]


def test_catch_trials_occur_once_per_group():
    schedule = catch_schedule(0.25, np.random.default_rng())
    groups = [[next(schedule) for _ in range(4)] for _ in range(200)]
    assert all(sum(group) == 1 for group in groups)
    assert {group.index(True) for group in groups} == {0, 1, 2, 3}


def test_a_catch_trial_delivers_nothing():
    touched = rig().answer(replace(SLIDE, level=None))
    assert isinstance(touched, Touched)
    assert (touched.level_delivered, touched.digest) == (None, None)


def test_forced_choice_row_uses_target_and_first_onset():
    _, memory = lived(a_block("forced_choice"), rig(finger=SimulatedFinger(waver_cv=0.0)))
    answers = [(request, answer) for request, answer in memory.entries if isinstance(request, Slide | Record)]
    for n in range(0, len(answers), 3):
        touches, trial = [answer for _, answer in answers[n : n + 2]], answers[n + 2][0].trial
        assert trial.force_mean_n == touches[trial.target - 1].force_mean_n
        assert trial.onset_s == touches[0].onset_s
    assert {trial.target for trial in memory.trials} == {1, 2}


def test_invalid_interval_ends_trial_without_question():
    _, memory = lived(a_block("forced_choice"), Faulty({1}))
    assert [type(request).__name__ for request, _ in memory.entries[:4]] == ["Slide", "Record", "Slide", "Slide"]


@pytest.mark.parametrize("task", ["yes_no", "forced_choice"])
def test_invalid_answer_is_not_scored_and_repeated(task):
    _, memory = lived(a_block(task), Faulty(lost_answers={1}))
    first, second = memory.trials[0], memory.trials[-1]
    assert (first.valid, first.correct, first.attempt) == (False, None, 1)
    assert (second.valid, second.attempt, second.trial, second.level) == (True, 2, first.trial, first.level)
