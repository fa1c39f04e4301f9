"""Details that a session rests on: what is synced, kept, refused, felt, asked again and closed."""

import json
import resource
from dataclasses import replace

import catalogue
import numpy as np
import pytest
from memory import Memory
from tutorial_session import EXPERIMENT, journal_of, live

from tactometry.config.quantity import si
from tactometry.errors import DeviceFailed, Diverged, InvalidFile, InvalidParameter, LimitExceeded
from tactometry.experiments.sessions.recording import Who
from tactometry.experiments.study.task_table import DECISIONS
from tactometry.files.durable import write_atomically
from tactometry.observers.finger import SimulatedFinger
from tactometry.protocols import ConstantStimuli, Staircase
from tactometry.protocols.block import run_block
from tactometry.protocols.block_state import catch_schedule
from tactometry.records.journal import checksum, encode, read
from tactometry.records.open_journal import Journal
from tactometry.rigs.simulated import SimulatedRig
from tactometry.safety.limits import Limits
from tactometry.session.answer import Done, Touched
from tactometry.session.replay import Replay
from tactometry.session.request import Choose, Record, Slide, Wait
from tactometry.session.run import replay, run
from tactometry.signal import Signal
from tactometry.trials.cells import cell


def contents(root):
    return {path: path.read_bytes() for path in sorted(root.rglob("*")) if path.is_file()}


def a_trial(memory_of=1):
    memory = Memory()
    run(run_block(catalogue.block("yes_no", "constant_stimuli"), 1, 1, np.random.default_rng(1)), rig(), memory)
    return memory.trials[:memory_of]


def rig(**changes):
    parts = {"limits": catalogue.LIMITS, "sensation": catalogue.Loudness(), "finger": SimulatedFinger()} | changes
    return SimulatedRig(
        catalogue.AnyStimulus(),
        parts["limits"],
        sensation=parts["sensation"],
        observer=catalogue.OBSERVERS["default"],
        finger=parts["finger"],
        rng_of=lambda n_trials: np.random.default_rng([7, n_trials]),
        decisions=DECISIONS,
    )


SLIDE = Slide("tone", 20.0, 0.2, 1.0, 0.2, 0.5, 5.0, 0.05)


def test_a_trial_is_synced_before_append_returns_and_other_requests_are_not(tmp_path, synced):
    journal = Journal(tmp_path / "j.jsonl", resume=False)
    journal.append(Wait(1.0), Done(1.0))
    assert synced == []
    journal.append(Record(a_trial()[0]), Done(1.0))
    journal.close()
    assert synced == [tmp_path / "j.jsonl"]


def test_a_replaced_file_and_its_folder_are_synced(tmp_path, synced):
    write_atomically(tmp_path / "f", b"content")
    assert len(synced) == 2
    assert synced[-1] == tmp_path


def test_resuming_a_complete_session_changes_nothing(lived):
    before = contents(lived)
    recorded = live(lived, resume=True)
    assert contents(lived) == before
    rows = read(journal_of(lived)).trials
    assert recorded.n_trials == recorded.n_resumed == len({row.trial for row in rows})
    assert recorded.tally.n_presented == len(rows)


def test_the_trials_of_a_sitting_are_counted(tmp_path):
    recorded = live(tmp_path)
    assert recorded.tally.n_presented == recorded.trials.read_bytes().count(b"\n") - 1
    assert recorded.n_trials == recorded.tally.n_presented - sum(
        row.attempt > 1 for row in read(journal_of(tmp_path)).trials
    )
    assert recorded.n_resumed == 0


def test_a_line_behind_the_end_is_refused(lived):
    last = journal_of(lived).read_bytes().split(b"\n")[-2]
    with journal_of(lived).open("ab") as file:
        file.write(encode({"request": "Wait", "asked": {"duration_s": 1.0}, "answer": {"at_s": 1.0}}, checksum(last)))
    with pytest.raises(InvalidFile, match="found a line behind the end of the session"):
        read(journal_of(lived))


def test_a_line_without_a_checksum_is_refused(lived):
    lines = journal_of(lived).read_bytes().split(b"\n")
    lines[2] = lines[2].partition(b',"crc32"')[0] + b"}"
    journal_of(lived).write_bytes(b"\n".join(lines))
    with pytest.raises(InvalidFile, match="line 3: the line is damaged"):
        read(journal_of(lived))


def test_a_second_interruption_is_kept_beside_the_first(lived):
    for _ in range(2):
        journal_of(lived).write_bytes(journal_of(lived).read_bytes()[:-700])
        live(lived, resume=True)
    kept = next((lived / "journals").glob("*_interruptions.jsonl")).read_text().splitlines()
    assert sum("cut" in json.loads(line) for line in kept) == 2


def test_every_column_is_described_beside_the_trials(lived):
    trials = next((lived / "data").glob("*.csv"))
    described = json.loads(trials.with_suffix(".json").read_text())
    assert list(described) == trials.read_text().splitlines()[0].split(",")
    assert all(column["Description"] for column in described.values())


def test_a_journal_that_could_not_be_read_is_not_left_locked(lived):
    content = journal_of(lived).read_bytes()
    journal_of(lived).write_bytes(b"x" + content)
    with pytest.raises(InvalidFile, match="line 1"):
        live(lived, resume=True)
    journal_of(lived).write_bytes(content)
    live(lived, resume=True)


def test_after_a_full_disk_the_journal_goes_on_where_it_was(tmp_path):
    journal = Journal(tmp_path / "j.jsonl", resume=False)
    journal.append(Wait(1.0), Done(1.0))
    size, (soft, hard) = (tmp_path / "j.jsonl").stat().st_size, resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size + 10, hard))
    try:
        with pytest.raises(DeviceFailed, match="expected room on the disk"):
            journal.append(Wait(2.0), Done(2.0))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    journal.append(Wait(3.0), Done(3.0))
    journal.close()
    lines = (tmp_path / "j.jsonl").read_bytes().splitlines()
    assert [json.loads(line)["asked"]["duration_s"] for line in lines] == [1.0, 3.0]


@pytest.mark.parametrize(
    ("value", "text"),
    [(1e20, "1e+20"), (2.0**53, "9007199254740992.0"), (-0.0, "0"), (1e15, "1000000000000000.0"), (False, "0")],
)
def test_a_number_reads_back_from_its_cell(value, text):
    assert cell(value) == text
    assert float(cell(value)) == value


class Falling:
    """A rig that fails when it is asked anything, and knows whether it was closed."""

    def __init__(self):
        self.n_closed = 0

    def close(self):
        self.n_closed += 1

    def answer(self, request):
        raise DeviceFailed(f"{type(request).__name__}: the device fell")


def test_a_rig_is_closed_when_it_fails():
    falling = Falling()
    with pytest.raises(DeviceFailed, match="Slide: the device fell"):
        run(run_block(catalogue.block("yes_no", "constant_stimuli"), 1, 1, np.random.default_rng()), falling, Memory())
    assert falling.n_closed == 1


def one_block(rng):
    return run_block(catalogue.block("yes_no", "constant_stimuli"), 1, 1, rng)


def test_a_journal_that_holds_more_than_the_protocol_asks_is_refused():
    lived = Memory()
    run(one_block(np.random.default_rng(1)), rig(), lived)
    with pytest.raises(Diverged, match="the recording goes on with"):
        run(one_block(np.random.default_rng(1)), rig(), Memory([*lived.entries, lived.entries[-1]]))


def test_a_recorded_trial_that_was_changed_is_found():
    lived = Memory()
    run(one_block(np.random.default_rng(1)), rig(), lived)
    at = next(n for n, (request, _) in enumerate(lived.entries) if isinstance(request, Record))
    request, answer = lived.entries[at]
    changed = Record(replace(request.trial, latency_s=9.0))
    entries = [*lived.entries[:at], (changed, answer), *lived.entries[at + 1 :]]
    with pytest.raises(Diverged, match=rf"line {at + 1}: Record.trial.latency_s: the recording holds 9.0"):
        replay(one_block(np.random.default_rng(1)), Replay(entries))


def test_the_simulated_rig_holds_signals_against_the_limits():
    with pytest.raises(LimitExceeded, match="found a peak of"):
        rig(limits=Limits(voltage_peak_v=1.0)).answer(SLIDE)


class Noting(catalogue.Loudness):
    def __init__(self):
        self.contacts = []

    def sensation_db(self, signal, contact):
        self.contacts.append(contact)
        return super().sensation_db(signal, contact)


def test_what_is_felt_depends_on_the_force_and_speed_that_were_held():
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


def test_a_force_that_wavers_out_of_the_band_makes_the_touch_invalid():
    assert not rig(finger=SimulatedFinger(waver_cv=0.9)).answer(SLIDE).valid


class Clipping:
    """A rig that delivers 3 dB less than it is asked for, and loses the first `n_lost` touches."""

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


def test_a_procedure_learns_the_level_that_was_delivered():
    memory = Memory()
    course = run_block(catalogue.block("yes_no", "staircase_1_up_1_down"), 1, 1, np.random.default_rng(1))
    (track,), _ = run(course, Clipping(), memory)
    delivered = [trial.level_delivered for trial in memory.trials if not trial.catch]
    assert list(track.procedure.delivered) == delivered
    assert all(trial.level_delivered == trial.level - 3.0 for trial in memory.trials if not trial.catch)


def test_an_invalid_touch_of_a_staircase_is_asked_again_at_once():
    memory = Memory()
    course = run_block(catalogue.block("yes_no", "staircase_1_up_1_down"), 1, 1, np.random.default_rng(1))
    run(course, Clipping(n_lost=2), memory)
    first = [(trial.trial, trial.attempt, trial.valid, trial.response is None) for trial in memory.trials[:3]]
    assert first == [(1, 1, False, True), (1, 2, False, True), (1, 3, True, False)]
    assert len({trial.level for trial in memory.trials[:3]}) == 1


def test_invalid_touches_of_constant_stimuli_come_again_at_the_end_of_the_block():
    memory = Memory()
    (track,), next_trial = run(one_block(np.random.default_rng(1)), Clipping(n_lost=2), memory)
    lost, again = memory.trials[:2], memory.trials[-2:]
    assert [(trial.trial, trial.attempt, trial.valid) for trial in lost] == [(1, 1, False), (2, 1, False)]
    assert [(trial.trial, trial.attempt, trial.valid) for trial in again] == [(1, 2, True), (2, 2, True)]
    assert [trial.level for trial in again] == [trial.level for trial in lost]
    assert track.ending == "trials"
    assert next_trial == 1 + len({trial.trial for trial in memory.trials})
    felt = sorted(trial.level for trial in memory.trials if trial.valid and not trial.catch)
    assert felt == sorted(catalogue.PROCEDURES["constant_stimuli"].begin().order)


def test_a_block_of_which_no_touch_is_valid_is_aborted():
    memory = Memory()
    (track,), _ = run(one_block(np.random.default_rng(1)), Clipping(n_lost=10**6), memory)
    assert track.ending == "aborted"
    assert [trial.trial for trial in memory.trials] == [1, 2, 3, 4, 5]


def test_catch_trials_come_at_any_place_of_their_group():
    schedule = catch_schedule(0.25, np.random.default_rng())
    groups = [[next(schedule) for _ in range(4)] for _ in range(200)]
    assert all(sum(group) == 1 for group in groups)
    assert {group.index(True) for group in groups} == {0, 1, 2, 3}


def test_repeats_of_constant_stimuli_have_orders_of_their_own():
    order = ConstantStimuli((1.0, 2.0, 3.0, 4.0), repeats=50).begin(np.random.default_rng()).order
    assert len({order[n : n + 4] for n in range(0, 200, 4)}) > 1


def test_a_catch_trial_delivers_nothing():
    touched = rig().answer(replace(SLIDE, level=None))
    assert isinstance(touched, Touched)
    assert (touched.level_delivered, touched.digest) == (None, None)


def test_a_forced_choice_row_holds_the_touch_of_the_stimulus_and_the_onset_of_the_first_interval():
    memory = Memory()
    course = run_block(catalogue.block("forced_choice", "constant_stimuli"), 1, 1, np.random.default_rng(1))
    run(course, rig(finger=SimulatedFinger(waver_cv=0.0)), memory)
    answers = [(request, answer) for request, answer in memory.entries if isinstance(request, Slide | Record)]
    for n in range(0, len(answers), 3):
        touches, trial = [answer for _, answer in answers[n : n + 2]], answers[n + 2][0].trial
        assert trial.force_mean_n == touches[trial.target - 1].force_mean_n
        assert trial.onset_s == touches[0].onset_s
    assert {trial.target for trial in memory.trials} == {1, 2}


def test_an_interval_that_is_not_valid_ends_its_trial_unasked():
    memory = Memory()
    course = run_block(catalogue.block("forced_choice", "constant_stimuli"), 1, 1, np.random.default_rng(1))
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
def test_an_answer_that_was_declared_invalid_is_not_scored_and_asked_again(task):
    memory = Memory()
    run(run_block(catalogue.block(task, "constant_stimuli"), 1, 1, np.random.default_rng(1)), Refusing(), memory)
    first, second = memory.trials[0], memory.trials[-1]
    assert (first.valid, first.correct, first.attempt) == (False, None, 1)
    assert (second.valid, second.attempt, second.trial, second.level) == (True, 2, first.trial, first.level)


def test_a_censored_run_with_reversals_has_no_threshold():
    rule = Staircase(start=10.0, steps=(4.0,), low=0.0, high=40.0, n_down=1, n_reversals=20, n_at_bound=3)
    for answer in (1, 0, 1, 0, 1, 0, 1, 1, 1, 1, 1, 1, 1):
        rule = rule if rule.finished else rule.after(answer)
    assert len(rule.reversals) >= 4
    assert (rule.ending, rule.threshold) == ("censored_below", None)


def test_responses_at_a_bound_count_in_a_row_only():
    rule = Staircase(start=40.0, steps=(2.0,), low=0.0, high=40.0, n_down=1, n_reversals=99, n_at_bound=3)
    for answer in (0, 0, 1, 0, 0, 0):
        assert rule.ending is None
        rule = rule.after(answer)
    assert rule.ending is None
    assert rule.after(0).ending == "censored_above"


def test_a_signal_in_another_unit_than_volt_is_not_played():
    with pytest.raises(LimitExceeded, match="found a signal in 'A', expected volt"):
        catalogue.LIMITS.check(Signal(np.zeros((1, 4)), 1e3, "A"))


def test_the_limit_holds_to_rounding():
    catalogue.LIMITS.check(Signal(np.full((1, 4), 200.0 * (1 + 1e-15)), 1e3, "V"))
    with pytest.raises(LimitExceeded, match="found a peak of"):
        catalogue.LIMITS.check(Signal(np.full((1, 4), 200.0 * (1 + 1e-9)), 1e3, "V"))


@pytest.mark.parametrize(
    ("text", "suffix", "value"),
    [
        ("2 min", "s", 120.0),
        ("1.5 MHz", "hz", 1.5e6),
        ("20 kHz", "hz", 20e3),
        ("250 mN", "n", 0.25),
        ("1.1 mm", "m", 1.1e-3),
        ("5 um", "m", 5e-6),
        ("50 mm/s", "m_per_s", 0.05),
        ("1 cm2", "m2", 1e-4),
        ("3", "v", None),
        ("2 kV", "v", 2000.0),
    ],
)
def test_quantities_with_units(text, suffix, value):
    if value is None:
        with pytest.raises(InvalidParameter, match="expected a number in V or a string such as '1 V'"):
            si(text, suffix, "x")
    else:
        assert si(text, suffix, "x") == pytest.approx(value, rel=1e-15)


def test_a_session_goes_on_under_its_own_number(lived):
    who = Who("P01", number=5, seed=1)
    with pytest.raises(InvalidParameter, match="--number: found 5, but this session began with 1"):
        live(lived, who, resume=True)


def test_each_session_of_a_participant_has_an_order_of_its_own():
    orders = []
    for n_session in (1, 2):
        memory = Memory()
        run(EXPERIMENT.course("P01", n_session, 1, 1), EXPERIMENT.simulated_rig("P01", n_session, 1), memory)
        orders.append([(trial.level, trial.catch) for trial in memory.trials])
    assert orders[0] != orders[1]
