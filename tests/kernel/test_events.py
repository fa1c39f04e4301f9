"""Events of a session: journal, replay, events table and validation."""

import json
from dataclasses import replace
from itertools import count

import numpy as np
import pytest
from examples import examples
from hypothesis import given, strategies as st
from tutorial_session import EXPERIMENT, TOML, WHO, journal_of

from tactometry.errors import InvalidParameter
from tactometry.experiments.data_sets.replaying import replay_data_set
from tactometry.experiments.data_sets.validation import validate
from tactometry.experiments.sessions.recording import RigKind, record, simulated
from tactometry.records.head import Head
from tactometry.records.journal import Entry, read
from tactometry.session.event import COLUMNS, FACTS, KINDS, Event, events_tsv
from tactometry.session.request import Record

REMARK = Event("remark", 1.5, "2026-11-21T09:00:00.000+00:00", {"text": 'a "tab"\t and a\nline, said twice'})


class Noting:
    """Rig that notes an event before every request and can fail at one."""

    def __init__(self, rig, log, fails_at):
        self._rig, self._log, self._fails_at, self._n = rig, log, fails_at, count(1)

    def __getattr__(self, name):
        return getattr(self._rig, name)

    def answer(self, request):
        n = next(self._n)
        self._log.note(replace(REMARK, at_s=float(n), facts={"text": f"before request {n}", "trial": n}))
        if n == self._fails_at:
            raise KeyboardInterrupt
        return self._rig.answer(request)


def noting(fails_at=None):
    make = simulated(EXPERIMENT, WHO).make
    return RigKind("simulated", lambda seed, log: Noting(make(seed, log), log, fails_at), simulated_time=True)


@pytest.fixture(scope="module")
def noted(tmp_path_factory):
    root = tmp_path_factory.mktemp("noted")
    record(EXPERIMENT, TOML, root, WHO, noting())
    return root


def events_file(root):
    [path] = (root / "journals").glob("*_events.tsv")
    return path


def test_replay_skips_events_between_requests(noted):
    recording = read(journal_of(noted))
    assert recording.complete
    assert [event.at_s for event in recording.events] == [float(n + 1) for n in range(len(recording.entries))]
    assert [type(line) for line in recording.lines] == [Head, *[Event, Entry] * len(recording.entries)]
    assert replay_data_set(noted)[0].n_trials == len(recording.trials)
    assert validate(noted).defects == ()


def test_events_table_has_all_events_and_column_descriptions(noted):
    header, *rows = (line.split("\t") for line in events_file(noted).read_text("utf-8").splitlines())
    assert header == [column.name for column in COLUMNS]
    assert header[:3] == ["onset", "duration", "trial_type"]
    assert len(rows) == len(read(journal_of(noted)).events)
    first = dict(zip(header, rows[0], strict=True))
    assert (first["onset"], first["trial_type"], first["trial"], first["device"]) == ("1.0", "remark", "1", "n/a")
    described = json.loads(events_file(noted).with_suffix(".json").read_text("utf-8"))
    assert list(described) == header
    assert all(each["Description"] for each in described.values())


@pytest.mark.parametrize("fails_at", [2, 9, 10, 11])
def test_resumed_session_keeps_every_event(tmp_path, fails_at):
    with pytest.raises(KeyboardInterrupt):
        record(EXPERIMENT, TOML, tmp_path, WHO, noting(fails_at))
    noted = [event.at_s for event in read(journal_of(tmp_path)).events]
    record(EXPERIMENT, TOML, tmp_path, WHO, noting(), resume=True)
    recording = read(journal_of(tmp_path))
    assert noted == [float(n + 1) for n in range(fails_at)]
    assert [event.at_s for event in recording.events][:fails_at] == noted
    assert events_file(tmp_path).read_bytes() == events_tsv(recording.events)
    assert validate(tmp_path).defects == ()


def test_resumed_session_keeps_events_after_last_trial(tmp_path):
    with pytest.raises(KeyboardInterrupt):
        record(EXPERIMENT, TOML, tmp_path, WHO, noting(12))
    before = read(journal_of(tmp_path))
    record(EXPERIMENT, TOML, tmp_path, WHO, noting(), resume=True)
    after = read(journal_of(tmp_path))
    rows = [n for n, line in enumerate(before.lines) if isinstance(line, Entry) and isinstance(line.request, Record)]
    assert after.lines[: rows[-1] + 2] == before.lines[: rows[-1] + 2]
    assert isinstance(before.lines[rows[-1] + 1], Event)


def test_session_without_events_has_no_events_table(lived):
    assert not list((lived / "journals").glob("*_events.*"))
    assert validate(lived).defects == ()


@pytest.mark.parametrize(
    ("how", "row", "message"),
    [
        (lambda path: path.unlink(), None, "found no such file, expected the events of the journal"),
        (lambda path: path.write_bytes(path.read_bytes().replace(b"request 3", b"request X")), 4, "a row that differs"),
        (lambda path: path.with_suffix(".json").unlink(), None, "found no description of its columns"),
    ],
    ids=["removed", "changed", "not described"],
)
def test_validate_names_defects_of_the_events_table(tmp_path, how, row, message):
    record(EXPERIMENT, TOML, tmp_path, WHO, noting())
    how(events_file(tmp_path))
    [found] = validate(tmp_path).defects
    assert (found.file, found.row) == ("journals/participant-P01_session-1_study-tutorial_events.tsv", row)
    assert message in found.text


names = st.sampled_from([column.name for column in FACTS])
values = st.one_of(
    st.none(), st.booleans(), st.integers(-(10**9), 10**9), st.floats(allow_nan=False, allow_infinity=False), st.text()
)


@given(kind=st.sampled_from(KINDS), at_s=st.floats(0, 1e6), facts=st.dictionaries(names, values))
@examples(50)
def test_every_event_is_one_table_row(kind, at_s, facts):
    event = Event(kind, at_s, None, facts)
    header, row = events_tsv([event]).decode().rstrip("\n").split("\n")
    assert len(row.split("\t")) == len(header.split("\t"))
    assert all(row.split("\t"))


@pytest.mark.parametrize("facts", [{"words": "x"}, {"clock_offset_s": np.inf}], ids=str)
def test_event_refuses_unknown_or_infinite_facts(facts):
    with pytest.raises(InvalidParameter, match="event 'remark': found .*expected names in FACTS and finite numbers"):
        Event("remark", 0.0, None, facts)
