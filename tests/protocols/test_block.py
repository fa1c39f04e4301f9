"""Blocks: several tracks, lost trials, rests and feedback."""

from collections import Counter
from dataclasses import replace

import catalogue
import numpy as np
import pytest
from examples import examples
from hypothesis import given, strategies as st
from memory import Memory

from tactometry.errors import InvalidParameter
from tactometry.protocols import Block, Condition, ConstantStimuli, Track, YesNo
from tactometry.protocols.block import run_block
from tactometry.protocols.block_state import BlockOptions, BlockState, Slot
from tactometry.protocols.tasks.task import Reply, TrialOutcome
from tactometry.session.answer import Chosen
from tactometry.session.request import Choose, Press, Record, Show
from tactometry.session.run import run


def lived(protocol, seed=1):
    memory = Memory()
    ended = run(protocol, catalogue.simulated(seed), memory)
    return ended, memory


def two_tracks(**how):
    condition = Condition({}, "tone", "dB re 1 V", catalogue.TOUCHES["press"])
    rules = {"a": ConstantStimuli((10.0, 20.0), 10), "b": ConstantStimuli((30.0,), 20)}
    tracks = tuple(Track(condition, rule, name) for name, rule in rules.items())
    return Block(tracks, catalogue.TASKS["yes_no"], BlockOptions(**how))


def test_balanced_interleaving_presents_every_track_once_a_round():
    _, memory = lived(run_block(two_tracks(interleaving="balanced"), 1, 1, np.random.default_rng(1)))
    order = [trial.track for trial in memory.trials]
    assert all(set(order[n : n + 2]) == {"a", "b"} for n in range(0, 40, 2))


def test_rests_follow_valid_trial_count_except_at_end():
    _, memory = lived(run_block(two_tracks(rest_after=10), 1, 1, np.random.default_rng(1)))
    assert sum(isinstance(request, Show) for request, _ in memory.entries) == 3


def test_rests_follow_elapsed_time_since_last_rest():
    _, memory = lived(run_block(two_tracks(rest_every_s=10.0), 1, 1, np.random.default_rng(1)))
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
    protocol = run_block(two_tracks(rest_after=10), 1, 1, np.random.default_rng(1))
    memory = Memory()
    run(protocol, Losing({1, 12}), memory)
    assert [trial.valid for trial in memory.trials].count(False) == 2
    assert sum(isinstance(request, Show) for request, _ in memory.entries) == 3


def test_rest_counts_down_before_it_can_end():
    _, memory = lived(run_block(two_tracks(rest_after=10, rest_s=30.0), 1, 1, np.random.default_rng(1)))
    shown = [(request.message, request.duration_s) for request, _ in memory.entries if isinstance(request, Show)]
    assert shown == [("resting", 30.0), ("rest", None)] * 3


def test_block_is_aborted_when_time_is_over():
    ((first, second), _), _ = lived(run_block(two_tracks(longest_s=10.0), 1, 1, np.random.default_rng(1)))
    assert {first.ending, second.ending} == {"aborted"}


def test_feedback_says_whether_the_answer_was_right():
    _, memory = lived(run_block(two_tracks(feedback=True), 1, 1, np.random.default_rng(1)))
    said = [request.message for request, _ in memory.entries if isinstance(request, Show)]
    assert said == ["right" if trial.correct else "wrong" for trial in memory.trials if trial.valid]


TWICE = ConstantStimuli(levels=(10.0,), repeats=2)


class Losing:
    """A rig that loses the touches of these numbers (from 1)."""

    def __init__(self, lost):
        self._rig, self._lost, self._n = catalogue.simulated(), lost, 0

    def answer(self, request):
        answer = self._rig.answer(request)
        if not isinstance(request, Press):
            return answer
        self._n += 1
        return replace(answer, valid=self._n not in self._lost)

    def __getattr__(self, name):
        return getattr(self._rig, name)


@given(lost=st.sets(st.integers(1, 48), max_size=12))
@examples(30, deadline=None)
def test_lost_trials_are_repeated_unless_track_aborts(lost):
    memory = Memory()
    block = two_tracks(catch_rate=0.25)
    tracks, next_trial = run(run_block(block, 1, 1, np.random.default_rng(2)), Losing(lost), memory)
    assert next_trial == 1 + max(trial.trial for trial in memory.trials)
    attempts = Counter((trial.trial, trial.attempt) for trial in memory.trials)
    assert set(attempts.values()) == {1}
    for track in tracks:
        felt = [t.level for t in memory.trials if t.track == track.name and t.valid and not t.catch]
        asked_for = block.tracks[tracks.index(track)].procedure.begin().order
        assert track.ending == "aborted" or sorted(felt) == sorted(asked_for)
        owed = {t.trial for t in memory.trials if t.track == track.name} - {
            t.trial for t in memory.trials if t.track == track.name and t.valid
        }
        assert track.ending == "aborted" or not owed


class Saying(Losing):
    """A rig whose participant gives these answers to yes or no."""

    def __init__(self, lost, options):
        super().__init__(lost)
        self._options = iter(options)

    def answer(self, request):
        answer = super().answer(request)
        return replace(answer, option=next(self._options)) if isinstance(request, Choose) else answer


def test_repeated_trial_counts_for_the_ending():
    track = replace(catalogue.block("yes_no", "constant_stimuli", "press").tracks[0], procedure=TWICE)
    (track,), _ = run(
        run_block(Block((track,), YesNo()), 1, 1, np.random.default_rng(2)), Saying({2}, [1, 0]), Memory()
    )
    assert (track.procedure.ending, track.ending) == ("trials", "trials")


@pytest.mark.parametrize("task", ["rating", "adjustment", "preference"])
def test_tasks_without_threshold_never_end_censored(task):
    block = catalogue.block(task, "constant_stimuli", "press")
    (track,), _ = run(run_block(block, 1, 1, np.random.default_rng(2)), catalogue.simulated(), Memory())
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
