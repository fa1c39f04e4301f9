"""Touches read from sessions and sittings, with emitted signals."""

import shutil
from dataclasses import replace

import numpy as np
import pytest
from command_line import output
from places import RECORDED

from tactometry.errors import InvalidFile
from tactometry.experiments.data_sets import traces
from tactometry.experiments.data_sets.traces import read_traces, touches, trace_defects
from tactometry.records.data_set import Session, sessions
from tactometry.records.head import Head
from tactometry.records.journal import read
from tactometry.records.traces import TraceFiles
from tactometry.rigs.emitter import render
from tactometry.session.request import Adjust
from tactometry.signal import Signal

TWO_PEOPLE, TWO_SESSIONS = RECORDED / "yes-no", RECORDED / "format-2-quest-plus-tracks"
TRACES = RECORDED / "format-2-traces-console"


@pytest.fixture
def simulated(tmp_path, capsys):
    words = ("run", "tutorial", "--participant", "P01", "--rig", "simulated", "--seed", 1, "--out", tmp_path / "d")
    output(capsys, *words)
    return tmp_path / "d"


def test_traces_of_one_of_several_people_or_sessions():
    for code in ("P01", "P02"):
        assert [touch.head.participant for touch in read_traces(TWO_PEOPLE, 1, participant=code)] == [code]
    for n in (1, 2):
        assert [touch.head.session for touch in read_traces(TWO_SESSIONS, 1, session=n)] == [n]


def test_several_sessions_are_refused_where_none_is_named():
    with pytest.raises(InvalidFile, match="found 2 sessions of P01, expected one"):
        read_traces(TWO_SESSIONS, 1, participant="P01")


def test_touch_belongs_to_the_first_row():
    recording = read(sessions(RECORDED / "time-reversal-patterns")[0])
    rows = {}
    for row in recording.trials:
        rows.setdefault(row.key, []).append(row)
    felt = list(touches(recording))
    assert all(len(rows[touch.trial.key]) > 1 for touch in felt)
    assert [touch.trial for touch in felt] == [rows[touch.trial.key][0] for touch in felt]


def test_touch_has_the_head_of_its_sitting():
    recording = read(next(path for path in sessions(RECORDED / "format-2-bench") if "-P01_" in path.name))
    heads = [line for line in recording.lines if isinstance(line, Head)]
    felt = [(touch.head, touch.answer.onset_s) for touch in touches(recording)]
    assert [head for head, _ in felt] == [
        max((head for head in heads if head.begun_s <= onset_s), key=lambda head: head.begun_s) for _, onset_s in felt
    ]
    assert len({head.begun_s for head, _ in felt}) > 1


class Step:
    """Stimulus that begins and ends with a step."""

    def at(self, level):
        return Signal(np.full((1, 1000), level), 20e3, "V")


def test_emitted_signal_has_the_recorded_ramps():
    touch = next(touches(read(sessions(TRACES)[0])))
    name, level = touch.request.stimulus, touch.request.level
    played = render({name: Step()}, name, level, None, touch.head.facts["ramp_s"])
    assert played.digest() != Step().at(level).digest()
    touch = touch._replace(answer=replace(touch.answer, digest=played.digest()))
    np.testing.assert_array_equal(traces._computed(touch, {name: Step()}).samples, played.samples)


def test_adjustment_has_no_emitted_signal():
    touch, *_ = read_traces(RECORDED / "adjustment", 1)
    assert isinstance(touch.request, Adjust)
    assert (touch.emitted, touch.unknown) == (None, None)


def test_changed_stimulus_has_no_emitted_signal(simulated):
    played, *_ = read_traces(simulated, 2)
    assert (played.emitted.digest(), played.unknown) == (played.answer.digest, None)
    study = simulated / "study.toml"
    study.write_text(study.read_text("utf-8").replace("500 ms", "400 ms"), "utf-8")
    other, *_ = read_traces(simulated, 2)
    assert other.emitted is None
    assert "It was recorded by another version, or on a bench" in other.unknown


def test_traces_whose_columns_nothing_explains_are_a_defect(tmp_path):
    root = shutil.copytree(TRACES, tmp_path / "d")
    (beside,) = (root / "traces").glob("*_physio.json")
    recording = read(sessions(root)[0])
    assert list(trace_defects(root, recording)) == []
    beside.unlink()
    (defect,) = trace_defects(root, recording)
    assert defect.file == f"traces/{beside.name}"


def test_emitted_texture_has_rate_and_all_channels(tmp_path):
    table = np.random.default_rng().uniform(-10.0, 10.0, (50, 3))
    files = TraceFiles(tmp_path, Session("P01", 1, "study"))
    part = files.keep("emitted", table, 48e3)
    files.close()
    signal = traces._stored(tmp_path, part)
    assert signal.rate_hz == 48e3
    np.testing.assert_allclose(signal.samples, table.T, rtol=1e-6)
