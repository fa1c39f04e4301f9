"""Sensors emulated in separate processes: losses and outages."""

import os
import re
import time
from functools import partial
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from emulated import LIBRARIES, Emulator, available, wait_for
from patience import LONGEST_WAIT_S
from soak import SOAK
from window_sitting import python

from tactometry.devices.sensors.counted_samples import STEP_S
from tactometry.devices.sensors.lsl import LslSettings
from tactometry.devices.sensors.reader import LATE_S, Listener, Reader, SampleBlock
from tactometry.devices.sensors.recorded import RecordedSettings
from tactometry.devices.sensors.serial_line import SerialSettings
from tactometry.devices.sensors.streamed import ForceCalibration, streamed_force, streamed_position
from tactometry.devices.sensors.udp import UdpSettings
from tactometry.errors import DeviceFailed

N_LISTENED = 600_000 if SOAK else 3000
KINDS = ("serial", "udp", "lsl")


def collected(sensor, until):
    times_s, values = [], []
    end_s = time.monotonic() + 120
    while not until(times_s):
        assert time.monotonic() < end_s, "the sensor is silent"
        block = sensor.read()
        times_s += block[0].tolist()
        values += block[1].tolist()
        time.sleep(0.005)
    return np.array(times_s), np.array(values)


def joined(blocks):
    return SampleBlock(np.concatenate([b.times_s for b in blocks]), np.concatenate([b.values for b in blocks]))


@pytest.fixture(scope="module")
def heard(tmp_path_factory):
    """Return (block, facts) of emulators of all kinds at once; each sample has its arrival time as its last value."""
    devices = {kind: Emulator(kind, tmp_path_factory.mktemp(kind)) for kind in KINDS if available(kind)}
    blocks = {kind: [] for kind in devices}

    def note(kind, block):
        if block.times_s.size:
            arrivals_s = np.full(len(block.values), time.perf_counter())
            blocks[kind].append(SampleBlock(block.times_s, np.column_stack([block.values, arrivals_s])))

    for kind, device in devices.items():
        device.reader.subscribe(partial(note, kind))
    for device in devices.values():
        device.reader.open()
    try:
        for each in blocks.values():
            wait_for(lambda each=each: each and each[-1].values[-1, 0] >= N_LISTENED, LONGEST_WAIT_S + N_LISTENED / 500)
        return {kind: (joined(list(blocks[kind])), device.reader.facts()) for kind, device in devices.items()}
    finally:
        for device in devices.values():
            device.close()


@pytest.fixture
def plugged(request, tmp_path):
    emulators = []

    def plug(kind, **more):
        if not available(kind):
            pytest.skip(f"no {LIBRARIES[kind]}: extra {kind}")
        emulators.append(Emulator(kind, **{"folder": tmp_path, **more}))
        return emulators[-1]

    yield plug
    for each in emulators:
        each.close()


@pytest.mark.parametrize("kind", KINDS)
def test_unplugged_sensor_is_silent_and_resumes(plugged, kind):
    device = plugged(kind, profile="1:250")
    force = streamed_force(device.reader, 2, ForceCalibration(newtons_per_count=0.01))
    force.open()
    _, forces_n = collected(force, lambda times: len(times) > 200)
    assert np.allclose(forces_n, 2.5)
    device.unplug()
    unplugged_s = time.perf_counter()
    time.sleep(0.5)
    late_s, _ = force.read()
    assert np.all(late_s <= unplugged_s + 0.01)
    assert force.read()[0].size == 0
    device.plug()
    again_s, forces_n = collected(force, lambda times: len(times) > 200)
    assert again_s[0] > unplugged_s + 0.5
    assert np.allclose(forces_n, 2.5)
    if kind != "udp":
        assert device.reader.facts()["n_outages"] >= 1
    force.close()
    force.close()


def test_force_and_position_share_a_stream(plugged):
    device = plugged("serial")
    force = streamed_force(device.reader, 2, ForceCalibration(newtons_per_count=0.01))
    position = streamed_position(device.reader, (0, 0), 1e-3)
    force.open()
    position.open()
    _, positions_m = collected(position, lambda times: len(times) > 100)
    assert np.allclose(np.diff(positions_m, axis=0), 1e-3)
    force.close()
    position.read()
    collected(position, lambda times: len(times) > 100)
    position.close()
    assert device.reader._thread is None


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (
            SerialSettings("no/line", 1000.0),
            r"serial no/line: cannot open the line \(No such file.*\), expected a readable dev",
        ),
        (UdpSettings("no.such.host.invalid", 1000.0), "the sensor cannot be reached .*expected its address"),
        (RecordedSettings("no/such/file.csv", 1000.0), "cannot be read as a recording"),
    ],
)
def test_missing_sensor_is_named(settings, message):
    with pytest.raises(DeviceFailed, match=message):
        Reader(settings.source()).open()


SEARCH = """
from tactometry.devices.sensors import lsl
from tactometry.errors import DeviceFailed
lsl.LONGEST_SEARCH_S = 0.1
try:
    lsl.LslSettings("none", 1000.0).source().open()
except DeviceFailed as error:
    print(error)
"""


@pytest.mark.skipif(not available("lsl"), reason="no pylsl: extra lsl")
@pytest.mark.parametrize("settings", ["", "[log]\nlevel = 0\n"], ids=["without settings", "with the user's own"])
def test_lsl_library_is_silent_unless_configured(tmp_path, settings):
    if settings:
        (tmp_path / "lsl_api.cfg").write_text(settings, encoding="utf-8")
    env = {**os.environ, "HOME": str(tmp_path)}
    said = python("-c", SEARCH, cwd=tmp_path, env=env, check=True)
    assert said.stdout == "lsl none: found no such stream in 0.1 s, expected a running outlet\n"
    assert ("INFO" in said.stderr) is bool(settings)
    assert settings or said.stderr == ""


@pytest.mark.skipif(not available("lsl"), reason="no pylsl: extra lsl")
def test_stream_that_differs_from_bench_file_is_refused(plugged, monkeypatch):
    monkeypatch.setattr("tactometry.devices.sensors.lsl.LONGEST_SEARCH_S", 2.0)
    with pytest.raises(DeviceFailed, match="found no such stream in 2 s, expected a running outlet"):
        LslSettings("nobody sends this", 1000.0).source().open()
    device = plugged("lsl")
    with pytest.raises(DeviceFailed, match="with n_channels 3, expected 1; correct the bench file"):
        LslSettings(device.name, 1000.0, 1).source().open()
    with pytest.raises(DeviceFailed, match="with rate_hz 1000, expected 500"):
        LslSettings(device.name, 500.0, 3).source().open()


@pytest.mark.skipif(not available("lsl"), reason="no pylsl: extra lsl")
def test_ambiguous_outlet_needs_a_source_id(plugged, monkeypatch):
    monkeypatch.setattr("tactometry.devices.sensors.lsl.LONGEST_SEARCH_S", 5.0)
    one = plugged("lsl", options=("--source-id", "left"))
    other = plugged("lsl", options=("--source-id", "right"), name=one.name, profile="1:700")
    both = "found outlets of this name with the source ids 'left', 'right', expected one"
    with pytest.raises(DeviceFailed, match=f"{both}; state source_id in the bench file"):
        one.reader.open()
    with pytest.raises(DeviceFailed, match=f"{both} with 'middle'"):
        LslSettings(one.name, 1000.0, 3, "middle").source().open()
    reader = Reader(LslSettings(one.name, 1000.0, 3, "right").source())
    force = streamed_force(reader, 2, ForceCalibration(newtons_per_count=0.01))
    force.open()
    _, forces_n = collected(force, lambda times: len(times) > 100)
    assert np.allclose(forces_n, 7.0)
    assert reader.facts()["source_id"] == "right"
    force.close()
    other.unplug()
    other.plug()


@pytest.mark.skipif(not available("lsl"), reason="no pylsl: extra lsl")
def test_replacement_outlet_with_another_source_is_refused(plugged):
    device = plugged("lsl", options=("--source-id", "left"))
    force = streamed_force(device.reader, 2, ForceCalibration(newtons_per_count=0.01))
    force.open()
    collected(force, lambda times: len(times) > 100)
    device.unplug()
    device.options = ("--source-id", "another")
    device.plug()
    wait_for(lambda: "expected one with 'left'" in str(device.reader.facts()["failure"]))
    device.unplug()
    device.options = ("--source-id", "left")
    device.plug()
    collected(force, lambda times: len(times) > 100)
    force.close()


CLOCKS = ("1.3", "10", "0.7", "0")
"""Rates of clocks that run fast, slow, and not at all."""
ONE_EACH = (("serial", "1.3"), ("lsl", "10"), ("udp", "0.7"), ("serial", "0"))
"""Every clock and every kind; `make check` takes each of the twelve."""
FAST, LATE = "found a stamp .* s after its arrival", "found samples that are .* s old on arrival, expected at most"
RATE = "found a clock that runs .* times as fast as this computer's, expected within 2%"


@pytest.mark.parametrize(
    "chosen", [ONE_EACH, pytest.param(tuple(product(KINDS, CLOCKS)), marks=pytest.mark.slow)], ids=["one each", "all"]
)
def test_sensor_with_wrong_clock_rate_fails_with_reason(plugged, tmp_path, chosen):
    devices = []
    for kind, rate in ((kind, rate) for kind, rate in chosen if available(kind)):
        folder = tmp_path / kind / rate
        folder.mkdir(parents=True)
        devices.append(plugged(kind, options=("--clock", rate), folder=folder))
        devices[-1].reader.open()

    def all_are_found_out():
        for device in devices[:]:
            if re.match(f"^{device.kind} .*: ({'|'.join((FAST, LATE, RATE))})", str(device.reader.facts()["failure"])):
                assert device.reader.facts()["n_outages"] > 0
                device.close()
                devices.remove(device)
        return not devices

    wait_for(all_are_found_out)


@pytest.mark.skipif(not available("lsl"), reason="no pylsl: extra lsl")
@pytest.mark.parametrize(("ahead_s", "why"), [("5", FAST), ("-5", LATE)])
def test_outlet_with_shifted_stamps_fails_with_reason(plugged, ahead_s, why):
    device = plugged("lsl", options=("--ahead", ahead_s))
    device.reader.open()
    wait_for(lambda: device.reader.facts()["n_outages"])
    assert re.search(why, device.reader.facts()["failure"])


def test_stated_delay_shifts_stamps_of_all_listeners(plugged):
    device = plugged("serial")
    late = Reader(device.reader.source, delay_s=0.03)
    straight, delayed = Listener(n_channels=3), late.listen()
    take = late._take

    def taken(block):
        if block is not None and block.times_s.size:
            straight.append(block)
        return take(block)

    late._take = taken
    late.open()
    wait_for(lambda: late.facts()["n_samples"] > 200)
    late.close()
    one, other = straight.read(), delayed.read()
    assert np.allclose(one.times_s - other.times_s, 0.03, rtol=0, atol=1e-9)


def recording(path: Path, text):
    path.write_text(text, encoding="utf-8")
    return RecordedSettings(str(path), 100.0).source()


def test_recording_is_replayed_in_real_time(tmp_path):
    rows = "".join(f"{7 + n / 100},{n}\n" for n in range(30))
    reader = Reader(recording(tmp_path / "f.csv", "time_s,count\n" + rows))
    force = streamed_force(reader, 0, ForceCalibration(newtons_per_count=1.0))
    heard = []  # since opening; `read` begins later
    force.subscribe(lambda times_s, forces_n: heard.extend(zip(times_s.tolist(), forces_n.tolist(), strict=True)))
    begin_s = time.perf_counter()
    force.open()
    wait_for(lambda: len(heard) == 30)
    end_s = time.perf_counter()
    force.close()
    times_s, forces_n = zip(*heard, strict=True)
    assert forces_n == tuple(range(30))
    assert np.allclose(np.diff(times_s), 0.01)
    assert begin_s <= times_s[0]
    assert times_s[-1] <= end_s


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("t,x\n0,1\n", "found the columns t, x, expected time_s and 1 channels"),
        ("time_s,x\n", r"cannot be read as a recording \(found no rows of numbers, expected at least one row\)"),
        ("time_s,x\n0\n", "found 1 columns of numbers for 2 names, expected equal numbers"),
        ("time_s,x\n1,2\n0,3\n", "found times that do not increase"),
        ("time_s,x\n1,a\n", "cannot be read as a recording"),
    ],
)
def test_invalid_recording_is_refused(tmp_path, text, message):
    with pytest.raises(DeviceFailed, match=message):
        recording(tmp_path / "f.csv", text).open()


# --- properties of all received samples


@pytest.fixture(params=KINDS)
def stream(request, heard):
    if request.param not in heard:
        pytest.skip(f"no {LIBRARIES[request.param]}: extra {request.param}")
    return heard[request.param]


def lateness_s(block):
    return since_taken_s(block, block.values[:, -1])


def since_taken_s(block, times_s):
    return ((times_s * 1e6 - np.round(block.values[:, 1]) + 2**30) % 2**31 - 2**30) / 1e6


def test_streams_lose_no_uncounted_samples(stream):
    block, facts = stream
    steps = np.diff(block.values[:, 0])
    assert np.all(steps >= 1)
    if facts["n_outages"]:
        assert np.max(lateness_s(block)) > LATE_S
    else:
        assert np.sum(steps - 1) <= (facts["n_lost"] if "n_refused" in facts else 0)
        assert facts["failure"] is None


def test_stamps_match_sampling_times(stream):
    block, _ = stream
    steps_back = np.diff(block.times_s, prepend=-np.inf) < 0
    assert np.all((since_taken_s(block, block.times_s) > -2e-3)[1000:] | steps_back[1000:])
    assert np.all(block.times_s <= block.values[:, -1] + STEP_S)
