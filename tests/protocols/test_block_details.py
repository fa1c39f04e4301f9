"""Blocks: delivered levels, repeated trials and endings."""

from dataclasses import replace
from functools import partial

import catalogue
import numpy as np
import pytest
from memory import Memory

from tactometry.errors import LimitExceeded
from tactometry.observers.finger import SimulatedFinger
from tactometry.protocols import ConstantStimuli, Staircase
from tactometry.protocols.block import run_block
from tactometry.protocols.block_state import catch_schedule
from tactometry.safety.limits import Limits
from tactometry.session.answer import Touched
from tactometry.session.request import Choose, Record, Slide
from tactometry.session.run import run

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


class Clipping:
    """A rig that delivers 3 dB less and loses the first `n_lost` touches."""

    def __init__(self, n_lost=0):
        self._rig, self.n_lost = rig(), n_lost

    def answer(self, request):
        touched = self._rig.answer(request)
        if not isinstance(request, Slide):
            return touched
        self.n_lost -= 1
        level = None if touched.level_delivered is None else touched.level_delivered - 3.0
        return replace(touched, level_delivered=level, valid=self.n_lost < 0)

    def __getattr__(self, name):
        return getattr(self._rig, name)


def test_procedure_learns_delivered_level():
    memory = Memory()
    course = a_block(procedure="staircase_1_up_1_down")
    (track,), _ = run(course, Clipping(), memory)
    delivered = [trial.level_delivered for trial in memory.trials if not trial.catch]
    assert list(track.procedure.delivered) == delivered
    assert all(trial.level_delivered == trial.level - 3.0 for trial in memory.trials if not trial.catch)


def test_staircase_repeats_invalid_touch_at_once():
    memory = Memory()
    course = a_block(procedure="staircase_1_up_1_down")
    run(course, Clipping(n_lost=2), memory)
    first = [(trial.trial, trial.attempt, trial.valid, trial.response is None) for trial in memory.trials[:3]]
    assert first == [(1, 1, False, True), (1, 2, False, True), (1, 3, True, False)]
    assert len({trial.level for trial in memory.trials[:3]}) == 1


def test_constant_stimuli_repeat_invalid_touches_at_end():
    memory = Memory()
    (track,), next_trial = run(a_block(), Clipping(n_lost=2), memory)
    lost, again = memory.trials[:2], memory.trials[-2:]
    assert [(trial.trial, trial.attempt, trial.valid) for trial in lost] == [(1, 1, False), (2, 1, False)]
    assert [(trial.trial, trial.attempt, trial.valid) for trial in again] == [(1, 2, True), (2, 2, True)]
    assert [trial.level for trial in again] == [trial.level for trial in lost]
    assert track.ending == "trials"
    assert next_trial == 1 + len({trial.trial for trial in memory.trials})
    felt = sorted(trial.level for trial in memory.trials if trial.valid and not trial.catch)
    assert felt == sorted(catalogue.PROCEDURES["constant_stimuli"].begin().order)


def test_block_is_aborted_when_no_touch_is_valid():
    memory = Memory()
    (track,), _ = run(a_block(), Clipping(n_lost=10**6), memory)
    assert track.ending == "aborted"
    assert [trial.trial for trial in memory.trials] == [1, 2, 3, 4, 5]


def test_catch_trials_occur_once_per_group():
    schedule = catch_schedule(0.25, np.random.default_rng())
    groups = [[next(schedule) for _ in range(4)] for _ in range(200)]
    assert all(sum(group) == 1 for group in groups)
    assert {group.index(True) for group in groups} == {0, 1, 2, 3}


def test_constant_stimuli_repeats_have_different_orders():
    order = ConstantStimuli((1.0, 2.0, 3.0, 4.0), repeats=50).begin(np.random.default_rng()).order
    assert len({order[n : n + 4] for n in range(0, 200, 4)}) > 1


def test_a_catch_trial_delivers_nothing():
    touched = rig().answer(replace(SLIDE, level=None))
    assert isinstance(touched, Touched)
    assert (touched.level_delivered, touched.digest) == (None, None)


def test_forced_choice_row_uses_target_and_first_onset():
    memory = Memory()
    course = a_block("forced_choice")
    run(course, rig(finger=SimulatedFinger(waver_cv=0.0)), memory)
    answers = [(request, answer) for request, answer in memory.entries if isinstance(request, Slide | Record)]
    for n in range(0, len(answers), 3):
        touches, trial = [answer for _, answer in answers[n : n + 2]], answers[n + 2][0].trial
        assert trial.force_mean_n == touches[trial.target - 1].force_mean_n
        assert trial.onset_s == touches[0].onset_s
    assert {trial.target for trial in memory.trials} == {1, 2}


def test_invalid_interval_ends_trial_without_question():
    memory = Memory()
    course = a_block("forced_choice")
    run(course, Clipping(n_lost=1), memory)
    assert [type(request).__name__ for request, _ in memory.entries[:4]] == ["Slide", "Record", "Slide", "Slide"]


class Refusing(Clipping):
    """A rig whose first answer the experimenter declares invalid."""

    def __init__(self):
        super().__init__()
        self.n_answers = 0

    def answer(self, request):
        answer = super().answer(request)
        if not isinstance(request, Choose):
            return answer
        self.n_answers += 1
        return replace(answer, valid=self.n_answers > 1)


@pytest.mark.parametrize("task", ["yes_no", "forced_choice"])
def test_invalid_answer_is_not_scored_and_repeated(task):
    memory = Memory()
    run(a_block(task), Refusing(), memory)
    first, second = memory.trials[0], memory.trials[-1]
    assert (first.valid, first.correct, first.attempt) == (False, None, 1)
    assert (second.valid, second.attempt, second.trial, second.level) == (True, 2, first.trial, first.level)


def test_a_censored_run_with_reversals_has_no_threshold():
    rule = Staircase(start=10.0, steps=(4.0,), low=0.0, high=40.0, n_down=1, n_reversals=20, n_at_bound=3)
    for answer in (1, 0, 1, 0, 1, 0, 1, 1, 1, 1, 1, 1, 1):
        rule = rule if rule.finished else rule.after(answer)
    assert len(rule.reversals) >= 4
    assert (rule.ending, rule.threshold) == ("censored_below", None)


def test_responses_at_bound_count_only_in_succession():
    rule = Staircase(start=40.0, steps=(2.0,), low=0.0, high=40.0, n_down=1, n_reversals=99, n_at_bound=3)
    for answer in (0, 0, 1, 0, 0, 0):
        assert rule.ending is None
        rule = rule.after(answer)
    assert rule.ending is None
    assert rule.after(0).ending == "censored_above"
