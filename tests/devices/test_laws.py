"""Properties of every output and sensor of the catalogue."""

import time
from datetime import date

import catalogue
import numpy as np
import pytest
from emulated import LIBRARIES, Emulator, available

from tactometry.devices.kinds import OUTPUTS, SENSORS
from tactometry.errors import LimitExceeded
from tactometry.experiments.bench.bench_file import parse_bench
from tactometry.safety.limits import Limits
from tactometry.signal import Signal

STUDY = Limits(1000.0)
LIMITS = {"voltage_peak_v": 100.0, "duration_s": 1.0, "current_peak_a": 10.0, "displacement_peak_m": 1e-3}
LIMITS |= {"duty": 1.0, "session_s": 60.0}
LOAD = {"kind": "piezo", "capacitance_f": 1e-9, "displacement_m_per_v": [1e-6]}
per_output = pytest.mark.parametrize("name", catalogue.OUTPUTS)
per_sensor = pytest.mark.parametrize("name", catalogue.SENSORS)


def output_of(name, limits=None):
    output = {**catalogue.OUTPUTS[name], "load": LOAD}
    bench = parse_bench({"output": output, "limits": LIMITS if limits is None else limits})
    return bench.devices(STUDY, date.today(), touched=False).output


def one_bit(output, voltage_v=30.0):
    bits = np.where(np.random.default_rng(0).random((2, 500)) < 0.5, voltage_v, -voltage_v)
    return Signal(bits, output.driver.rate_hz or 48e3, "V")


@pytest.fixture
def output(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return output_of(name)


# "audio" needs a card: test_audio.py, test_check.py
@pytest.mark.parametrize("name", sorted(catalogue.OUTPUTS.keys() - {"audio"}))
def test_output_may_be_stopped_and_closed_twice(output):
    output.stop()
    output.open()
    before_s = time.perf_counter()
    onset_s = output.play(one_bit(output))
    assert before_s <= onset_s
    output.stop()
    output.stop()
    output.close()
    output.close()


@per_output
def test_check_returns_samples_within_the_limits(name):
    output = output_of(name)
    signal = one_bit(output)
    _, final = output.check(signal)
    assert final.peak <= signal.peak * (1 + 1e-12)
    assert np.allclose(final.samples, signal.samples, atol=1e-3)


@per_output
@pytest.mark.parametrize("limit", ["voltage_peak_v", "current_peak_a", "displacement_peak_m", "session_s"])
def test_outputs_refuse_signals_above_a_limit(name, limit, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    output = output_of(name, {**LIMITS, limit: 1e-9})
    with pytest.raises(LimitExceeded, match=f"limits.{limit}: .*nothing was played"):
        output.play(one_bit(output))
    assert list(tmp_path.iterdir()) == []


def test_catalogue_has_every_output_except_ni():
    assert {table["kind"] for table in catalogue.OUTPUTS.values()} == OUTPUTS.keys() - {"ni"}


def test_catalogue_has_every_force_sensor():
    assert {table["kind"] for table in catalogue.SENSORS.values()} == SENSORS.keys() - {"audio", "touch"}


@pytest.fixture
def sensor(name, tmp_path, monkeypatch):
    """Force sensor from a bench file, with an emulator that presses with 1 N."""
    monkeypatch.chdir(tmp_path)
    table = dict(catalogue.SENSORS[name])
    device = None
    if name == "recorded":
        rows = "".join(f"{n / 100},100\n" for n in range(500))
        (tmp_path / "recording.csv").write_text("time_s,count\n" + rows, encoding="utf-8")
    else:
        if not available(name):
            pytest.skip(f"no {LIBRARIES[name]}: extra {name}")
        device = Emulator(name, tmp_path)
        table |= {
            "serial": {"port": str(device.port)},
            "udp": {"port": device.udp_port},
            "lsl": {"stream": device.name},
        }[name]
    force = {"sensor": "hand", "channel": 0 if name == "recorded" else 2, "newtons_per_count": 0.01}
    yield parse_bench({"sensors": {"hand": table}, "force": force}).devices(STUDY, date(2026, 11, 21)).force
    if device is not None:
        device.close()


@per_sensor
def test_sensor_returns_stamped_newtons_without_waiting(sensor):
    assert sensor.read()[0].size == 0
    begin_s = time.perf_counter()
    sensor.open()
    end_s = begin_s + 20
    times_s, forces_n = sensor.read()
    while times_s.size == 0 and time.perf_counter() < end_s:
        time.sleep(0.01)
        times_s, forces_n = sensor.read()
    now_s = time.perf_counter()
    assert np.all(forces_n == 1.0)
    assert np.all(np.diff(times_s) >= 0)
    assert begin_s - 60 < times_s[0] <= times_s[-1] <= now_s + 1e-3
    sensor.close()
    sensor.close()
