"""Console rig with and without an output, and its stop keys."""

import io
import itertools
import json
import os
import pty
import select
import subprocess
import sys
import time
from dataclasses import replace

import catalogue
import pytest
from benches import file_bench
from command_line import at_the_console, call
from sampled import Sampled, force_sensor
from study_texts import tutorial_in
from tables import event_rows, trial_rows

from tactometry.devices.outputs.file import FileOutput, FileSettings
from tactometry.devices.outputs.guarded import Guarded
from tactometry.devices.sensors.reader import Reader
from tactometry.devices.sensors.streamed import ForceCalibration, streamed_force
from tactometry.errors import DeviceFailed
from tactometry.rigs.console import Console
from tactometry.rigs.device_rig import Equipment
from tactometry.rigs.texts import texts_in
from tactometry.safety.limits import Limits
from tactometry.session.request import Adjust, Play, Press, Show
from tactometry.stimuli.electrovibration import Sine

TONE = Sine(frequency_hz=60.0, duration_s=0.3, ramp_s=0.02, level_unit="V")
PRESS = Press("tone", 5.0, 0.3, target_n=1.0, tolerance=0.2, hold_s=0.1, timeout_s=5.0)
LIMITS = Limits(100.0)
SHORT = {'"500 ms"': '"100 ms"', '"300 ms"': '"20 ms"', "catch_rate = 0.2": "catch_rate = 0.0"}


def run(capsys, monkeypatch, folder, *more, answers="1\n" * 40, changes=SHORT):
    file_bench(folder, duty=1.0)
    return at_the_console(capsys, monkeypatch, tutorial_in(folder, changes), folder / "d", answers, *more)


def kinds(root):
    return [row["trial_type"] for row in event_rows(root)]


def test_console_states_that_nothing_plays_without_output(tmp_path, capsys, monkeypatch):
    status, _, out = run(capsys, monkeypatch, tmp_path)
    assert status == 0
    assert out.startswith("This terminal plays nothing: ")
    rows = trial_rows(tmp_path / "d")
    assert {(row["rig"], row["level_delivered"], row["valid"]) for row in rows} == {("console", "", "1")}
    assert {row["level"] for row in rows} == {"22", "28", "34", "40"}
    assert not list((tmp_path / "d" / "journals").glob("*_events.tsv"))
    warnings = json.loads(call(capsys, "analyse", tmp_path / "d", "--json")[2])["warnings"]
    told = "no stimulus was presented in some trials with a level (P01: 32 rows); these answers are invalid"
    assert told in warnings


def test_console_plays_every_stimulus_through_guard(tmp_path, capsys, monkeypatch):
    status, _, out = run(capsys, monkeypatch, tmp_path, "--bench", tmp_path / "bench.toml")
    assert status == 0
    assert out.startswith(f"Stimuli play through file {tmp_path / 'played'}.")
    assert len(list((tmp_path / "played").glob("*.npz"))) == 32
    assert all(row["level_delivered"] == row["level"] for row in trial_rows(tmp_path / "d"))
    assert kinds(tmp_path / "d") == ["stimulus", "stimulus_end"] * 32
    assert "nothing was played" not in call(capsys, "analyse", tmp_path / "d", "--json")[2]
    onsets_s = [float(row["onset_s"]) for row in trial_rows(tmp_path / "d")]
    assert min(b - a for a, b in itertools.pairwise(onsets_s)) >= 0.12


def test_adjustment_with_output_is_refused_before_writing(tmp_path, capsys, monkeypatch):
    set_by_hand = 'kind = "adjustment"\nstep = 2\nlow = 0\nhigh = 40'
    changes = {**SHORT, 'kind = "yes_no"\ncatch_rate = 0.0': set_by_hand}
    status, said, _ = run(capsys, monkeypatch, tmp_path, "--bench", tmp_path / "bench.toml", changes=changes)
    assert status == 2
    assert "--rig: found console, which plays no level during an adjustment, expected bench; or remove" in said
    assert not (tmp_path / "d").exists()


def console(tmp_path, force_n=None, text="", said=None, language="en"):
    sensor = None if force_n is None else force_sensor(force_n)
    device = Guarded(FileOutput(FileSettings(str(tmp_path))), LIMITS)
    equipment = Equipment(device, {"tone": TONE}, LIMITS, sensor)
    return Console(equipment, texts_in(language, {}), io.StringIO(text), said or io.StringIO())


def played(tmp_path):
    return len(list(tmp_path.glob("*.npz")))


def test_console_stimulus_waits_for_held_force(tmp_path):
    said = io.StringIO()
    rig = console(tmp_path, lambda time_s: 1.0 if time_s > 0.6 else 0.3, said=said)
    touched = rig.answer(PRESS)
    rig.close()
    assert touched.valid
    assert touched.onset_s >= 0.6
    assert (touched.force_mean_n, touched.level_delivered) == (pytest.approx(1.0), 5.0)
    assert played(tmp_path) == 1
    assert "played, 1.00 N" in said.getvalue()


def test_console_plays_nothing_when_force_is_unheld(tmp_path):
    rig = console(tmp_path, lambda time_s: 0.3)
    touched = rig.answer(replace(PRESS, timeout_s=0.5))
    rig.close()
    assert (touched.valid, touched.invalid_reason, touched.level_delivered) == (False, "timeout", None)
    assert played(tmp_path) == 0


def test_silent_sensor_pauses_session_in_its_language(tmp_path):
    def force_n(time_s):
        if time_s < 0.1:
            return 0.3
        return None if time_s < 0.7 else 1.0

    said = io.StringIO()
    rig = console(tmp_path, force_n, said=said, language="de")
    assert rig.answer(PRESS).valid
    rig.close()
    assert "mit 1 N drücken (zuerst den Finger heben)" in said.getvalue()
    assert "Heben Sie den" in said.getvalue()
    assert said.getvalue().endswith(": the force sensor is silent\nes geht weiter\nausgegeben, 1.00 N\n")


def test_play_request_lasts_its_duration(tmp_path):
    rig = console(tmp_path)
    begin_s = time.perf_counter()
    told = rig.answer(Play("tone", 5.0, 0.3))
    rig.close()
    assert time.perf_counter() - begin_s >= 0.3
    assert (told.level_delivered, played(tmp_path)) == (5.0, 1)


def test_console_refuses_adjustment_with_output(tmp_path):
    rig = console(tmp_path, text="5\n")
    with pytest.raises(Exception, match="console: found an adjustment task, which plays its level continuously"):
        rig.answer(Adjust("tone", 5.0, 1.0, 0.0, 10.0))
    rig.close()


def test_output_stays_closed_when_sensor_fails_to_open(tmp_path):
    class Absent(Sampled):
        def open(self):
            raise DeviceFailed("hand: not there")

    sensor = streamed_force(Reader(Absent(lambda time_s: 1.0)), 0, ForceCalibration(newtons_per_count=1.0))
    device = Guarded(FileOutput(FileSettings(str(tmp_path / "played"))), LIMITS)
    with pytest.raises(DeviceFailed, match="hand: not there"):
        Console(Equipment(device, {}, LIMITS, sensor), texts_in("en", {}), io.StringIO(), io.StringIO())
    assert not (tmp_path / "played").exists()


# --- stop keys


AT_A_TERMINAL = """
import fcntl, signal, sys, termios
from tactometry.cli import main
fcntl.ioctl(0, termios.TIOCSCTTY, 0)
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell ignores it in background jobs
main(sys.argv[1:])
"""


@pytest.mark.parametrize(
    ("language", "words"), [("en", "at any time with Ctrl-C."), ("fr", "tout moment avec Ctrl-C.")]
)
def test_console_pages_name_ctrl_c(language, words):
    said = io.StringIO()
    rig = Console(catalogue.silent({}, LIMITS), texts_in(language, {}), io.StringIO(), said)
    rig.answer(Show("welcome", {"n_blocks": 1}))
    assert words in said.getvalue()
    page = said.getvalue().split("\n\n", 1)[1]
    assert "Escape" not in page
    assert "chap" not in page


@pytest.mark.parametrize(
    ("key", "status"), [(b"\x03", 130), (b"\x04", 1), (b"\x1b\r", 1)], ids=["C-c", "C-d", "Escape"]
)
def test_terminal_session_stops_with_each_stop_key(tmp_path, key, status):
    master, slave = pty.openpty()
    words = ["run", "tutorial", "--participant", "P01", "--rig", "console", "--out", str(tmp_path / "d")]
    ends = {"stdin": slave, "stdout": slave, "stderr": slave}
    process = subprocess.Popen([sys.executable, "-c", AT_A_TERMINAL, *words], **ends, start_new_session=True)
    os.close(slave)
    seen, typed = b"", [b"1\r", b"0\r", key]
    end_s = time.monotonic() + 60
    while process.poll() is None and time.monotonic() < end_s:
        if select.select([master], [], [], 0.1)[0]:
            try:
                seen += os.read(master, 4096)
            except OSError:
                break
        if seen.rstrip().endswith(b"Press return to continue:"):
            os.write(master, b"\r")
            seen += b"|"
        elif typed and seen.rstrip().endswith(b"(0 = no, 1 = yes):"):
            os.write(master, typed.pop(0))
            seen += b"|"
    try:
        assert process.wait(30) == status, seen
    finally:
        process.kill()
        process.wait()
        os.close(master)
    assert b"recorded data are safe" in seen
    assert b"Traceback" not in seen
    assert len(trial_rows(tmp_path / "d")) == 2
    head = json.loads(next((tmp_path / "d" / "journals").glob("*.jsonl")).read_text().splitlines()[0])
    assert head["facts"]["terminal"] is True
