"""Records of a session: syncing, storing, closing and counting."""

import json
import os
import subprocess
import sys
from dataclasses import replace

import catalogue
import numpy as np
import pytest
from memory import Memory
from tables import contents
from tutorial_session import EXPERIMENT, TOML, WHO, journal_of, live

from tactometry.config.quantity import si
from tactometry.errors import DeviceFailed, Diverged, InvalidFile, InvalidParameter, LimitExceeded
from tactometry.experiments.sessions.recording import Who, record, simulated
from tactometry.files.durable import write_atomically
from tactometry.protocols.block import run_block
from tactometry.records.journal import checksum, encode, read
from tactometry.session.replay import Replay
from tactometry.session.request import Record
from tactometry.session.run import replay, run
from tactometry.signal import Signal
from tactometry.trials.cells import cell


def one_block(rng):
    return run_block(catalogue.block("yes_no", "constant_stimuli"), 1, 1, rng)


@pytest.fixture(scope="module")
def entries():
    """Return the requests and answers of a block."""
    memory = Memory()
    run(one_block(np.random.default_rng(1)), catalogue.simulated(7), memory)
    return memory.entries


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
    assert recorded.tally.n_presented == len(rows) == recorded.trials.read_bytes().count(b"\n") - 1


def test_line_after_end_is_refused(lived):
    last = journal_of(lived).read_bytes().split(b"\n")[-2]
    with journal_of(lived).open("ab") as file:
        file.write(encode({"request": "Wait", "asked": {"duration_s": 1.0}, "answer": {"at_s": 1.0}}, checksum(last)))
    with pytest.raises(InvalidFile, match="found a line after the end of the session"):
        read(journal_of(lived))


def test_second_interruption_keeps_the_first(lived):
    for _ in range(2):
        journal_of(lived).write_bytes(journal_of(lived).read_bytes()[:-700])
        live(lived, resume=True)
    kept = next((lived / "journals").glob("*_interruptions.jsonl")).read_text().splitlines()
    assert sum("cut" in json.loads(line) for line in kept) == 2


def test_unreadable_journal_is_not_left_locked(lived):
    content = journal_of(lived).read_bytes()
    journal_of(lived).write_bytes(b"x" + content)
    with pytest.raises(InvalidFile, match="line 1"):
        live(lived, resume=True)
    journal_of(lived).write_bytes(content)
    live(lived, resume=True)


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


def test_journal_with_extra_answers_is_refused(entries):
    with pytest.raises(Diverged, match="the recording continues with"):
        run(one_block(np.random.default_rng(1)), catalogue.simulated(7), Memory([*entries, entries[-1]]))


def test_changed_trial_is_found(entries):
    at = next(n for n, (request, _) in enumerate(entries) if isinstance(request, Record))
    request, answer = entries[at]
    changed = Record(replace(request.trial, latency_s=9.0))
    with pytest.raises(Diverged, match=rf"line {at + 1}: Record.trial.latency_s: the recording has 9.0"):
        replay(one_block(np.random.default_rng(1)), Replay([*entries[:at], (changed, answer), *entries[at + 1 :]]))


def test_limit_allows_rounding():
    catalogue.LIMITS.check(Signal(np.full((1, 4), 200.0 * (1 + 1e-15)), 1e3, "V"))
    with pytest.raises(LimitExceeded, match="found a peak of"):
        catalogue.LIMITS.check(Signal(np.full((1, 4), 200.0 * (1 + 1e-9)), 1e3, "V"))


@pytest.mark.parametrize(
    ("text", "suffix", "value"),
    [
        *[("2 min", "s", 120.0), ("1.5 MHz", "hz", 1.5e6), ("20 kHz", "hz", 20e3), ("250 mN", "n", 0.25)],
        *[("1.1 mm", "m", 1.1e-3), ("5 um", "m", 5e-6), ("50 mm/s", "m_per_s", 0.05), ("1 cm2", "m2", 1e-4)],
        ("2 kV", "v", 2000.0),
    ],
)
def test_quantities_have_units(text, suffix, value):
    assert si(text, suffix, "x") == pytest.approx(value, rel=1e-15)


def test_quantity_without_unit_is_refused():
    with pytest.raises(InvalidParameter, match="expected a number in V or a string such as '1 V'"):
        si("3", "v", "x")


def test_resumed_session_keeps_its_number(lived):
    who = Who("P01", number=5, seed=1)
    with pytest.raises(InvalidParameter, match="--number: found 5, but this session began with 1"):
        live(lived, who, resume=True)


# --- sessions that fail before their first request leave no data set


def failing(root, error, who=WHO, *, resume=False):

    def make(seed, log):
        raise error

    with pytest.raises(type(error)):
        record(EXPERIMENT, TOML, root, who, replace(simulated(EXPERIMENT, who), make=make), resume=resume)


@pytest.mark.parametrize("error", [DeviceFailed("no sensor"), KeyboardInterrupt()], ids=repr)
def test_failed_start_leaves_no_files(tmp_path, error):
    failing(tmp_path / "data", error)
    assert list(tmp_path.iterdir()) == []
    failing(tmp_path, error)
    assert list(tmp_path.iterdir()) == []


def test_failed_start_leaves_other_sessions_unchanged(tmp_path):
    live(tmp_path)
    before = contents(tmp_path)
    failing(tmp_path, DeviceFailed("no sensor"), Who("P02", seed=1))
    assert contents(tmp_path) == before


def test_failed_resume_keeps_recorded_trials(journal):
    journal.holds(20)
    before = read(journal.path).trials
    failing(journal.root, DeviceFailed("no sensor"), resume=True)
    assert read(journal.path).trials == before


def test_run_without_psychopy_leaves_no_data_set(tmp_path):
    (tmp_path / "psychopy.py").write_text("raise ImportError('not installed')")
    command = [sys.executable, "-m", "tactometry", "run", "tutorial", "--participant", "P01", "--out", "data"]
    env = os.environ | {"PYTHONPATH": os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])}
    done = subprocess.run(command, check=False, cwd=tmp_path, env=env, capture_output=True, text=True)
    assert done.returncode == 3, done.stderr
    assert not (tmp_path / "data").exists()
