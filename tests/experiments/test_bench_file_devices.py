"""Devices of bench files: strict reading, lazy imports, calibration age."""

import math
import subprocess
import sys
from datetime import date

import msgspec
import numpy as np
import pytest
from benches import gain_toml
from command_line import call

from tactometry.devices.outputs.audio import AudioSettings
from tactometry.devices.outputs.gain import Gain
from tactometry.devices.outputs.output import RAMP_S
from tactometry.devices.sensors.lsl import LslSettings
from tactometry.devices.sensors.streamed import ForceCalibration
from tactometry.errors import DeviceFailed, InvalidFile, InvalidParameter, LimitExceeded
from tactometry.experiments.bench.bench_file import BenchFile, device_facts, load_bench, parse_bench
from tactometry.experiments.bench.bench_parts import Learnt, SensorPart
from tactometry.safety.limits import Limits
from tactometry.safety.load import Load
from tactometry.signal import Signal

STUDY = Limits(200.0)
TODAY = date(2026, 11, 21)
WHOLE = """
[screen]
height_m = "29.8 cm"

[output]
kind = "audio"
rate_hz = "192 kHz"
channels = [0, 1]
device = "interface"

[output.gain]
volts_per_unit = 2.0
amplifier_gain = 50.0
measured_on = 2026-11-01
measured_by = "ZG"
measured_with = "audio interface, int32"
max_age_days = 90

[output.load]
kind = "electrode"
capacitance_f = "1 nF"
leak_resistance_ohm = "10 Mohm"

[limits]
voltage_peak_v = 100.0
current_peak_a = "1 mA"
duty = 0.5
session_s = "1 h"

[sensors.hand]
kind = "lsl"
stream = "force"
rate_hz = "1 kHz"
n_channels = 3
source_id = "F7"
delay_s = "5 ms"

[force]
sensor = "hand"
channel = 2
polynomial = [-0.5, 0.01]
measured_on = 2026-10-01
measured_by = "ZG"
max_age_days = 60

[position]
sensor = "hand"
channels = [0, 1]
metres_per_count = 1e-6
zero_counts = [100, 0]

[time_reversal]
responses = "learnt.npz"
"""


def read(tmp_path, text):
    path = tmp_path / "bench.toml"
    path.write_text(text, encoding="utf-8")
    return load_bench(path)


def test_bench_file_is_read_with_units(tmp_path):
    bench = read(tmp_path, WHOLE)
    assert bench.screen.height_m == pytest.approx(0.298)
    assert bench.output.settings == AudioSettings(192e3, "interface", (0, 1))
    assert bench.output.gain == Gain(2.0, 50.0, date(2026, 11, 1), "ZG", 90, "audio interface, int32")
    assert bench.output.load == Load("electrode", 1e-9, 1e7)
    assert bench.limits == Limits(100.0, current_peak_a=1e-3, duty=0.5, session_s=3600.0)
    assert bench.sensors == {"hand": SensorPart(LslSettings("force", 1000.0, 3, "F7"), delay_s=5e-3)}
    assert bench.force.calibration == ForceCalibration(
        polynomial=(-0.5, 0.01), measured_on=date(2026, 10, 1), measured_by="ZG", max_age_days=60
    )
    assert (bench.position.channels, bench.position.zero_counts) == ((0, 1), (100.0, 0.0))
    assert bench.time_reversal == Learnt("learnt.npz")


def test_bench_devices_are_guarded_and_share_reader(tmp_path):
    devices = read(tmp_path, WHOLE).devices(STUDY, TODAY)
    assert devices.output.limits == Limits(100.0, current_peak_a=1e-3, duty=0.5, session_s=3600.0)
    assert devices.output.load.capacitance_f == 1e-9
    assert (devices.output.driver.n_channels, devices.output.driver.rate_hz) == (2, 192e3)
    assert devices.force.name == devices.position.name == "lsl force"
    assert list(devices.readers) == ["hand"]


def test_head_facts_survive_a_round_trip(tmp_path):
    """Facts are finite numbers, because JSON cannot represent infinity."""
    bench = read(tmp_path, WHOLE)
    facts = device_facts(bench, bench.devices(STUDY, TODAY))
    assert msgspec.json.decode(msgspec.json.encode(facts)) == facts
    assert not any(isinstance(value, float) and not math.isfinite(value) for value in facts.values())


def test_bench_is_null_without_a_file():
    devices = load_bench(None).devices(STUDY, TODAY)
    assert devices.output.name == "null"
    devices.output.play(Signal(np.full((1, 3), 199.0), 1e3, "V"))
    with pytest.raises(LimitExceeded, match="voltage_peak_v"):
        devices.output.play(Signal(np.full((1, 3), 201.0), 1e3, "V"))
    assert devices.force is None


def test_connected_output_needs_bench_limits(tmp_path):
    limits = WHOLE[WHOLE.index("[limits]") : WHOLE.index("[sensors")]
    output = read(tmp_path, WHOLE.replace(limits, "")).devices(STUDY, TODAY).output
    with pytest.raises(LimitExceeded, match="found no limits.*state them in the bench.*nothing was played"):
        output.open()


@pytest.mark.parametrize(
    ("today", "message"),
    [
        (date(2027, 3, 1), "output.gain: found a calibration of 2026-11-01, 120 days old, expected at most 90"),
        (date(2026, 12, 20), "force: found a calibration of 2026-10-01, 80 days old, expected at most 60"),
    ],
)
def test_an_old_calibration_is_a_failed_device(tmp_path, today, message):
    with pytest.raises(DeviceFailed, match=f"^{message}.*nothing was played") as refused:
        read(tmp_path, WHOLE).devices(STUDY, today)
    assert refused.value.exit_status == 3


def test_packed_streams_have_no_ramps(tmp_path):
    board = '[output]\nkind = "packed"\npath = "board"\nn_channels = 32\nrate_hz = 1e6\n' + gain_toml("packed board")
    assert read(tmp_path, board).output.ramp_s == 0.0
    assert BenchFile().output.ramp_s == RAMP_S
    assert read(tmp_path, '[output]\nramp_s = "1 ms"\n').output.ramp_s == 1e-3


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (('kind = "audio"', 'kind = "adio"'), "output.kind: found 'adio', expected one of null, file, .*mean 'audio'"),
        (('kind = "lsl"', "kind = 1"), "sensors.hand.kind: found 1, expected one of lsl, serial, udp, audio, touch, "),
        (('kind = "lsl"\n', ""), "sensors.hand.kind: found no such key, expected one of lsl"),
        (('stream = "force"\n', ""), "sensors.hand.stream: found no such key, expected a text"),
        (('"5 ms"', '"60 ms"'), "sensors.hand.delay_s: found 0.06, expected a number from 0 to 0.05"),
        (('"5 ms"', "-1"), r"sensors.hand.delay_s: found -1\.0, expected a number from 0 to 0.05"),
        (("n_channels = 3", "n_chanels = 3"), "sensors.hand.n_chanels: found an unknown key.*mean 'n_channels'"),
        (("age_days = 90", "age_days = -3"), "output.gain.max_age_days: found -3, expected a whole number, at least 0"),
        (("age_days = 60", "age_days = -3"), "force.max_age_days: found -3, expected a whole number, at least 0"),
        (("[limits]", "[limit]"), "limit: found an unknown key, expected one of screen, .*mean 'limits'"),
        (('"1 mA"', '"1 mV"'), "limits.current_peak_a: found '1 mV', expected a number in A"),
        (('"1 nF"', '"1 nf"'), "output.load.capacitance_f: found '1 nf', expected a number in F"),
        (("duty = 0.5", "duty = 2"), "limits.duty: found 2.0, expected at most 1"),
        (('kind = "electrode"', 'kind = "finger"'), "output.load.kind: found 'finger', expected one of electrode"),
        (("amplifier_gain = 50.0", "amplifier_gain = 0"), "output.gain.amplifier_gain: found 0.0, expected"),
        (('sensor = "hand"\nchannel = 2', 'sensor = "hnad"'), "force.sensor: found 'hnad', expected one of .*'hand'"),
        (("polynomial = [-0.5, 0.01]\n", ""), "force: found none, or more than one, of newtons_per_count"),
        (("measured_on = 2026-11-01", 'measured_on = "soon"'), "output.gain.measured_on: .*'soon', expected a date"),
        (("[position]", "[screen.x]"), "screen.x: found an unknown key"),
        (("[screen]", '[screen]\nlanguage = "it"'), "screen.language: found 'it', expected one of de, en, fr"),
        (("[screen]", "sensors.x = 1\n[screen]"), "sensors.x: found 1, expected a table"),
        (("zero_counts = [100, 0]", "zero_counts = [1]"), "position.zero_counts: found 1, expected one for each"),
        (("metres_per_count = 1e-6", "metres_per_count = 0"), "position.metres_per_count: found 0.0, expected"),
        (("channels = [0, 1]\nmetres", "channels = []\nmetres"), "position.channels: found none, expected at least"),
    ],
)
def test_anything_else_is_refused_in_one_sentence(tmp_path, change, message):
    assert change[0] in WHOLE
    with pytest.raises(InvalidFile, match=f"bench.toml[,:] {message}"):
        read(tmp_path, WHOLE.replace(*change))


AUDIO = {"kind": "audio", "device": "x", "rate_hz": 48e3}
NI = {"kind": "ni", "rate_hz": 48e3, "channels": ["Dev1/ao0"]}
PACKED = {"kind": "packed", "path": "x", "rate_hz": 48e3, "n_channels": 1}
UDP = {"kind": "udp", "address": "127.0.0.1", "rate_hz": 1e3}
SERIAL = {"kind": "serial", "port": "x", "rate_hz": 1e3}


@pytest.mark.parametrize(
    ("part", "table", "values"),
    [
        ("output", AUDIO, {"rate_hz": [0], "block_s": [0], "latency_s": [-1], "channels": [[], [0, 0], [0, -1]]}),
        ("output", NI, {"range_v": [0], "rate_hz": [-1], "channels": [[], ["Dev1/ao0", "Dev1/ao0"]]}),
        ("output", PACKED, {"n_channels": [0], "rate_hz": [0]}),
        ("sensors.s", AUDIO, {"n_channels": [0], "block_s": [0], "latency_s": [-1]}),
        ("sensors.s", {"kind": "lsl", "stream": "x", "rate_hz": 1e3}, {"n_channels": [-3], "rate_hz": [0]}),
        ("sensors.s", SERIAL, {"baud": [0], "n_channels": [0]}),
        ("sensors.s", UDP, {"sensor_rate_hz": [0], "port": [70_000]}),
        ("sensors.s", {"kind": "touch", "path": "x"}, {"rate_hz": [0]}),
        ("sensors.s", {"kind": "recorded", "path": "x", "rate_hz": 1e3}, {"n_channels": [0]}),
    ],
)
def test_impossible_number_is_refused_with_the_file(part, table, values):
    for name, value in ((name, value) for name, each in values.items() for value in each):
        changed = {**table, name: value}
        with pytest.raises(InvalidParameter, match=rf"^{part}\.{name}: found .*, expected "):
            parse_bench({"sensors": {"s": changed}} if part == "sensors.s" else {part: changed})


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("channel = 2", "channel = 3"), "force.channel: found 3, expected a channel of lsl force, from 0 to 2"),
        (("channels = [0, 1]\nmetres", "channels = [0, -1]\nmetres"), "position.channels: found -1, expected a"),
    ],
)
def test_unknown_sensor_channel_is_refused(tmp_path, change, message):
    assert change[0] in WHOLE
    with pytest.raises(InvalidParameter, match=message):
        read(tmp_path, WHOLE.replace(*change)).devices(STUDY, TODAY)


def test_reading_a_bench_file_loads_no_device_library(tmp_path):
    (tmp_path / "bench.toml").write_text(WHOLE, encoding="utf-8")
    script = (
        "import sys, datetime, pathlib; from tactometry.experiments.bench.bench_file import load_bench\n"
        "from tactometry.safety.limits import Limits\n"
        "load_bench(pathlib.Path('bench.toml')).devices(Limits(1.0), datetime.date(2026, 11, 21))\n"
        "print({'sounddevice', 'pylsl', 'serial', 'nidaqmx'} & set(sys.modules))\n"
        "print([name for name in sys.modules if name.startswith('tactometry.devices.') and 'ni' in name.split('.')])"
    )
    result = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert result.stdout.split("\n")[:2] == ["set()", "[]"]


@pytest.mark.parametrize(
    ("settings", "wanted"),
    [
        ("rate_hz = 44100\nchannels = [0]", "rate_hz 20000, expected 44100"),
        ("rate_hz = 20000\nchannels = [0, 1]", "n_channels 1, expected 2"),
    ],
)
def test_unplayable_study_opens_no_window(tmp_path, capsys, settings, wanted):
    calibrated = gain_toml("audio x, int32") + WHOLE[WHOLE.index("[output.load]") : WHOLE.index("[sensors.hand]")]
    bench = tmp_path / "bench.toml"
    bench.write_text(f'[output]\nkind = "audio"\ndevice = "x"\nungated = true\n{settings}\n{calibrated}')
    status, said, _ = call(capsys, "run", "tutorial", "--participant", "P01", "--bench", bench, "--out", tmp_path / "d")
    assert (status, wanted in said, "nothing was played" in said) == (3, True, True), said
