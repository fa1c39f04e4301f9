"""Status line, messages and typed input on an emulated terminal."""

import os
import pty
import select
import sys
import termios
import time
from dataclasses import replace

import pytest
from hypothesis import given, strategies as st
from patience import LONGEST_WAIT_S

from tactometry.rigs.experimenter.live import LiveTerminal, Typed, has_status_area
from tactometry.rigs.experimenter.terminal import ExperimenterTerminal, StatusLine, status_words
from tactometry.session.answer import Done
from tactometry.session.event import Event
from tactometry.session.progress import PartAhead, Progress
from tactometry.session.request import Record
from tactometry.trials.trial import Trial

pyte = pytest.importorskip("pyte", reason="no pyte: pip install pyte")

TRIAL = Trial(1, 1, {"frequency_hz": 60.0}, "staircase", 12.0, "dB re 1 V", "yes_no", 1)
PARTS = (PartAhead({"frequency_hz": 60.0}, 20, 100.0, 5), PartAhead({"frequency_hz": 240.0}, 20, 100.0, 5))
HIGH = 60


class Seen:
    """The rendered screen of a terminal whose other end is `master`."""

    def __init__(self, master, width=100):
        self.screen = pyte.Screen(width, HIGH)
        self._stream, self.master = pyte.ByteStream(self.screen), master
        self.data = b""

    def rows(self):
        while select.select([self.master], [], [], 0)[0]:
            try:
                data = os.read(self.master, 4096)
            except OSError:  # the program has ended
                break
            self.data += data
            self._stream.feed(data)
        return [row.rstrip() for row in self.screen.display if row.strip()]

    def until(self, holds):
        end_s = time.monotonic() + LONGEST_WAIT_S
        while not holds(found := self.rows()):
            assert time.monotonic() < end_s, found
            time.sleep(0.01)


@pytest.fixture
def desk(monkeypatch):
    monkeypatch.setenv("TERM", "xterm")
    master, slave = pty.openpty()
    termios.tcsetwinsize(slave, (HIGH, 100))
    source, output = open(slave, closefd=False), open(slave, "w", closefd=False)  # noqa: SIM115
    terminal = LiveTerminal(source, output)
    yield terminal, Seen(master), slave
    terminal.close()
    source.close()
    output.close()
    os.close(slave)
    os.close(master)


def test_status_line_is_between_messages_and_input(desk):
    terminal, seen, _ = desk
    terminal.status("trial 1 of 40")
    terminal.add("trial 1: tone 12")
    os.write(seen.master, b"n the hand mo")
    seen.until(lambda rows: rows[-1] == "> n the hand mo")
    terminal.tell("a library speaks")
    terminal.add("played, 1.00 N")
    assert seen.rows()[-4:] == [
        "a library speaks",
        "trial 1: tone 12 | played, 1.00 N",
        "trial 1 of 40",
        "> n the hand mo",
    ]
    os.write(seen.master, b"ved\x7fed\n")
    seen.until(lambda rows: rows[-1] == ">")
    [order] = terminal.orders()
    assert (order.wish, order.text) == ("note", "the hand moveed")
    terminal.end_line()
    terminal.status("trial 2 of 40")
    assert seen.rows()[-3:] == ["trial 1: tone 12 | played, 1.00 N", "trial 2 of 40", ">"]


def test_native_library_output_gets_separate_lines(desk):
    terminal, seen, slave = desk
    terminal.close()
    file = os.dup(slave)
    with open(slave, closefd=False) as source, open(slave, "w", closefd=False) as output:
        heard = LiveTerminal(source, output, [file])
        heard.status("trial 1 of 40")
        heard.add("trial 1: tone 12")
        os.write(file, b"ALSA lib pcm.c:8570: underrun occ")
        os.write(file, b"urred\nand \x1b[2Jmore\n")
        seen.until(lambda rows: "and [2Jmore" in rows)
        assert seen.rows()[-5:] == [
            "ALSA lib pcm.c:8570: underrun occurred",
            "and [2Jmore",
            "trial 1: tone 12",
            "trial 1 of 40",
            ">",
        ]
        os.write(file, b"the last word")
        heard.close()
        assert seen.rows()[-2:] == ["trial 1: tone 12", "the last word"]
        os.write(file, b"a shell's\n")
        assert seen.rows()[-1] == "a shell's"
    os.close(file)


def test_terminal_settings_are_restored_on_close(desk):
    terminal, seen, slave = desk
    during = termios.tcgetattr(slave)[3]
    terminal.close()
    after = termios.tcgetattr(slave)[3]
    assert (bool(during & termios.ECHO), bool(after & termios.ECHO)) == (False, True)
    terminal.tell("nothing more")
    assert "nothing more" not in seen.rows()


def test_narrow_terminal_truncates_status_and_input(desk):
    terminal, seen, slave = desk
    termios.tcsetwinsize(slave, (HIGH, 20))
    seen.screen.resize(HIGH, 20)
    terminal.status("trial 1 of 40 · 3 min left")
    os.write(seen.master, b"n a remark that is long")
    seen.until(lambda rows: rows[-2:] == ["trial 1 of 40 · 3…", "…mark that is long"])


@given(st.lists(st.sampled_from(["a", "é", "\x7f", "\x1b[A", "\t", "\x15", "n"])))
def test_typed_line_follows_editing_keys(keys):
    typed, expected = Typed(), ""
    for key in keys:
        expected = {"\x7f": expected[:-1], "\x1b[A": expected, "\t": expected, "\x15": ""}.get(key, expected + key)
        for letter in key:
            typed, line = typed.after(letter)
            assert line is None
    assert typed == Typed(expected)


def test_status_line_reports_progress_and_problems():
    progress = Progress()
    for number, trial in enumerate((TRIAL, replace(TRIAL, trial=2, level=None, catch=True)), 1):
        progress = progress.after(Record(trial), Done(5.0 * number))
    progress = progress.after_event(Event("trial", 10.0, facts={"n_frames": 300, "n_dropped_frames": 7}))
    words = status_words(progress, PARTS)
    assert words == (
        "trial 3 of 40 · 4 min left · frequency_hz 60 · last blank · 0 reversals · 1 false alarm of 1 · "
        "7 frames dropped · 0 gaps"
    )
    aborted = progress.after(Record(TRIAL, aborted="block 1 is aborted: so"), Done(20.0))
    assert "1 aborted" in status_words(aborted, PARTS)


def test_abort_warning_is_printed_once_per_presentation(desk):
    terminal, seen, _ = desk
    status = StatusLine(terminal, PARTS)
    for number in range(1, 5):
        lost = replace(TRIAL, attempt=number, valid=False, invalid_reason="too_light")
        status.on_request(Record(lost), Done(5.0 * number))
        status.on_event(Event("remark", 5.0 * number + 1, facts={"text": "x"}))
    said = [row for row in seen.rows() if row.startswith("!")]
    assert said == [
        "! the last 3 touches did not count: 2 more abort this condition",
        "! the last 4 touches did not count: 1 more aborts this condition",
    ]


def test_status_is_stored_when_terminal_is_dumb(monkeypatch, desk):
    _, _, slave = desk
    with open(slave, closefd=False) as source, open(slave, "w", closefd=False) as output:
        assert has_status_area(source, output)
        monkeypatch.setenv("TERM", "dumb")
        assert not has_status_area(source, output)
    assert not has_status_area(None, sys.stderr)
    plain = ExperimenterTerminal()
    plain.status("trial 1 of 40")
    assert plain.status_text == "trial 1 of 40"
