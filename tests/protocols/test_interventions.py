"""Experimenter interventions between trials and between blocks."""

from collections import Counter
from dataclasses import replace
from functools import reduce

import catalogue
import numpy as np
import pytest
from examples import examples
from hypothesis import given, strategies as st
from memory import Memory
from wanting import Wanting

from tactometry.observers.finger import SimulatedFinger
from tactometry.protocols import Block, session
from tactometry.protocols.block import run_block
from tactometry.protocols.block_state import BlockOptions
from tactometry.protocols.procedures.procedure import FixedOrder, after_answer
from tactometry.protocols.session import Inquiry
from tactometry.questionnaire import load as load_form
from tactometry.session.answer import Done, Intervention
from tactometry.session.progress import PartAhead, Progress
from tactometry.session.replay import Replay, rows
from tactometry.session.request import Intervene, Record, Show
from tactometry.session.run import replay, run
from tactometry.trials.trial import Trial, tally


def steady():
    """Return a participant whose touches are all valid."""
    return replace(catalogue.simulated(1), finger=SimulatedFinger(force_cv=0.0, waver_cv=0.0))


def lived(make, at):
    """Run a course; return its result, valid rows, messages and pages."""
    memory, rig = Memory(), Wanting(steady(), at)
    ended = run(make(), rig, memory)
    replay(make(), Replay(memory.entries))  # as it was recorded
    requests = [request for request, _ in memory.entries]
    pages = [request.message for request in requests if isinstance(request, Show)]
    return ended, rows(requests), rig.said, pages


def block_of(procedure, task="yes_no"):
    return lambda: run_block(catalogue.block(task, procedure), 1, 1, np.random.default_rng(1))


def answered(block, trials):
    """Return the procedures of a block after its valid answers."""
    procedures = [track.procedure for track in block.tracks]
    names = [track.name for track in block.tracks]
    for trial in trials:
        if trial.valid and not trial.catch:
            procedures = after_answer(procedures, names.index(trial.track), trial.response, trial.level_delivered)
    return procedures


ADAPTIVE = [name for name, rule in catalogue.PROCEDURES.items() if not isinstance(rule, FixedOrder)]
FIXED = [name for name in catalogue.PROCEDURES if name not in ADAPTIVE]


@pytest.mark.parametrize("name", ADAPTIVE)
@pytest.mark.parametrize("n_back", [1, 2])
def test_adaptive_rule_forgets_invalidated_trial_and_dependents(name, n_back):
    (tracks, next_trial), trials, _, _ = lived(block_of(name), {6: f"back {n_back}"})
    [procedure] = answered(catalogue.block("yes_no", name), trials)
    assert (tracks[0].procedure.level, tracks[0].ending) == (procedure.level, procedure.ending)
    assert tracks[0].procedure.estimate == procedure.estimate
    slip = trials[6 - n_back]
    assert (slip.valid, slip.correct, slip.invalid_reason) == (False, None, "experimenter")
    again = next(trial for trial in trials if (trial.trial, trial.attempt) == (slip.trial, 2))
    assert (again.level, again.valid) == (slip.level, True)
    assert next_trial == 1 + max(trial.trial for trial in trials)


@pytest.mark.parametrize("name", FIXED)
def test_fixed_order_repeats_only_the_invalidated_level(name):
    (tracks, _), trials, _, _ = lived(block_of(name), {6: "back 3"})
    assert [trial.trial for trial in trials if not trial.valid] == [trials[3].trial]
    felt = [trial.level for trial in trials if trial.valid and not trial.catch]
    assert sorted(felt) == sorted(tracks[0].procedure.order)
    assert tracks[0].ending != "aborted"


def test_block_reopens_when_last_trial_is_invalidated():
    _, before, _, _ = lived(block_of("constant_stimuli"), {})
    _, trials, said, _ = lived(block_of("constant_stimuli"), {len(before): "back"})
    assert len(trials) == len(before) + 1
    assert (trials[-1].trial, trials[-1].attempt, trials[-1].valid) == (before[-1].trial, 2, True)
    assert said == [f"trial {before[-1].trial} does not count: it is asked again"]


def test_message_lists_trials_that_depend_on_slip():
    _, trials, said, _ = lived(block_of("staircase_1_up_1_down", "forced_choice"), {2: "back 2"})
    assert said == ["trial 1 does not count, nor does trial 2, whose level followed from it: it is asked again"]
    assert [trial.valid for trial in trials[:3]] == [False, False, True]


def interleaved():
    return session([catalogue.interleaved("random")], np.random.default_rng(1))


@given(at=st.dictionaries(st.integers(3, 40), st.sampled_from(["back", "back 2", "back, back 2", "rest"]), max_size=4))
@examples(20, deadline=None)
def test_interleaved_tracks_keep_state_of_their_valid_answers(at):
    tracks, trials, said, _ = lived(interleaved, at)
    block = catalogue.interleaved("random")
    expected = answered(block, [trial for trial in trials if trial.track != "constant_stimuli"])
    for track, procedure in list(zip(tracks, expected, strict=True))[1:]:
        assert (track.procedure.level, track.procedure.ending) == (procedure.level, procedure.ending)
    felt = [trial.level for trial in trials if trial.track == "constant_stimuli" and trial.valid and not trial.catch]
    assert sorted(felt) == sorted(block.tracks[0].procedure.begin().order)
    assert set(Counter((trial.trial, trial.attempt) for trial in trials).values()) == {1}
    assert len(said) == sum(len(words.split(", ")) for words in at.values())


def three():
    parts = [catalogue.block("yes_no", name) for name in ("constant_stimuli", "quest", "staircase_1_up_1_down")]
    return session([parts[0], Inquiry(load_form("sus")), *parts[1:]], np.random.default_rng(1))


def blocks(trials):
    return Counter(trial.block for trial in trials)


def test_skipped_block_ends_and_next_begins():
    tracks, trials, said, _ = lived(three, {4: "skip"})
    assert [track.ending for track in tracks][:1] == ["skipped"]
    assert "skipped" not in [track.ending for track in tracks][1:]
    assert blocks(trials)[1] == 4
    assert set(blocks(trials)) == {1, 2, 3, 4}
    assert said == ["block 1 is skipped"]


@pytest.mark.parametrize(("page", "n_pages"), [("block", 3), ("instructions_yes_no", 2)])
def test_block_skipped_at_its_page_never_begins(page, n_pages):
    tracks, trials, said, pages = lived(three, {page: "skip"})
    assert (tracks[0].ending, 1 in blocks(trials), said) == ("skipped", False, ["block 1 is skipped"])
    assert pages[: n_pages + 1] == [*["welcome", "instructions_yes_no", "block"][:n_pages], "questions"]
    assert pages[-1] == "end"


def test_end_request_stops_block_and_session():
    tracks, trials, said, pages = lived(three, {4: "end"})
    assert [track.ending for track in tracks] == ["skipped", "not begun", "not begun"]
    assert (blocks(trials), pages.count("block"), pages[-1]) == ({1: 4}, 1, "end")
    assert said == ["block 1 is left, and the session ends"]


@pytest.mark.parametrize("page", ["welcome", "instructions_yes_no", "block"])
def test_end_request_outside_blocks_starts_no_block(page):
    tracks, trials, said, _ = lived(three, {page: "end"})
    assert {track.ending for track in tracks} <= {"not begun", "skipped"}
    assert (trials, said) == ((), ["the session ends"])


def test_end_request_in_questionnaire_starts_no_further_block():
    n_block = len([trial for trial in lived(three, {})[1] if trial.block == 1])
    _, trials, said, _ = lived(three, {n_block + 3: "end"})
    assert (set(blocks(trials)), blocks(trials)[2], said) == ({1, 2}, 10, ["the session ends"])


def test_requested_rest_follows_trial_like_scheduled_rests():
    def resting():
        block = catalogue.block("yes_no", "constant_stimuli")
        return run_block(replace(block, options=BlockOptions(rest_s=30.0)), 1, 1, np.random.default_rng(1))

    _, trials, said, pages = lived(resting, {3: "rest", "rest": "back"})
    assert pages == ["resting", "rest"]
    assert said == ["a rest", f"trial {trials[2].trial} does not count: it is asked again"]


def test_rest_after_last_trial_is_the_next_page():
    n = len(lived(block_of("constant_stimuli"), {})[1])
    _, _, said, pages = lived(block_of("constant_stimuli"), {n: "rest"})
    assert (said, pages) == (["the page that comes next waits for the participant: that is a rest"], [])


@pytest.mark.parametrize("at", [{"end": "back"}, {"practice": "back"}])
def test_trial_of_finished_block_is_invalidated_without_repeat(at):
    def two():
        first, second = (catalogue.block("yes_no", name) for name in ("constant_stimuli", "constant_stimuli_shuffled"))
        return session([first, Block(second.tracks, second.task, practice=True)], np.random.default_rng(1))

    _, before, _, _ = lived(two, {})
    _, trials, [said], _ = lived(two, at)
    [slip] = [trial for trial in trials if not trial.valid]
    assert len(trials) == len(before)
    assert said == f"trial {slip.trial} does not count, and is not asked again: its block is over"


def test_trial_of_skipped_block_is_invalidated_without_reopening():
    tracks, trials, said, _ = lived(three, {4: "skip, back"})
    assert (tracks[0].ending, blocks(trials)[1], trials[3].valid) == ("skipped", 4, False)
    assert said[1] == f"trial {trials[3].trial} does not count, and is not asked again: its block is over"


@pytest.mark.parametrize("page", ["welcome", "consent"])
def test_session_ended_before_first_block_asks_no_questions(page):
    def with_consent():
        return session([catalogue.interleaved("random")], np.random.default_rng(1), consent=True)

    tracks, trials, said, pages = lived(with_consent, {page: "end"})
    assert (said, trials) == (["the session ends"], ())
    assert pages == [*dict.fromkeys(("welcome", page)), "end"]
    assert {track.ending for track in tracks} == {"not begun"}


def test_message_states_that_trial_was_already_invalid():
    _, trials, said, _ = lived(block_of("constant_stimuli"), {3: "back, back"})
    assert said[1] == f"trial {trials[2].trial} does not count anyway"
    assert [trial.valid for trial in trials].count(False) == 1


@pytest.mark.parametrize("name", ["constant_stimuli", "staircase_1_up_1_down"])
def test_progress_excludes_invalidated_trials(name):
    memory = Memory()
    run(block_of(name)(), Wanting(catalogue.simulated(1), {3: "back", 6: "back 2", 7: "rest", 9: "back"}), memory)
    progress = reduce(lambda progress, entry: progress.after(*entry), memory.entries, Progress())
    trials = rows(request for request, _ in memory.entries)
    caught = [trial.response for trial in trials if trial.valid and trial.catch]
    assert progress.tally == tally(trials)
    assert (progress.n_catch, progress.n_false_alarms) == (len(caught), sum(caught))
    assert progress.track.presented == trials
    assert len(progress.interventions) == 4


def test_invalidated_trial_raises_no_warning():
    trial = Trial(1, 1, {}, "staircase", 10.0, "dB", "yes_no", 1)
    back = Intervene(Intervention("invalidate", trial.key), "", (trial.key,))
    progress = Progress().after(Record(trial), Done(1.0)).after(back, Done(2.0))
    assert progress.last.valid is False
    assert progress.warning([PartAhead(n_attempts=2)]) is None


def test_intervention_follows_record():
    memory = Memory()
    run(block_of("constant_stimuli")(), Wanting(steady(), {2: "back"}), memory)
    kinds = [type(request) for request, _ in memory.entries]
    assert kinds[kinds.index(Intervene) - 1] is Record
