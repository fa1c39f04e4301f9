"""Records of a session: syncing, storing, closing and counting."""

import json
import resource
from dataclasses import replace

import catalogue
import numpy as np
import pytest
from memory import Memory
from tables import contents
from tutorial_session import EXPERIMENT, journal_of, live

from tactometry.config.quantity import si
from tactometry.errors import DeviceFailed, Diverged, InvalidFile, InvalidParameter, LimitExceeded
from tactometry.experiments.sessions.recording import Who
from tactometry.files.durable import write_atomically
from tactometry.protocols.block import run_block
from tactometry.records.journal import checksum, encode, read
from tactometry.records.open_journal import Journal
from tactometry.session.answer import Done
from tactometry.session.replay import Replay
from tactometry.session.request import Record, Wait
from tactometry.session.run import replay, run
from tactometry.signal import Signal
from tactometry.trials.cells import cell


def one_block(rng):
    return run_block(catalogue.block("yes_no", "constant_stimuli"), 1, 1, rng)


def a_trial():
    memory = Memory()
    run(one_block(np.random.default_rng(1)), catalogue.simulated(7), memory)
    return memory.trials[0]


def test_trials_are_synced_and_other_requests_not(tmp_path, synced):
    journal = Journal(tmp_path / "j.jsonl", resume=False)
    journal.append(Wait(1.0), Done(1.0))
    assert synced == []
    journal.append(Record(a_trial()), Done(1.0))
    journal.close()
    assert synced == [tmp_path / "j.jsonl"]


def test_replaced_file_and_folder_are_synced(tmp_path, synced):
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


def test_trials_of_a_sitting_are_counted(tmp_path):
    recorded = live(tmp_path)
    assert recorded.tally.n_presented == recorded.trials.read_bytes().count(b"\n") - 1
    assert recorded.n_trials == recorded.tally.n_presented - sum(
        row.attempt > 1 for row in read(journal_of(tmp_path)).trials
    )
    assert recorded.n_resumed == 0


def test_line_after_end_is_refused(lived):
    last = journal_of(lived).read_bytes().split(b"\n")[-2]
    with journal_of(lived).open("ab") as file:
        file.write(encode({"request": "Wait", "asked": {"duration_s": 1.0}, "answer": {"at_s": 1.0}}, checksum(last)))
    with pytest.raises(InvalidFile, match="found a line after the end of the session"):
        read(journal_of(lived))


def test_line_without_checksum_is_refused(lived):
    lines = journal_of(lived).read_bytes().split(b"\n")
    lines[2] = lines[2].partition(b',"crc32"')[0] + b"}"
    journal_of(lived).write_bytes(b"\n".join(lines))
    with pytest.raises(InvalidFile, match="line 3: the line is damaged"):
        read(journal_of(lived))


def test_second_interruption_keeps_the_first(lived):
    for _ in range(2):
        journal_of(lived).write_bytes(journal_of(lived).read_bytes()[:-700])
        live(lived, resume=True)
    kept = next((lived / "journals").glob("*_interruptions.jsonl")).read_text().splitlines()
    assert sum("cut" in json.loads(line) for line in kept) == 2


def test_every_trial_column_is_described(lived):
    trials = next((lived / "data").glob("*.csv"))
    described = json.loads(trials.with_suffix(".json").read_text())
    assert list(described) == trials.read_text().splitlines()[0].split(",")
    assert all(column["Description"] for column in described.values())


def test_unreadable_journal_is_not_left_locked(lived):
    content = journal_of(lived).read_bytes()
    journal_of(lived).write_bytes(b"x" + content)
    with pytest.raises(InvalidFile, match="line 1"):
        live(lived, resume=True)
    journal_of(lived).write_bytes(content)
    live(lived, resume=True)


def test_journal_continues_after_full_disk(tmp_path):
    journal = Journal(tmp_path / "j.jsonl", resume=False)
    journal.append(Wait(1.0), Done(1.0))
    size, (soft, hard) = (tmp_path / "j.jsonl").stat().st_size, resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size + 10, hard))
    try:
        with pytest.raises(DeviceFailed, match="expected free disk space"):
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
def test_number_round_trips_through_cell(value, text):
    assert cell(value) == text
    assert float(cell(value)) == value


class Falling:
    """Rig that fails at every request and records whether it was closed."""

    def __init__(self):
        self.n_closed = 0

    def close(self):
        self.n_closed += 1

    def answer(self, request):
        raise DeviceFailed(f"{type(request).__name__}: the device fell")


def test_failed_rig_is_closed():
    falling = Falling()
    with pytest.raises(DeviceFailed, match="Slide: the device fell"):
        run(one_block(np.random.default_rng()), falling, Memory())
    assert falling.n_closed == 1


def test_journal_with_extra_answers_is_refused():
    lived = Memory()
    run(one_block(np.random.default_rng(1)), catalogue.simulated(7), lived)
    with pytest.raises(Diverged, match="the recording continues with"):
        run(one_block(np.random.default_rng(1)), catalogue.simulated(7), Memory([*lived.entries, lived.entries[-1]]))


def test_changed_trial_is_found():
    lived = Memory()
    run(one_block(np.random.default_rng(1)), catalogue.simulated(7), lived)
    at = next(n for n, (request, _) in enumerate(lived.entries) if isinstance(request, Record))
    request, answer = lived.entries[at]
    changed = Record(replace(request.trial, latency_s=9.0))
    entries = [*lived.entries[:at], (changed, answer), *lived.entries[at + 1 :]]
    with pytest.raises(Diverged, match=rf"line {at + 1}: Record.trial.latency_s: the recording has 9.0"):
        replay(one_block(np.random.default_rng(1)), Replay(entries))


def test_signal_not_in_volt_is_refused():
    with pytest.raises(LimitExceeded, match="found a signal in 'A', expected volt"):
        catalogue.LIMITS.check(Signal(np.zeros((1, 4)), 1e3, "A"))


def test_limit_allows_rounding():
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


def test_resumed_session_keeps_its_number(lived):
    who = Who("P01", number=5, seed=1)
    with pytest.raises(InvalidParameter, match="--number: found 5, but this session began with 1"):
        live(lived, who, resume=True)


def test_sessions_of_a_participant_differ_in_order():
    orders = []
    for n_session in (1, 2):
        memory = Memory()
        run(EXPERIMENT.course("P01", n_session, 1, 1), EXPERIMENT.simulated_rig("P01", n_session, 1), memory)
        orders.append([(trial.level, trial.catch) for trial in memory.trials])
    assert orders[0] != orders[1]
