"""Ledger of emissions across sessions, processes and clock changes."""

import multiprocessing
import os
import resource
import signal
import sqlite3
import tempfile
import threading
import time
from contextlib import closing, suppress
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, strategies as st

from tactometry.devices.outputs import emission_ledger as ledgers
from tactometry.devices.outputs.emission_ledger import Ledger, Moment
from tactometry.devices.outputs.file import FileOutput, FileSettings
from tactometry.devices.outputs.guarded import Guarded
from tactometry.devices.outputs.output import NullOutput
from tactometry.errors import DeviceFailed, InvalidFile, LimitExceeded
from tactometry.safety.limits import Limits
from tactometry.signal import Signal

WINDOW_S = 60.0
LIMITS = Limits(100.0, duty=0.05, duty_window_s=WINDOW_S, stop_within_s=1.0)
"""Three signals of 1 s a minute."""


class Clocks:
    def __init__(self):
        self.boot_id, self.boot_s, self.utc_s = "first", 1000.0, 1.7e9

    def now(self):
        return Moment(self.boot_id, self.boot_s, self.utc_s)

    def pass_by(self, duration_s):
        self.boot_s += duration_s
        self.utc_s += duration_s

    def start_anew(self, off_s):
        self.boot_id, self.boot_s = "second", 0.0
        self.pass_by(off_s)
        self.boot_s = 0.0


@pytest.fixture
def clocks(monkeypatch):
    made = Clocks()
    monkeypatch.setattr(ledgers.Moment, "now", made.now)
    return made


class Emitter(NullOutput):
    """Output with a name, of which several may be open."""

    emits, late_s = True, 0.0

    @property
    def stop_delay_s(self):
        return self.late_s

    def __init__(self, name):
        super().__init__()
        self.name = name


def guard(path, clocks, name="card"):
    return Guarded(Emitter(name), LIMITS, clock=lambda: clocks.boot_s, ledger=Ledger(path / "outputs.sqlite3"))


def volts(duration_s=1.0):
    return Signal(np.ones((1, round(1e3 * duration_s))), 1e3, "V")


def n_played(output, clocks):
    output.open()
    n_done = 0
    with suppress(LimitExceeded):
        for _ in range(5):
            output.play(volts())
            clocks.pass_by(1.0)
            n_done += 1
    output.close()
    return n_done


JUMPS = {
    "none": lambda clocks: None,
    "ahead": lambda clocks: setattr(clocks, "utc_s", clocks.utc_s + 3600.0),
    "back": lambda clocks: setattr(clocks, "utc_s", clocks.utc_s - 3600.0),
    "restart": lambda clocks: clocks.start_anew(off_s=0.0),
}


@pytest.mark.parametrize("jump", JUMPS)
def test_next_session_counts_signals_when_clocks_jump(tmp_path, clocks, jump):
    """A window later it plays again."""
    assert n_played(guard(tmp_path, clocks), clocks) == 3
    JUMPS[jump](clocks)
    assert n_played(guard(tmp_path, clocks), clocks) == 0
    clocks.pass_by(WINDOW_S)
    assert n_played(guard(tmp_path, clocks), clocks) == 3


@given(st.lists(st.floats(-1e5, 1e5), max_size=5), st.floats(0.0, 1e5), st.booleans())
def test_age_of_signal_is_never_overestimated(jumps_s, passed_s, is_restarted):
    clocks = Clocks()
    played = clocks.now()
    for jump_s in jumps_s:
        clocks.utc_s += jump_s
        clocks.pass_by(passed_s / len(jumps_s))
    true_s = passed_s if jumps_s else 0.0
    assert played.ago_s(clocks.now()) == pytest.approx(true_s, abs=1e-3)
    if is_restarted:
        clocks.start_anew(off_s=10.0)
        assert played.ago_s(clocks.now()) >= 0.0


def test_outputs_are_counted_separately(tmp_path, clocks):
    assert [n_played(guard(tmp_path, clocks, name), clocks) for name in ("one", "one", "other")] == [3, 0, 3]


def test_refused_signal_is_not_counted(tmp_path, clocks):
    n_played(guard(tmp_path, clocks), clocks)
    assert n_rows(tmp_path) == 3


def n_rows(path):
    [(number,)] = sqlite3.connect(path / "outputs.sqlite3").execute("SELECT count(*) FROM emissions")
    return number


def _play_and_die(path):
    output = Guarded(FileOutput(FileSettings(str(path / "played"))), LIMITS, ledger=Ledger(path / "outputs.sqlite3"))
    output.open()
    output.play(volts(3.0))
    os.kill(os.getpid(), signal.SIGKILL)


def test_signal_of_a_killed_process_is_counted(tmp_path):
    process = multiprocessing.get_context("spawn").Process(target=_play_and_die, args=(tmp_path,))
    process.start()
    process.join()
    assert process.exitcode == -signal.SIGKILL
    driver = FileOutput(FileSettings(str(tmp_path / "played")))
    output = Guarded(driver, LIMITS, ledger=Ledger(tmp_path / "outputs.sqlite3"))
    output.open()
    time.sleep(0.1)
    with pytest.raises(LimitExceeded, match=r"limits\.duty"):
        output.play(volts(3.0))
    output.close()


def test_two_open_sessions_share_one_allowance(tmp_path, clocks):
    one, other = guard(tmp_path, clocks), guard(tmp_path, clocks)
    one.open()
    other.open()
    for output in (one, other, one):
        output.play(volts())
        clocks.pass_by(1.0)
    with pytest.raises(LimitExceeded, match=r"limits\.duty"):
        other.play(volts())


@pytest.mark.parametrize("content", [b"no database, but longer than the header of one" * 50, None])
def test_guard_refuses_ledger_that_cannot_be_kept(tmp_path, clocks, content):
    path = tmp_path / "outputs.sqlite3"
    path.mkdir() if content is None else path.write_bytes(content)
    with pytest.raises((DeviceFailed, InvalidFile), match=r"outputs\.sqlite3: "):
        guard(tmp_path, clocks).open()


@pytest.mark.parametrize(
    ("column", "value"),
    [*product(["boot_s", "utc_s", "duration_s"], ["text", b"\xff", float("inf"), -float("inf")]), ("duration_s", -1.0)],
)
def test_guard_refuses_ledger_with_damaged_row(tmp_path, clocks, column, value):
    n_played(guard(tmp_path, clocks), clocks)
    begun = guard(tmp_path, clocks)
    begun.open()
    with closing(sqlite3.connect(tmp_path / "outputs.sqlite3", isolation_level=None)) as database:
        database.execute(f"UPDATE emissions SET {column} = ?", (value,))
    for act in (lambda: begun.play(volts()), guard(tmp_path, clocks).open):
        with pytest.raises(DeviceFailed, match=r"outputs\.sqlite3: .*row 1: found .*, expected finite numbers"):
            act()
    begun.close()


def test_full_disk_refuses_signal_with_its_cause(tmp_path, clocks):
    n_played(guard(tmp_path, clocks), clocks)
    clocks.pass_by(WINDOW_S)
    output = guard(tmp_path, clocks)
    output.open()
    largest = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, largest[1]))
    try:
        with pytest.raises(DeviceFailed, match=r"\((disk I/O|.*full)"):
            output.play(volts())
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, largest)
    assert n_played(output, clocks) == 3


@pytest.mark.parametrize(("since_s", "n_kept"), [(3599.0, 1), (3601.0, 0)])
def test_ledger_forgets_signals_older_than_any_window(tmp_path, clocks, since_s, n_kept):
    output = guard(tmp_path, clocks)
    output.open()
    output.play(volts(3.0))
    clocks.pass_by(3.0)
    output.close()
    output = guard(tmp_path, clocks)
    clocks.pass_by(since_s)
    output.open()
    output.close()
    assert n_rows(tmp_path) == n_kept


def test_stopped_signal_counts_what_the_device_has_buffered(tmp_path, clocks):
    """Five signals stopped after 0.1 s count 0.6 s each, 3 s in all."""
    output = guard(tmp_path, clocks)
    output.driver.late_s = 0.5
    output.open()
    for _ in range(5):
        output.play(volts())
        clocks.pass_by(0.1)
        output.stop()
        clocks.pass_by(1.0)
    output.close()
    assert n_played(guard(tmp_path, clocks), clocks) == 0


def test_age_uses_wall_clock_after_a_restart():
    assert Moment("a", 10.0, 1000.0).ago_s(Moment("b", 20.0, 5000.0)) == 4000.0


def test_signal_may_end_in_another_thread(tmp_path, clocks):
    output = guard(tmp_path, clocks)
    output.open()
    output.play(volts(3.0))
    thread = threading.Thread(target=output.stop)
    thread.start()
    thread.join()
    clocks.pass_by(5.0)  # so that closing it does not end the signal in time
    output.close()
    assert n_played(guard(tmp_path, clocks), clocks) == 3


def test_ledger_is_in_the_state_folder_of_account(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    path = ledgers.default_path()
    assert path == tmp_path / "tactometry" / "outputs.sqlite3"
    Ledger(path).open("card")
    assert (path.parent.stat().st_mode & 0o777, path.stat().st_mode & 0o777) == (0o700, 0o600)


STEPS = st.one_of(
    st.tuples(st.just("play"), st.floats(0.01, 4.0)),
    st.tuples(st.just("wait"), st.floats(0.0, 30.0)),
    st.tuples(st.just("stop"), st.just(0.0)),
    st.tuples(st.just("set the wall clock"), st.floats(-1e4, 1e4)),
    st.tuples(st.just("another session"), st.just(0.0)),
)


class Account:
    """Independent record of when the output emitted."""

    def __init__(self):
        self.intervals_s = []

    def end(self, now_s):
        if self.intervals_s:
            begin_s, end_s = self.intervals_s[-1]
            self.intervals_s[-1] = begin_s, min(end_s, now_s)

    def largest_s(self, *more):
        """Return the longest time played in any window that ends with a signal."""
        intervals_s = [*self.intervals_s, *more]
        return max(
            sum(max(0.0, min(b, last_s) - max(a, last_s - WINDOW_S)) for a, b in intervals_s)
            for _, last_s in intervals_s
        )


@given(st.lists(STEPS, max_size=25))
def test_no_window_plays_longer_than_duty_allows(steps):
    clocks, account = Clocks(), Account()
    with pytest.MonkeyPatch.context() as patch, tempfile.TemporaryDirectory() as folder:
        patch.setattr(ledgers.Moment, "now", clocks.now)
        output = guard(Path(folder), clocks)
        output.open()
        for step, amount in steps:
            follow(step, amount, output, clocks, account)
        output.close()


def follow(step, amount, output, clocks, account):
    """Do one step and compare what is played or refused with the account."""
    allowed_s = LIMITS.duty * WINDOW_S
    if step == "wait":
        clocks.pass_by(amount)
    elif step == "set the wall clock":
        clocks.utc_s += amount
    elif step == "play":
        wanted = volts(amount)
        kept = list(account.intervals_s)
        account.end(clocks.boot_s)
        new = (clocks.boot_s, clocks.boot_s + wanted.duration_s)
        try:
            output.play(wanted)
        except LimitExceeded:
            assert account.largest_s(new) > allowed_s - 1e-6
            account.intervals_s = kept
        else:
            account.intervals_s.append(new)
            assert account.largest_s() <= allowed_s + 1e-6
    else:
        account.end(clocks.boot_s)
        output.stop()
        if step == "another session":
            output.close()
            output.open()
