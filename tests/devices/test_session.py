"""Force-gated sessions with LSL or UDP sensors and audio output."""

import csv
import json
import os
import signal
import threading
from datetime import date

import numpy as np
import pytest
from benches import PRESSED_ELECTRODE, gain_toml
from emulated import Emulator, wait_for
from force_bench import BENCH, N_TRIALS, begin, study_in
from tables import trial_rows
from window_sitting import any_keys, sit

from tactometry.devices.outputs.audio import AudioSettings
from tactometry.devices.outputs.gain import Gain
from tactometry.experiments.data_sets.traces import read_traces
from tactometry.experiments.data_sets.validation import validate
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.study_file import load

HELD_UP = ("sensor_lost", "output_gap")
"""What a machine that is busy with other things does to a touch, which is then asked again."""


def test_session_with_force_and_sound_is_recorded(needed, display, alsa, tmp_path):
    study, device = study_in(tmp_path), Emulator("lsl", tmp_path, profile="1:100")
    bench = BENCH.format(stream=device.name, gain=gain_toml("audio tofile, int16"))
    terminal, process_end = os.openpty()
    env = {**alsa, "DISPLAY": os.environ["DISPLAY"], "TERM": "xterm"}
    process = begin(tmp_path, study, bench, env, stdin=process_end, stderr=process_end)
    os.close(process_end)
    seen, reader = [], threading.Thread(target=lambda: follow(terminal, seen), daemon=True)
    reader.start()
    try:
        status, _, _ = sit(process, display, any_keys(3))
        reader.join(10)
    finally:
        device.close()
    errors = b"".join(seen).decode()
    orders = ("noted", "this trial will be repeated", "the session continues")
    assert all(words in errors for words in ("p pause   g go on", "trial 1: ", "trial 1 of 3 ", *orders, "not valid"))
    assert status == 0, errors
    rows = trial_rows(tmp_path / "data")
    counted = [row for row in rows if row["invalid_reason"] not in HELD_UP]
    assert sorted(row["valid"] for row in counted) == ["0", *["1"] * N_TRIALS]
    assert {(row["force_mean_n"], row["force_in_band"]) for row in counted} == {("1", "1")}
    check_events(tmp_path / "data", rows)
    for row in counted:
        touch = read_traces(tmp_path / "data", int(row["trial"]))[int(row["attempt"]) - 1]
        held = touch.force.times_s >= touch.answer.gate_s - touch.request.hold_s
        assert set(touch.force.values[held]) == {1.0}
        assert touch.answer.gate_s <= touch.answer.onset_s
        assert touch.force.times_s[-1] >= touch.answer.onset_s + 0.15
        assert (touch.position, touch.emitted.duration_s) == (None, 0.2)
    [journal] = (tmp_path / "data" / "journals").glob("*.jsonl")
    facts = json.dumps(json.loads(journal.read_text().splitlines()[0]))
    names = (f'"lsl {device.name}"', f'"{date.today()} ZG"', '"electrode"', '"hand_clock_offset_s"')
    assert all(fact in facts for fact in ('"audio tofile"', '"output_device": "tofile"', *names)), facts
    assert played_signals(tmp_path) == [N_TRIALS + 1, True] or counted != rows


def follow(terminal, seen):
    orders = [("trial 1: ", "n the finger is dry\nr\np\n"), ("paused", "g\n")]
    while True:
        try:
            seen.append(os.read(terminal, 4096))
        except OSError:
            return
        if orders and orders[0][0].encode() in b"".join(seen):
            os.write(terminal, orders.pop(0)[1].encode())


def test_session_pauses_when_network_sensor_dies(display, tmp_path, in_background):
    study, device = study_in(tmp_path, 1, "1 s"), Emulator("udp", tmp_path, profile="1:100")
    played, data = tmp_path / "played", tmp_path / "data"
    bench = PRESSED_ELECTRODE.format(folder=played, port=device.udp_port)
    process = begin(tmp_path, study, bench, os.environ)

    def go_on_when(what):
        wait_for(lambda: what() or process.poll() is not None)

    def die_and_come_back():
        go_on_when(lambda: any(played.glob("*.npz")))
        device.unplug()
        go_on_when(lambda: any("silent" in path.read_text() for path in data.glob("journals/*_events.tsv")))
        device.plug()

    in_background(die_and_come_back)
    try:
        status, _, errors = sit(process, display, any_keys(4))
    finally:
        device.close()
    assert (status, errors.count("\n")) == (0, 1)
    assert errors.startswith("bench file, force.release = false: a force sensor that is stuck")
    rows = trial_rows(data)
    *lost, counted = rows
    assert [row["attempt"] for row in rows] == [str(n + 1) for n in range(len(rows))]
    assert {(row["valid"], row["invalid_reason"]) for row in lost} == {("0", "sensor_lost")}
    assert {row["force_mean_n"] for row in lost} <= {"1", ""}  # it may die before its first sample in the stimulus
    assert (counted["valid"], counted["force_mean_n"]) == ("1", "1")
    events = [(event["trial_type"], event["text"]) for event in events_of(data) if event["text"] != "n/a"]
    pause = [("pause", "the force sensor is silent"), ("resume", "the force sensor is silent")]
    # a busy machine may lose the sensor again, or begin before its first half second
    assert events == max(1, len(events) // 2) * pause
    assert len(list(played.glob("*.npz"))) == sum(row["level_delivered"] != "" for row in rows) >= 2
    assert validate(data).defects == ()


def events_of(data):
    [path] = (data / "journals").glob("*_events.tsv")
    lines = path.read_text(encoding="utf-8").splitlines()
    return list(csv.DictReader(lines, delimiter="\t", quoting=csv.QUOTE_NONE))


def check_events(data, rows):
    events = events_of(data)
    kinds = [event["trial_type"] for event in events if event["text"] != "the force sensor is silent"]
    assert [kinds.count(kind) for kind in ("remark", "repeat", "pause", "resume")] == [1, 1, 1, 1]
    trials = [event for event in events if event["trial_type"] == "trial"]
    assert [(each["trial"], each["attempt"]) for each in trials] == [(row["trial"], row["attempt"]) for row in rows]
    for each in trials:
        assert float(each["n_frames"]) > 0
        assert 0 < float(each["frame_interval_median_s"]) <= float(each["frame_interval_max_s"])
        assert 0 <= float(each["gate_delay_s"]) < 60
    # no question follows a touch that a busy machine lost, so no key is pressed
    asked = [each for each, row in zip(trials, rows, strict=True) if row["valid"] == "1"]
    assert all(0 < float(each["key_to_record_s"]) < 60 for each in asked)
    clocks = {event["device"]: float(event["clock_offset_s"]) for event in events if event["trial_type"] == "clock"}
    assert clocks.keys() == {"hand", "output", "keyboard", "utc"}
    assert validate(data).defects == ()


def played_signals(folder):
    """Count the signals in the file of the card, and check each."""
    [stimulus] = wire(load(str(folder / "short.toml"))[0], "short").bank.values()
    output = AudioSettings(48e3, "tofile", sample_format="int16").driver(Gain(2.0, 50.0))
    wanted = np.trim_zeros(output._numbers(stimulus.at(34.0))[0])
    raw = np.frombuffer((folder / "played.raw").read_bytes(), "<i2")
    busy = np.flatnonzero(raw)
    pieces = np.split(busy, np.flatnonzero(np.diff(busy) > 1000) + 1)
    return [len(pieces), all(np.array_equal(raw[piece[0] : piece[-1] + 1], wanted) for piece in pieces)]


@pytest.mark.slow
@pytest.mark.parametrize(
    "number",
    [signal.SIGTERM, *(pytest.param(number, marks=pytest.mark.soak) for number in (signal.SIGHUP, signal.SIGKILL))],
)
def test_killed_session_falls_silent(needed, display, sink, tmp_path, in_background, number):
    study, device = study_in(tmp_path, duration="20 s"), Emulator("lsl", tmp_path, profile="1:100")
    gain = gain_toml("audio pulse, int16", system_volume=1.0)
    bench = BENCH.format(stream=device.name, gain=gain).replace('"tofile"', '"pulse"\nshared = true')
    process = begin(tmp_path, study, bench, {**sink.env, "DISPLAY": os.environ["DISPLAY"]})
    ended = threading.Event()

    def end_when_it_plays():
        wait_for(lambda: sink.heard() > 9600 or process.poll() is not None)
        process.send_signal(number)
        ended.set()

    in_background(end_when_it_plays)
    try:
        status, _, errors = sit(process, display, (key for key in ["space"] * 600 if not ended.is_set()))
    finally:
        device.close()
    frames = sink.end()
    assert status == (-number if number == signal.SIGKILL else 128 + number), errors
    assert "Traceback" not in errors
    assert 9600 < np.count_nonzero(frames) < 10 * 48_000
    assert not frames[-4800:].any()
