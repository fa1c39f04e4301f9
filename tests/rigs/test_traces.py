"""Recorded force and position traces of each touch."""

import json
import shutil
from types import SimpleNamespace

import numpy as np
import pytest
from benches import FILE_BENCH, UDP_HAND
from command_line import at_the_console, call
from emulated import Emulator
from kept_events import Kept
from study_texts import tutorial_in
from tables import trial_rows

from tactometry.experiments.data_sets.touch_courses import touch_courses
from tactometry.experiments.data_sets.traces import read_traces
from tactometry.experiments.data_sets.validation import validate
from tactometry.records.journal import checksum, encode
from tactometry.rigs.device_rig import Tracer
from tactometry.session.answer import Adjusted, Done

SHORT = {
    "frequency_hz = [60, 240]": "frequency_hz = [60]",
    '"500 ms"': '"100 ms"',
    '"300 ms"': '"20 ms"',
    "catch_rate = 0.2": "catch_rate = 0.0",
    "levels = [22, 28, 34, 40]": "levels = [34]",
    "repeats = 4": "repeats = 2",
}
METRES_PER_COUNT = 5e-5
MOVING = f"""
[position]
sensor = "hand"
channels = [0]
metres_per_count = {METRES_PER_COUNT}
"""
PROFILE = "0.2:30,1:100"
"""Alternates between released and held at 1 N; the emulated finger moves by one count per sample."""


def words(folder, device, bench="", out="d", changes=None):
    """Return the arguments of a console session with a UDP sensor, answered by 1."""
    text = FILE_BENCH.format(folder=folder / "played", duty=1.0, window_s=60)
    path = folder / "bench.toml"
    path.write_text(text + UDP_HAND.format(port=device.udp_port) + MOVING + bench, encoding="utf-8")
    study = tutorial_in(folder, SHORT | (changes or {}))
    return study, folder / out, "1\n" * 40, "--bench", path


def sit(folder, capsys, monkeypatch, **how):
    device = Emulator("udp", folder, profile=PROFILE)
    try:
        return at_the_console(capsys, monkeypatch, *words(folder, device, **how))[:2]
    finally:
        device.close()


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    folder = tmp_path_factory.mktemp("recorded")
    with pytest.MonkeyPatch.context() as patch:
        silent = SimpleNamespace(readouterr=lambda: SimpleNamespace(out="", err=""))
        status, errors = sit(folder, silent, patch)
    assert status == 0, errors
    return folder / "d"


@pytest.fixture
def copied(recorded, tmp_path):
    shutil.copytree(recorded, tmp_path / "d")
    return tmp_path / "d"


def valid_touches(root):
    """Return each valid row with its touch; other rows may lack the sensor."""
    rows = [row for row in trial_rows(root) if row["valid"] == "1"]
    assert rows
    return [(row, read_traces(root, int(row["trial"]))[int(row["attempt"]) - 1]) for row in rows]


def test_trace_contains_every_sensor_sample_once(recorded):
    for _, touch in valid_touches(recorded):
        assert set(touch.force.values.tolist()) <= {0.3, 1.0}
        counts = touch.position.values[:, 0] / METRES_PER_COUNT
        np.testing.assert_allclose(np.diff(counts), 1.0, atol=1e-6)  # no sample is lost or duplicated
        for times_s, values in (touch.force, touch.position):
            assert len(times_s) == len(values)
            assert np.all(np.diff(times_s) >= 0)
            assert times_s[0] < touch.answer.gate_s <= times_s[-1]


def test_trial_row_matches_its_trace(recorded):
    for row, touch in valid_touches(recorded):
        begin_s, (times_s, forces_n) = float(row["onset_s"]), touch.force
        during = (times_s >= begin_s) & (times_s <= begin_s + touch.request.duration_s)
        assert forces_n[during].mean() == pytest.approx(float(row["force_mean_n"]), abs=1e-6)
        # the gate opened on a sample after the force had been held
        held = (times_s <= touch.answer.gate_s) & (times_s >= touch.answer.gate_s - touch.request.hold_s)
        assert np.min(np.abs(times_s - touch.answer.gate_s)) <= 1.5e-6  # both are recorded to a microsecond
        assert np.all(forces_n[held] == 1.0)


def test_ungated_speed_has_no_band(recorded):
    courses = touch_courses(recorded)
    speeds = courses[courses["quantity"] == "speed_m_per_s"]
    assert len(speeds) > 1
    assert speeds[["band_low", "band_high"]].isna().all(axis=None)


def test_trace_files_have_sidecars_and_load_in_pandas(recorded):
    import pandas as pd

    stems = sorted(path.name.removesuffix(".tsv.gz") for path in (recorded / "traces").glob("*.tsv.gz"))
    whose = "participant-P01_session-1_study-tutorial"
    assert stems == [f"{whose}_recording-force_physio", f"{whose}_tracksys-finger_motion"]
    for stem in stems:
        explained = json.loads((recorded / "traces" / f"{stem}.json").read_text("utf-8"))
        table = pd.read_csv(recorded / "traces" / f"{stem}.tsv.gz", sep="\t", header=None, names=explained["Columns"])
        assert explained["SamplingFrequency"] == 1000
        assert {explained[name]["Units"] for name in explained["Columns"]} <= {"s", "N", "m"}
        assert len(table) >= 200
        assert table["time_s"].is_monotonic_increasing


def test_bench_file_selects_recorded_traces(tmp_path, capsys, monkeypatch):
    status, errors = sit(tmp_path, capsys, monkeypatch, bench="[traces]\nposition = false\n")
    assert status == 0, errors
    touch, *_ = read_traces(tmp_path / "d", 1)
    assert (touch.position, len(touch.force.times_s) > 100) == (None, True)
    (journal,) = (tmp_path / "d" / "journals").glob("*.jsonl")
    assert json.loads(journal.read_text().splitlines()[0])["facts"]["traces"] == "force, emitted"
    status, errors = sit(tmp_path, capsys, monkeypatch, bench="[traces]\nspeed = false\n", out="e")
    assert (status, "bench.toml" in errors, "speed" in errors) == (2, True, True)


@pytest.mark.slow
def test_session_without_traces_has_no_traces_folder(tmp_path, capsys, monkeypatch):
    status, errors = sit(tmp_path, capsys, monkeypatch, bench="[traces]\nposition = false\nforce = false\n")
    assert status == 0, errors
    assert not (tmp_path / "d" / "traces").exists()
    assert validate(tmp_path / "d").defects == ()


def test_validate_names_changed_trace_files(copied):
    assert validate(copied).defects == ()
    force, position = sorted((copied / "traces").glob("*.tsv.gz"))
    kept = force.read_bytes()
    force.write_bytes(kept[:50] + bytes([kept[50] ^ 1]) + kept[51:])
    (defect,) = validate(copied).defects
    assert str(defect).startswith(f"traces/{force.name}: found other samples than were stored from byte 0 on")
    force.unlink()
    force.with_name(force.name.replace(".tsv.gz", ".json")).unlink()
    words = [str(defect) for defect in validate(copied).defects]
    assert any(f"traces/{force.name}: cannot be read" in said for said in words), words
    assert not any(position.name in said for said in words)


def test_data_set_with_traces_replays_analyses_and_rebuilds(copied, capsys):
    for words in (("replay",), ("analyse",), ("rebuild",), ("replay",)):
        assert call(capsys, *words, copied)[0] == 0
    assert validate(copied).defects == ()


def test_validate_rejects_trace_path_outside_traces_folder(copied, capsys):
    (path,) = (copied / "journals").glob("*.jsonl")
    first, *rest = path.read_bytes().splitlines(keepends=True)
    forged = [first]
    for line in rest:
        table = json.loads(line)
        del table["crc32"]
        for part in (table.get("answer") or {}).get("trace", ()):
            part["file"] = "traces/../study.toml"
        forged.append(encode(table, checksum(forged[-1])))
    path.write_bytes(b"".join(forged))
    status, _, said = call(capsys, "validate", copied)
    assert status == 1
    assert "found a trace in 'traces/../study.toml', expected a part of a file in the folder traces" in said


def test_samples_before_a_touch_are_excluded():
    log, blocks = Kept(), [(np.array([1.0]), np.array([5.0])), (np.array([2.0]), np.array([6.0]))]
    source = SimpleNamespace(rate_hz=1000.0)
    sensor = SimpleNamespace(read=lambda: blocks.pop(0), reader=SimpleNamespace(source=source))
    tracer = Tracer({"force": sensor}, None, log, lambda at_s: at_s - 0.5)
    tracer.begin()
    assert tracer.kept(Done(1.0)) == Done(1.0)
    kept = tracer.kept(Adjusted(3.0, 2.0, 1.0))
    [(kind, table)] = log.traces
    assert (kind, table.tolist(), len(kept.trace)) == ("force", [[1.5, 6.0]], 1)
