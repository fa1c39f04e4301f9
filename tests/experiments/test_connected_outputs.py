"""Outputs with an amplifier: measured gain, its date, and the finger gate."""

import json
from datetime import date

import pytest
from benches import gain_table
from command_line import call

from tactometry.errors import DeviceFailed, InvalidParameter
from tactometry.experiments.bench.bench_file import device_facts, parse_bench
from tactometry.safety.limits import Limits

STUDY = Limits(200.0)
TODAY = date(2026, 11, 21)
OUTPUTS = {
    "audio": {"kind": "audio", "device": "Interface", "rate_hz": 192e3},
    "packed": {"kind": "packed", "path": "board", "n_channels": 32, "rate_hz": 1e6},
    "ni": {"kind": "ni", "channels": ["Dev1/ao0"], "rate_hz": 1e5},
}
CHAINS = {"audio": "audio Interface, int32", "packed": "packed board", "ni": "ni Dev1/ao0, 10 V"}
FORCE = {
    "sensors": {"hand": {"kind": "lsl", "stream": "force", "rate_hz": 1e3}},
    "force": {"sensor": "hand", "newtons_per_count": 0.01},
}


def bench_of(kind, gain=None, output=None, **more):
    table = {**OUTPUTS[kind], **({} if gain is None else {"gain": gain}), **(output or {})}
    return parse_bench({"output": table, **(more or FORCE)})


per_kind = pytest.mark.parametrize("kind", OUTPUTS)


@per_kind
def test_amplified_output_needs_a_gain(tmp_path, capsys, kind):
    with pytest.raises(
        InvalidParameter, match=r"^output\.gain: found none, expected .*tactometry calibrate gain; nothing"
    ):
        bench_of(kind)
    for name in ("volts_per_unit", "amplifier_gain"):
        gain = {key: value for key, value in gain_table(CHAINS[kind]).items() if key != name}
        with pytest.raises(InvalidParameter, match=rf"^output\.gain\.{name}: found no such key, expected a number"):
            bench_of(kind, gain)
    with pytest.raises(InvalidParameter, match=r"^output\.gain: found none"):
        bench_of(kind, gain_table(CHAINS[kind])).output.settings.driver(None)
    rows = "".join(f"{key} = {json.dumps(value)}\n" for key, value in OUTPUTS[kind].items())
    (tmp_path / "bench.toml").write_text(f"[output]\n{rows}", encoding="utf-8")
    to = ["--bench", tmp_path / "bench.toml", "--out", tmp_path / "d"]
    status, said, _ = call(capsys, "run", "tutorial", "--participant", "P01", *to)
    assert (status, "output.gain: found none" in said, said.count("\n")) == (2, True, 0)


@per_kind
@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"measured_on": None}, r"\.measured_on: found none, expected the date of its measurement"),
        ({"measured_by": None}, r"\.measured_by: found none, expected the author"),
        ({"measured_by": ""}, r"\.measured_by: found none, expected the author"),
        ({"measured_with": None}, r"\.measured_with: found none, expected the output"),
        ({"measured_with": "audio Interface, int16"}, r"\.measured_with: found 'audio Interface, int16', expected '"),
        ({"system_volume": 0.5}, r"\.system_volume: found a measurement at a volume of 50 %, expected"),
        ({"measured_on": date(2025, 11, 20)}, ": found a calibration of 2025-11-20, 366 days old, expected at most"),
    ],
)
def test_gain_needs_date_author_and_output(kind, change, message):
    whole = {**gain_table(CHAINS[kind]), "measured_on": TODAY, **change}
    gain = {key: value for key, value in whole.items() if value is not None}
    with pytest.raises(DeviceFailed, match=rf"^output\.gain{message}.*nothing was played"):
        bench_of(kind, gain).devices(STUDY, TODAY)


@per_kind
def test_gain_is_valid_on_last_day(kind):
    gain = {**gain_table(CHAINS[kind]), "measured_on": date(2025, 11, 21)}
    assert bench_of(kind, gain).devices(STUDY, TODAY).output.driver.full_scale_v == 100.0


def test_file_output_needs_no_gain():
    for table in ({"kind": "file", "folder": "x"}, {"kind": "null"}, {}):
        assert parse_bench({"output": table}).devices(STUDY, TODAY).output.driver.connected is False


@pytest.mark.parametrize("device", ["", " ", "default", "Default", "sysdefault"])
def test_sound_card_needs_a_name(device):
    card = {**OUTPUTS["audio"], "device": device}
    for tables in ({"output": card}, {"sensors": {"s": card}}):
        with pytest.raises(InvalidParameter, match=r"\.device: found .*, expected the name of a card"):
            parse_bench(tables)


RECORDED = {"hand": {"kind": "recorded", "path": "old.csv", "rate_hz": 1e3}}


@per_kind
@pytest.mark.parametrize(
    ("output", "tables", "message"),
    [
        ({}, {"screen": {}}, r"^force: found none, expected a force sensor .*ungated = true in .output"),
        ({}, {"sensors": RECORDED, "force": FORCE["force"]}, r"^force\.sensor: found 'hand', a recording, which"),
        ({"ungated": True}, FORCE, r"^output\.ungated: found true together with .force., expected only one of them"),
    ],
)
def test_touched_output_is_gated_by_a_finger_sensor(kind, output, tables, message):
    bench = bench_of(kind, {**gain_table(CHAINS[kind]), "measured_on": TODAY}, output, **tables)
    with pytest.raises(InvalidParameter, match=message):
        bench.devices(STUDY, TODAY)
    assert (bench.devices(STUDY, TODAY, touched=False).force is None) is ("force" not in tables)


@per_kind
def test_ungated_output_is_reported(kind):
    ungated = bench_of(kind, {**gain_table(CHAINS[kind]), "measured_on": TODAY}, {"ungated": True}, screen={})
    devices = ungated.devices(STUDY, TODAY)
    assert ungated.cautions == ("bench file, output.ungated = true: nothing stops the output when the finger leaves",)
    assert device_facts(ungated, devices)["output_ungated"] is True


def test_recording_may_gate_unconnected_output():
    bench = parse_bench({"sensors": RECORDED, "force": FORCE["force"]})
    assert bench.devices(STUDY, TODAY).force.name == "recorded old.csv"
