"""Progress of a session from its journal, against its protocol."""

from functools import reduce

import numpy as np
import pytest
from places import ROOT
from tutorial_session import EXPERIMENT, journal_of

from tactometry.experiments.study.dry_run import duration_s, parts_ahead, plan
from tactometry.protocols import Staircase, WeightedStaircase
from tactometry.records.journal import Entry, read
from tactometry.session.answer import Done, Intervention, Touched
from tactometry.session.event import Event
from tactometry.session.progress import MOST_SHOWN, PartAhead, Progress, TrackProgress
from tactometry.session.request import Intervene, Press, Record, Show
from tactometry.trials.trial import Trial, tally

RECORDED = sorted((ROOT / "tests" / "recorded").glob("*/journals/*[!s].jsonl"))


def after(state, line):
    if isinstance(line, Entry):
        return state.after(*line)
    return state.after_event(line) if isinstance(line, Event) else state


def progress_of(recording):
    return reduce(after, recording.lines, Progress())


def trial(n, level=10.0, *, valid=True, attempt=1, **known):
    return Trial(1, n, {}, "staircase", level, "dB", "yes_no", 1, valid=valid, attempt=attempt, **known)


def recorded(*rows, state=None):
    """Return the progress after rows of one block, 1 s apart."""
    state = state or Progress().after(Show("block", {"block": 1, "n_blocks": 2}), Done(0.0))
    return reduce(lambda state, row: state.after(Record(row), Done(1.0)), rows, state)


def attempts(n):
    return [trial(1, valid=False, attempt=attempt) for attempt in range(1, n + 1)]


@pytest.mark.parametrize("path", RECORDED, ids=lambda path: f"{path.parents[1].name}-{path.stem[12:15]}")
def test_progress_of_recorded_sessions_equals_their_tally(path):
    recording = read(path)
    state = progress_of(recording)
    assert state.tally == tally(recording.trials)
    assert sum(len(track.presented) for track in state.tracks.values()) == state.tally.n_presented
    assert state.over == recording.complete


def test_progress_counts_parts_and_trials_of_the_plan(lived):
    state, parts = progress_of(read(journal_of(lived))), parts_ahead(EXPERIMENT, number=1)
    assert state.n_parts == state.part == len(parts)
    assert [state.n_valid(n) for n in range(1, len(parts) + 1)] == [part.n_trials for part in parts]


def test_time_left_at_start_equals_the_plan():
    blocks, parts = plan(EXPERIMENT, 1), parts_ahead(EXPERIMENT, number=1)
    assert Progress().left_s(parts) == pytest.approx(duration_s(EXPERIMENT, blocks))


def test_time_left_follows_recent_trials_and_ignores_pauses():
    parts = [PartAhead(n_trials=20, lasts_s=100.0), PartAhead(n_trials=10, lasts_s=50.0)]
    times_s = [*np.arange(1, 9) * 2.0, 1016.0]  # a trial in 2 s, then a long pause
    state = Progress().after(Show("block", {"block": 1, "n_blocks": 2}), Done(0.0))
    for n, at_s in enumerate(times_s, 1):
        state = state.after(Record(trial(n)), Done(at_s))
    assert state.left_s(parts) == pytest.approx(2.0 * (20 - 9 + 10))
    assert state.after(Show("end"), Done(1100.0)).left_s(parts) == 0.0


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(
    "rule",
    [
        Staircase(start=20.0, steps=(4.0, 2.0), low=0.0, high=40.0, n_reversals=50, n_trials=200),
        Staircase(start=2.0, steps=(3.0,), low=0.0, high=40.0, n_down=1, n_reversals=50, n_trials=200, n_at_bound=9),
        WeightedStaircase(start=20.0, steps_up=(6.0,), steps_down=(2.0,), low=0.0, high=40.0, n_reversals=50),
    ],
)
def test_reversals_equal_those_of_the_staircase(rule, seed):
    rng, run, track = np.random.default_rng(seed), rule.begin(), TrackProgress()
    n = 0
    while not run.finished:
        n += 1
        row = Trial(1, n, {}, rule.name, run.level, "dB", "yes_no", 1)
        track = track.after(row, aborted=False)
        run = run.after(rng.random() < 1 / (1 + np.exp(6.0 - run.level)))
    # the last reversal appears in the next level
    track = track.after(Trial(1, n + 1, {}, rule.name, run.level, "dB", "yes_no", 1), aborted=False)
    levels = [row.level for row in track.reversals]
    marks = [mark for mark in run.marks if not np.isnan(mark)]
    assert levels == marks or levels == marks[:-1]  # at a bound a reversal repeats the level
    assert len(levels) > 2


def test_constant_stimuli_have_no_reversals():
    track = TrackProgress()
    for n, level in enumerate((1.0, 3.0, 2.0, 4.0, 1.0), 1):
        track = track.after(Trial(1, n, {}, "constant_stimuli", level, "dB", "yes_no", 1), aborted=False)
    assert not track.reversals


def test_catch_and_invalid_trials_move_no_staircase():
    track = TrackProgress()
    rows = (trial(1, 10.0), trial(2, None, catch=True), trial(3, 8.0, valid=False), trial(3, 12.0, attempt=2))
    for row in rows:
        track = track.after(row, aborted=False)
    assert [row.level for row in track.answered] == [10.0, 12.0]


FIVE = [PartAhead(n_attempts=5), PartAhead(n_attempts=5)]


@pytest.mark.parametrize(
    ("n", "warning"),
    [
        (2, None),
        (3, "the last 3 touches did not count: 2 more abort this condition"),
        (4, "the last 4 touches did not count: 1 more aborts this condition"),
    ],
)
def test_track_warns_before_it_is_aborted(n, warning):
    assert recorded(*attempts(n)).warning(FIVE) == warning
    first = recorded(*attempts(1)).warning([PartAhead(n_attempts=3)])
    assert first == "the last touch did not count: 2 more abort this condition"


def test_track_warning_ends_when_track_is_aborted():
    row = trial(1, valid=False, attempt=5)
    state = recorded(*attempts(4)).after(Record(row, "block 1 is aborted"), Done(5.0))
    assert state.warning(FIVE) is None
    assert state.aborted == ("block 1 is aborted",)


def test_valid_touch_or_another_block_ends_the_warning():
    state = recorded(*attempts(4))
    assert recorded(trial(1, attempt=5), state=state).warning(FIVE) is None
    assert state.after(Show("block", {"block": 2, "n_blocks": 2}), Done(9.0)).warning(FIVE) is None


@pytest.mark.parametrize("n", [3, 4])
def test_warning_counts_attempts_at_one_trial(n):
    """Constant stimuli repeat trials at the end of the block."""
    state = recorded(*(row for attempt in attempts(n) for row in (trial(2), attempt)))
    assert (state.track.n_invalid_in_a_row, state.track.n_lost) == (1, n)
    more = {3: "2 more abort", 4: "1 more aborts"}[n]
    assert state.warning(FIVE) == f"one trial did not count in {n} attempts: {more} this condition"


def catch_trial(n, response, *, valid=True):
    return Trial(1, n, {}, "staircase", None, "dB", "yes_no", response, valid=valid, catch=True)


def test_false_alarms_count_valid_catch_trials_only():
    state = recorded(catch_trial(1, 1), catch_trial(2, 0), catch_trial(3, 1, valid=False), catch_trial(4, 1))
    assert (state.n_false_alarms, state.n_catch) == (2, 3)


def test_progress_keeps_touches_with_reasons_and_gaps():
    state, press = Progress(), Press("tone", 10.0, 0.5, 1.0, 0.2, 0.3, 5.0)
    for n in range(MOST_SHOWN + 3):
        reason = "too_light" if n % 2 else None
        state = state.after(press, Touched(float(n), 10.0, "0", valid=not reason, invalid_reason=reason, n_gaps=1))
    assert len(state.touches) == MOST_SHOWN
    assert state.reasons == {"too_light": 7}
    assert state.n_gaps == MOST_SHOWN + 3


def test_progress_reads_timing_clocks_and_pauses_from_events():
    state = Progress()
    for delay_s, n_dropped in ((0.004, 1), (0.002, 0)):
        facts = {"n_frames": 100, "n_dropped_frames": n_dropped, "gate_delay_s": delay_s, "key_to_record_s": None}
        state = state.after_event(Event("trial", 1.0, facts=facts))
    state = state.after_event(Event("clock", 2.0, facts={"device": "hand", "clock_offset_s": 0.1}))
    state = state.after_event(Event("pause", 3.0, facts={"text": "the experimenter"}))
    assert (state.n_frames, state.n_dropped_frames, state.timing) == (200, 1, {"gate_delay_s": (0.002, 0.004)})
    assert state.clocks["hand"]["clock_offset_s"] == 0.1
    assert state.paused == "the experimenter"
    assert state.after_event(Event("resume", 4.0)).paused is None


def test_invalidated_false_alarm_is_not_counted():
    invalidated = Intervene(Intervention("invalidate", (1, 1, 1)), "trial 1 does not count", ((1, 1, 1),))
    state = recorded(catch_trial(1, 1), catch_trial(2, 1)).after(invalidated, Done(3.0))
    assert (state.n_false_alarms, state.n_catch, state.tally.n_invalid) == (1, 1, 1)


def test_session_is_over_when_consent_was_declined():
    parts = [PartAhead(n_trials=40, lasts_s=600.0)]
    state = Progress().after(Show("declined"), Done(3.0))
    assert (state.over, state.left_s(parts)) == (True, 0.0)
