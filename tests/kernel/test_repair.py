"""Repair of a journal, killed before or after any of its system calls."""

import json
import os
import re
import signal
import sys

import pytest
from full_disk import files_of_at_most
from hard_cases import exact_case
from tutorial_session import journal_of

from tactometry.errors import DeviceFailed, SessionInUse
from tactometry.files.durable import drafts
from tactometry.records.journal import encode_line, read
from tactometry.records.open_journal import Journal
from tactometry.session.answer import Done
from tactometry.session.event import Event
from tactometry.session.request import Wait

REMARKS = tuple(
    Event("remark", float(n), facts={"text": text})
    for n, text in enumerate(("participant reports pain", "stopped by hand"))
)
CALLS = re.findall(r"\w+", "open close read write fsync lseek ftruncate rename replace unlink fchmod stat")


@pytest.fixture
def cut_off(lived):
    """Journal with an unfinished trial, remarks and a torn last line."""
    path = journal_of(lived)
    lines = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(b"".join(lines[:12]))
    journal = Journal(path, resume=True)
    for n, event in enumerate(REMARKS):
        journal.append(Wait(1.0), Done(float(n)))
        journal.note(event)
    journal.append(Wait(1.0), Done(9.0))
    journal.close()
    journal.interruptions.unlink(missing_ok=True)
    with path.open("ab") as file:
        file.write(b'{"request":"Slide","as')
    return path


def killed_at(n_calls, path):
    """Return True if a repair was killed, False if it finished."""
    child = os.fork()
    if child == 0:
        left = n_calls

        def count(frame, event, called):
            nonlocal left
            if event in ("c_call", "c_return") and called.__name__ in CALLS:
                left -= 1
                if left == 0:
                    os.kill(os.getpid(), signal.SIGKILL)

        sys.setprofile(count)
        Journal(path, resume=True).close()
        os._exit(0)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == -signal.SIGKILL


def repaired(path):
    Journal(path, resume=True).close()
    return path.read_bytes()


def test_repair_loses_nothing_when_killed_at_any_call(cut_off):
    torn, kept = cut_off.read_bytes(), read(cut_off).events
    assert kept[-2:] == REMARKS
    interruptions = Journal(cut_off, resume=True)
    interruptions.close()
    whole, interruptions = cut_off.read_bytes(), interruptions.interruptions
    kept_bytes, n_calls = interruptions.read_bytes(), 0
    while True:
        cut_off.write_bytes(torn)
        interruptions.unlink(missing_ok=True)
        n_calls += 1
        if not killed_at(n_calls, cut_off):
            break
        assert read(cut_off).events == kept
        assert cut_off.read_bytes() in (torn, whole)
        assert repaired(cut_off) == whole
        assert kept_bytes in interruptions.read_bytes()
    assert n_calls > 20
    exact_case("a repair killed around any system call", against="every trial, remark and stop")


def test_repaired_journal_is_locked_and_readable(cut_off):
    held = Journal(cut_off, resume=True)
    with pytest.raises(SessionInUse):
        Journal(cut_off, resume=True)
    held.note(Event("remark", 9.0, facts={"text": "later"}))
    held.close()
    assert [event.facts["text"] for event in read(cut_off).events][-1] == "later"


def test_journal_is_reopened_when_replaced_during_opening(cut_off, monkeypatch):
    """A process that waited for the lock of the old file locks the new one."""
    from tactometry.records import open_journal as module

    lock, content = module._lock, cut_off.read_bytes()

    def replaced_meanwhile(file, path, *in_use):
        lock(file, path, *in_use)
        if os.fstat(file).st_ino == first:
            path.with_name("other").write_bytes(content)
            path.with_name("other").replace(path)

    first = cut_off.stat().st_ino
    monkeypatch.setattr(module, "_lock", replaced_meanwhile)
    opened = Journal(cut_off, resume=True)
    opened.note(REMARKS[0])
    opened.close()
    assert read(cut_off).events[-1] == REMARKS[0]


def test_repair_leaves_journal_unchanged_when_disk_is_full(cut_off):
    torn = cut_off.read_bytes()
    with files_of_at_most(len(torn) // 2), pytest.raises(DeviceFailed, match="expected free disk space"):
        Journal(cut_off, resume=True)
    assert cut_off.read_bytes() == torn
    assert drafts(cut_off.parent) == []


def test_repair_keeps_cut_bytes_in_interruptions_file(cut_off):
    journal = Journal(cut_off, resume=True)
    journal.close()
    (line,) = journal.interruptions.read_text().splitlines()
    assert json.loads(line)["cut"].endswith('{"request":"Slide","as')
    assert encode_line(REMARKS[0])[:40].decode() in json.loads(line)["cut"]
