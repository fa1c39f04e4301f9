"""`tactometry check` with real devices in other processes."""

import importlib.util
import io
import json
import os
import socket
import subprocess
import sys
import threading
import time
import tomllib
from dataclasses import replace
from datetime import date

import numpy as np
import pytest
from benches import gain_table, gain_toml
from command_line import call
from emulated import Emulator, available
from patience import LONGEST_PROGRAM_S, LONGEST_WAIT_S
from study_texts import TUTORIAL

from tactometry.cli.check import _table
from tactometry.cli.output import hands_are_off
from tactometry.experiments.bench.bench_file import load_bench, parse_bench
from tactometry.experiments.bench.preflight import devices, tone_of
from tactometry.experiments.bench.preflight_checks import Finding, _try_keys, exit_status, key_to_record_s
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.study_file import load as load_numbers, parse
from tactometry.rigs.pages.page import Page
from tactometry.safety.limits import Limits

LIMITS = '[limits]\nvoltage_peak_v = 80.0\nduration_s = 10.0\ncurrent_peak_a = "1 mA"\nduty = 0.5\nsession_s = "1 h"\n'
LOAD = '[output.load]\nkind = "electrode"\ncapacitance_f = "1 nF"\n'
AUDIO = '[output]\nkind = "audio"\ndevice = "tofile"\nrate_hz = 48000\nsample_format = "int16"\n'
GAIN = gain_toml("audio tofile, int16")
SCREEN = "[screen]\nfullscreen = false\n"
SERIAL = '[sensors.hand]\nkind = "serial"\nrate_hz = 1000\nn_channels = 3\nport = "{port}"\n'
FORCE = '[force]\nsensor = "hand"\nchannel = 2\nnewtons_per_count = 0.01\n'


def test_check_tries_sensor_and_card_together(tmp_path, display, in_background, alsa):
    if importlib.util.find_spec("sounddevice") is None or not available("serial"):
        pytest.skip("no sounddevice or no pyserial: extras audio, serial")
    device, ended = Emulator("serial", tmp_path, profile="1:250"), threading.Event()

    def press_keys():
        while not ended.wait(0.05):
            display.tap("space")

    in_background(press_keys)
    try:
        limits = LIMITS.replace("80.0", "100.0")  # what the study asks for
        bench = SCREEN + AUDIO + GAIN + LOAD + limits + SERIAL.format(port=device.port) + FORCE
        env = {**alsa, "DISPLAY": os.environ["DISPLAY"]}
        (tmp_path / "tutorial.toml").write_text(TUTORIAL, "utf-8")
        (tmp_path / "bench.toml").write_text(bench, "utf-8")
        words = ("check", "tutorial.toml", "--bench", "bench.toml", "--json", "--hands-off")
        command, options = [sys.executable, "-m", "tactometry", *words], {"capture_output": True, "text": True}
        done = subprocess.run(command, cwd=tmp_path, env=env, timeout=LONGEST_PROGRAM_S, check=False, **options)
    finally:
        ended.set()
        device.close()
    assert done.returncode == 3, done.stderr
    findings = {(each["part"], each["what"]): each for each in json.loads(done.stdout)["findings"]}
    assert ("sensor hand", "failed") not in findings, findings
    expected = {"study": "tutorial.toml", "computer": "blas threads", "force": "noise, sd", "output": "underruns"}
    more = {("disk", "free"), ("disk", "time to write a record to disk"), ("sensor hand", "latency, median")}
    assert {*expected.items(), *more, ("sensor hand", "rate")} <= findings.keys()
    assert {("display", what) for what in ("frame period", "dropped frames", "key to record")} <= findings.keys()
    assert findings["display", "size"]["found"] == "1280 x 800 px"
    assert findings["display", "key to record"]["found"].endswith("of 3 keys")
    assert findings["sensor hand", "opened"]["fine"]
    assert findings["force", "mean, at rest"]["found"] == "2.5 N"
    assert findings["output", "test tone"]["found"] == "10 V, 0.5 s"
    played = np.frombuffer((tmp_path / "played.raw").read_bytes(), "<i2")
    assert np.abs(played).max() / 32767 * 100.0 == pytest.approx(10.0, abs=0.01)
    strongest = [each["found"] for (_, what), each in findings.items() if what.startswith("strongest")]
    assert len(strongest) == 2
    assert all(" of touch " in each or "level 40 of " in each for each in strongest)
    assert all("found a signal with rate_hz 20000, expected 48000; state this rate_hz in" in each for each in strongest)


def test_check_measures_a_real_key_press(watched, participant, hands, in_background):
    """Keys pressed before page onset are ignored; each record takes 50 ms."""

    def record():
        time.sleep(0.05)
        recorded_s.append(time.perf_counter())

    def press():
        onset_s = watched.shown.get(timeout=LONGEST_WAIT_S)
        pressed_s.extend(hands.tap("space")[0] for _ in range(2))
        assert all(pressed > onset_s for pressed in pressed_s)

    recorded_s, pressed_s = [], []
    hands.tap("space")
    in_background(press)
    delays_s = key_to_record_s(watched, Page(), record, n_keys=2, within_s=LONGEST_WAIT_S)
    assert len(delays_s) == len(recorded_s) == 2
    for delay_s, record_s, key_s in zip(delays_s, recorded_s, pressed_s, strict=True):
        assert 0.05 <= delay_s <= record_s - key_s + 2e-3


def test_check_continues_without_a_key_press(watched, monkeypatch, tmp_path):
    monkeypatch.setattr("tactometry.experiments.bench.preflight_checks.KEYS_WITHIN_S", 0.1)
    found = _try_keys(watched, "fr", tmp_path)
    assert (found.found, found.fine) == ("no key was pressed in 0.1 s", None)
    assert "sur la barre d'espace" in watched.pages[-1].items[1].words
    assert _try_keys(watched, "en", tmp_path / "none").fine is False


def test_check_plays_nothing_before_hands_are_off(tmp_path, alsa):
    bench = load(tmp_path, "[output]\nungated = true\n" + AUDIO[9:] + GAIN + LOAD + LIMITS)
    found = {each.what: each for each in devices(bench, Limits(80.0), None, hands_off=False)}
    assert (found["test tone"].found, found["test tone"].fine) == (
        "not played: the option --hands-off is missing",
        False,
    )
    assert found["caution"].found.startswith("bench file, output.ungated = true: nothing stops the output")
    assert "opened" not in found


@pytest.mark.parametrize(
    ("typed", "sure"), [("hands off", True), (" Hands Off ", True), ("yes", False), ("", False), (None, False)]
)
def test_hands_off_is_confirmed_at_a_terminal(monkeypatch, capsys, typed, sure):
    terminal = io.StringIO("" if typed is None else f"{typed}\n")
    terminal.isatty = lambda: typed is not None
    monkeypatch.setattr("sys.stdin", terminal)
    assert hands_are_off() is sure
    said = capsys.readouterr()
    assert ("Type 'hands off' when no hand is on the surface" in said.err) is (typed is not None)


def test_ungated_bench_is_not_fine(tmp_path):
    bench = load(tmp_path, AUDIO + GAIN + LOAD + LIMITS)
    failed = [each for each in devices(bench, Limits(80.0), None, hands_off=False) if each.fine is False]
    assert failed[0].found.startswith(
        "force: found none, expected a force sensor that stops the output when the finger"
    )
    assert exit_status(failed) == 1


PRACTISED = replace(parse(TUTORIAL.encode(), "tutorial"), practice={"levels": [40.0]})


@pytest.mark.parametrize(
    ("numbers", "limit_v", "n_stimuli", "found"),
    [
        (parse(TUTORIAL.encode(), "tutorial"), 10.0, 2, "limits.voltage_peak_v: found a peak of 95."),
        (PRACTISED, 60.0, 2, ""),
        (load_numbers("electrovibration-threshold")[0], 20.0, 7, ""),
    ],
    ids=["procedure", "practice", "shared by conditions"],
)
def test_each_stimulus_that_passes_a_limit_is_named(tmp_path, numbers, limit_v, n_stimuli, found):
    study = wire(numbers, "s.toml")
    bench = load(tmp_path, f'[output]\nkind = "file"\nfolder = "{tmp_path}"\n[limits]\nvoltage_peak_v = {limit_v}\n')
    findings = list(devices(bench, study.study.limits, study, hands_off=False))
    strongest = [each for each in findings if each.what.startswith("strongest")]
    assert [each.what for each in strongest] == [f"strongest {name}" for name in study.bank]
    assert len(strongest) == n_stimuli
    for each, name in zip(strongest, study.bank, strict=True):
        level = study.bounds(name)[1]
        assert each.found.startswith(f"level {level:g} of {name}: {found}")
        assert (each.fine, each.device) == (False, True)


@pytest.mark.parametrize("hands_off", [False, True])
def test_missing_limits_are_reported_once(tmp_path, hands_off):
    """The message appears once for all conditions, even if no study is given."""
    bench = load(tmp_path, AUDIO + GAIN + LOAD + LIMITS.replace("duration_s = 10.0", "").replace("session_s", "#"))
    for study in (None, wire(load_numbers("electrovibration-threshold")[0], "electrovibration-threshold")):
        messages = [each for each in devices(bench, bench.limits, study, hands_off=hands_off) if "limits" in each.found]
        assert [each.found.partition(",")[0] for each in messages] == ["limits: found no duration_s"]
        assert "no session_s, expected them for a load of kind 'electrode'" in messages[0].found
        assert exit_status(messages) == 3


def load(folder, text):
    (folder / "bench.toml").write_text(text, encoding="utf-8")
    return load_bench(folder / "bench.toml")


@pytest.mark.parametrize(
    ("bench", "part", "message"),
    [
        ("[output]\nungated = true\n" + AUDIO[9:] + GAIN + LIMITS, "output", "output 'audio tofile': found no load"),
        (SERIAL.format(port="no/line"), "sensor hand", "serial no/line: cannot open the line"),
    ],
)
def test_failed_device_is_status_3_and_plays_nothing(tmp_path, bench, part, message):
    findings = list(devices(load(tmp_path, bench), Limits(80.0), None, hands_off=True))
    [failed] = [each for each in findings if each.fine is False]
    assert failed.part == part
    assert failed.found.startswith(message)
    assert exit_status(findings) == 3


def test_silent_sensor_is_reported(monkeypatch):
    monkeypatch.setattr("tactometry.experiments.bench.preflight.LISTEN_S", 0.1)
    monkeypatch.setattr("tactometry.experiments.bench.preflight_checks.FIRST_WITHIN_S", 0.05)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as silent:
        silent.bind(("127.0.0.1", 0))
        port = silent.getsockname()[1]
        sensor = {"kind": "udp", "address": "127.0.0.1", "port": port, "rate_hz": 1000}
        bench = parse_bench({"sensors": {"hand": sensor}, **tomllib.loads(FORCE)})
        failed = [each for each in devices(bench, None, None, hands_off=False) if each.fine is False]
    said = [(each.part, each.what, each.found, each.expected) for each in failed]
    assert said == [
        ("sensor hand", "samples", "0 in 0.1 s", "a sensor that sends"),
        ("force", "samples", "0 in 0.05 s", "a sensor that sends"),
    ]
    assert exit_status(failed) == 3


POSITION = '[position]\nsensor = "hand"\nchannels = [0, 1]\nmetres_per_count = {metres}\n'
GATED = {"touch": {"speed_tolerance": 0.2}}


def slid(monkeypatch, tmp_path, metres_per_count, change):
    """Return findings for a position that changes by a count each ms.

    The tutorial's slides move at 50 mm/s.
    """
    monkeypatch.setattr("tactometry.experiments.bench.preflight.LISTEN_S", 0.5)
    monkeypatch.setattr("tactometry.experiments.bench.preflight_checks.HEARD_S", 0.3)
    monkeypatch.setattr("tactometry.experiments.bench.preflight_checks.FIRST_WITHIN_S", LONGEST_WAIT_S)
    numbers = parse(TUTORIAL.encode(), "tutorial")
    study = wire(replace(numbers, touch={**numbers.touch, **change.get("touch", {})}), "tutorial")
    device = Emulator("serial", tmp_path)
    try:
        bench = parse_bench(tomllib.loads(SERIAL.format(port=device.port) + POSITION.format(metres=metres_per_count)))
        said = list(devices(bench, Limits(100.0), study, hands_off=False))
    finally:
        device.close()
    return {each.what: each for each in said if each.part == "position"}


@pytest.mark.skipif(not available("serial"), reason="no pyserial: extra serial")
@pytest.mark.parametrize(
    ("metres_per_count", "change", "fine"), [(2e-6, GATED, True), (4e-5, GATED, False), (4e-5, {}, None)]
)
def test_check_reports_position_and_speed_of_the_gate(monkeypatch, tmp_path, metres_per_count, change, fine):
    """A finger at rest moves at 2 or 40 mm/s with a tolerance of 10 mm/s."""
    said = slid(monkeypatch, tmp_path, metres_per_count, change)
    assert "speed, at rest" in said, said
    assert said["samples with a position"].fine
    speed = said["speed, at rest"]
    found_m_per_s = 1e-3 * float(speed.found.split()[0])
    assert found_m_per_s == pytest.approx(1e3 * metres_per_count, rel=0.15)
    assert (speed.fine, speed.expected) == (fine, "at most 10 mm/s, the speed tolerance of a slide" if change else "")


def test_check_reports_slide_without_position(tmp_path):
    study = wire(parse(TUTORIAL.encode(), "tutorial"), "tutorial")
    bench = load(tmp_path, f'[output]\nkind = "file"\nfolder = "{tmp_path}"\n')
    said = [each for each in devices(bench, study.study.limits, study, hands_off=False) if each.part == "position"]
    assert [(each.found, each.fine) for each in said] == [("not measured: the bench file has no [position]", None)]


def test_long_message_is_printed_below_narrow_table():
    words = "serial no/line: cannot open the line (No such file or directory), expected a readable device"
    text = _table([Finding("disk", "free", "1 GB", fine=True), Finding("sensor hand", "failed", words, fine=False)])
    assert text.splitlines()[-2:] == [f"sensor hand: {words}", "1 failed"]
    assert "see below" in text


def test_unrunnable_study_is_status_1_with_working_devices():
    assert exit_status([Finding("study", "x", "", fine=False), Finding("disk", "free", "", fine=True)]) == 1
    assert exit_status([Finding("a", "b", "c")]) == 0


@pytest.mark.parametrize(
    "output", [{"kind": "file", "folder": "x"}, {"kind": "packed", "path": "x", "n_channels": 32, "rate_hz": 1e6}]
)
def test_test_tone_is_within_limits(output):
    gain = gain_table("packed x", 30.0, 1.0)
    bench = parse_bench({"output": {**output, "gain": gain}, "limits": {"voltage_peak_v": 80.0}})
    tone = tone_of(bench.devices(Limits(50.0), date.today(), touched=False).output)
    assert tone.peak <= 50.0
    if output["kind"] == "file":
        assert tone.peak == pytest.approx(5.0, rel=1e-3)
        assert np.abs(tone.samples[:, [0, -1]]).max() < 1e-3
    else:
        assert np.all(np.abs(tone.samples) == 30.0)


@pytest.mark.parametrize("is_stated", [False, True])
def test_check_finds_overload_counts_of_positions(tmp_path, monkeypatch, capsys, is_stated):
    monkeypatch.chdir(tmp_path)
    rows = [f"{n / 1000},{(120, 255, 121, 122)[n % 4]}" for n in range(4000)]
    (tmp_path / "place.csv").write_text("\n".join(["time_s,counts", *rows, ""]))
    stated = "count_high = 254\n" if is_stated else ""
    (tmp_path / "bench.toml").write_text(
        '[output]\nkind = "null"\n[sensors.hand]\nkind = "recorded"\npath = "place.csv"\nrate_hz = 1000.0\n'
        f'[position]\nsensor = "hand"\nchannels = [0]\nmetres_per_count = 0.001\n{stated}'
    )
    status, _, said = call(capsys, "check", "--bench", "bench.toml", "--json")
    found = {each["what"]: each for each in json.loads(said)["findings"] if each["part"] == "position"}
    assert status == 3
    assert ("counts at full scale" in found) is not is_stated
    assert found["samples with a position"]["fine"] is not is_stated
