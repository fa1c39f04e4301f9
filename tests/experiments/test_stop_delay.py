"""Worst-case delay of a stop, and limits that are switched off."""

import copy
import io
import json
import tomllib
from datetime import date
from types import SimpleNamespace

import pytest
from benches import file_bench, gain_table
from command_line import call
from study_texts import TUTORIAL, changed, wired

from tactometry.arguments.require import HIGHEST, UNLIMITED, Unlimited
from tactometry.devices.outputs.audio import AudioSettings
from tactometry.devices.outputs.gain import Gain
from tactometry.devices.outputs.guarded import Guarded
from tactometry.devices.outputs.output import NullOutput
from tactometry.errors import InvalidFile, InvalidParameter, LimitExceeded
from tactometry.experiments.bench.bench_file import device_facts, parse_bench
from tactometry.experiments.bench.bench_table import table_toml
from tactometry.experiments.bench.preflight import _study, devices
from tactometry.experiments.study.study_file import parse
from tactometry.safety.limits import Limits

TODAY = date.today()
STUDY = Limits(80.0)
CHAINS = {"audio": "audio Interface, int32", "packed": "packed board", "ni": "ni Dev1/ao0, 10 V"}
OUTPUTS = {
    "audio": {"device": "Interface", "rate_hz": 192e3},
    "packed": {"path": "board", "n_channels": 32, "rate_hz": 1e6},
    "ni": {"channels": ["Dev1/ao0"], "rate_hz": 1e5},
}
LIMITS = {"voltage_peak_v": 80.0, "duration_s": 10.0, "current_peak_a": 1e-3, "duty": 0.5, "session_s": 3600.0}
FORCE_OFF = 'limits.force_peak_n = "unlimited": this limit is switched off'


def bench_of(kind="audio", limits=None, gain=None, **output):
    table = {"kind": kind, **OUTPUTS[kind], "ungated": True, "gain": gain_table(CHAINS[kind]) | (gain or {}), **output}
    load = {"kind": "electrode", "capacitance_f": 1e-9}
    return parse_bench({"output": {**table, "load": load}, "limits": LIMITS | (limits or {})})


@pytest.fixture
def unlimited(tmp_path):
    study = tmp_path / "s.toml"
    study.write_text(changed(TUTORIAL, {"[limits]\n": '[limits]\nforce_peak_n = "unlimited"\n'}))
    return study


@pytest.mark.parametrize("kind", OUTPUTS)
def test_default_output_stops_within_the_limit(kind):
    bench = bench_of(kind)
    assert 0.05 < bench.stop_delay_s <= 0.1
    assert bench.devices(STUDY, TODAY).output.driver.stop_delay_s == bench.stop_delay_s


@pytest.mark.parametrize(
    ("latency_s", "block_s", "of_bench", "of_study", "found"),
    [
        (10.0, 0.005, {}, None, "10.006 s, the limit is 0.1 s"),
        (0.05, 1.0, {}, None, "1.051 s, the limit is 0.1 s"),
        (0.0941, 0.005, {}, None, "0.1001 s, the limit is 0.1 s"),
        (0.05, 0.005, {"stop_within_s": 0.055}, None, "0.056 s, the limit is 0.055 s"),
        (0.05, 0.005, {}, 0.055, "0.056 s, the limit is 0.055 s"),
        (0.15, 0.005, {"stop_within_s": 0.2}, 0.12, "0.156 s, the limit is 0.12 s"),
        (0.094, 0.005, {}, None, None),
        (0.15, 0.005, {"stop_within_s": 0.2}, None, None),
        (10.0, 0.005, {"stop_within_s": "unlimited"}, None, None),
    ],
)
def test_bench_refuses_output_that_stops_late(latency_s, block_s, of_bench, of_study, found):
    bench, study = bench_of(limits=of_bench, latency_s=latency_s, block_s=block_s), Limits(80.0, stop_within_s=of_study)
    if found is None:
        assert bench.devices(study, TODAY).output.driver.connected
        return
    with pytest.raises(LimitExceeded, match=rf"limits\.stop_within_s: found an output that may stop after {found}"):
        bench.devices(study, TODAY)


def test_open_card_states_its_own_latency():
    driver = AudioSettings(48e3, "Interface").driver(Gain(1.0, 1.0))
    driver._stream = SimpleNamespace(latency=0.2)
    assert driver.stop_delay_s == pytest.approx(0.206)
    driver._dry.leads_s.append(0.3)
    assert driver.stop_delay_s == pytest.approx(0.306)


class LateWhenOpen(NullOutput):
    """Device that buffers more than requested once it is open."""

    def __init__(self):
        super().__init__()
        self.is_open = False

    stop_delay_s = property(lambda self: 0.3 if self.is_open else 0.05)

    def open(self):
        self.is_open = True

    def close(self):
        self.is_open = False


def test_guard_closes_device_that_buffers_too_much():
    driver = LateWhenOpen()
    with pytest.raises(LimitExceeded, match=r"found an output that may stop after 0\.3 s"):
        Guarded(driver, STUDY).open()
    assert not driver.is_open


@pytest.mark.parametrize(("latency_s", "fine"), [(0.05, True), (0.2, False)])
def test_check_shows_the_worst_case_stop(latency_s, fine):
    bench = bench_of(latency_s=latency_s)
    found = {each.what: each for each in devices(bench, STUDY, None, hands_off=False)}
    shown = found["worst-case stop, from the bench file"]
    assert (shown.found, shown.expected, shown.fine) == (f"{1e3 * latency_s + 6:.1f} ms", "at most 100 ms", fine)
    current = found["largest current of a stop, without a limit"]
    assert current.found == "8e-05 A from 80 V in 1 ms"  # 1 nF x 80 V / 1 ms


@pytest.mark.parametrize("table", ["bench", "study"])
@pytest.mark.parametrize("name", [name for name in HIGHEST if name != "max_age_days"])
def test_limits_of_files_refuse_implausible_numbers(table, name):
    too_high = 1.01 * HIGHEST[name]
    kept = TUTORIAL.replace("voltage_peak_v = 100.0", "") if name == "voltage_peak_v" else TUTORIAL
    text = changed(kept, {"[limits]\n": f"[limits]\n{name} = {too_high!r}\n"})
    expected = rf'limits\.{name}: found [\d.e+-]+, expected at most [\d.e+-]+, or "unlimited"$'
    with pytest.raises((InvalidParameter, InvalidFile), match=expected):
        bench_of(limits={name: too_high}) if table == "bench" else parse(text.encode(), "s.toml")


@pytest.mark.parametrize("part", ["gain", "force"])
@pytest.mark.parametrize("age", [3651, 99999999])
def test_calibrations_refuse_implausible_ages(part, age):
    force = {"sensor": "hand", "newtons_per_count": 0.01, "max_age_days": age}
    sensors = {"hand": {"kind": "lsl", "stream": "force", "rate_hz": 1e3}}
    with pytest.raises(InvalidParameter, match=rf'max_age_days: found {age}, expected at most 3650, or "unlimited"$'):
        bench_of(gain={"max_age_days": age}) if part == "gain" else parse_bench({"sensors": sensors, "force": force})


@pytest.mark.parametrize("key", ["limits.duty", "limits.duty_window_s", "touch.timeout_s", "stimulus.duration_s"])
def test_only_limits_may_be_unlimited(key):
    table, name = key.split(".")
    text = changed(TUTORIAL, {f"[{table}]\n": f'[{table}]\n{name} = "unlimited"\n'})
    numbers = [line for line in text.splitlines() if line.startswith(f"{name} =") and "unlimited" not in line]
    kept = "\n".join(line for line in text.splitlines() if line not in numbers)
    with pytest.raises((InvalidParameter, InvalidFile), match=rf"{name}: found 'unlimited', expected a number"):
        wired(kept)


def test_duty_window_is_at_most_an_hour():
    with pytest.raises(InvalidParameter, match=r"limits\.duty_window_s: found 3601, expected at most 3600"):
        bench_of(limits={"duty_window_s": 3601.0})


def test_bench_warns_of_each_limit_switched_off():
    names = [name for name in HIGHEST if name != "max_age_days"]
    bench = bench_of(limits=dict.fromkeys(names, "unlimited"), gain={"max_age_days": "unlimited"})
    assert bench.limits.switched_off == tuple(name for name in vars(bench.limits) if name in names)
    keys = [*(f"limits.{name}" for name in bench.limits.switched_off), "output.gain.max_age_days"]
    told = [f'bench file, {key} = "unlimited": this limit is switched off' for key in keys]
    assert [caution for caution in bench.cautions if "switched off" in caution] == told


def test_unlimited_gain_of_any_age_is_used():
    old = {"max_age_days": "unlimited", "measured_on": date(1990, 1, 1)}
    bench = bench_of(gain=old)
    facts = device_facts(bench, bench.devices(STUDY, TODAY))
    assert facts["output_gain_measured"] == "1990-01-01 ZG"


def test_tighter_limit_holds_against_an_unlimited_one():
    both = Limits(80.0, force_peak_n=UNLIMITED).tighter(Limits(80.0, force_peak_n=5.0))
    assert (both.force_peak_n, both.switched_off) == (5.0, ())


def test_unlimited_stays_itself_in_copies_and_files():
    copied = copy.deepcopy(Limits(80.0, force_peak_n=UNLIMITED))
    assert isinstance(copied.force_peak_n, Unlimited)
    assert json.loads(json.dumps(copied.facts(), allow_nan=False))["limit_force_peak_n"] == "unlimited"
    assert tomllib.loads(table_toml("gain", {"max_age_days": UNLIMITED})) == {"gain": {"max_age_days": "unlimited"}}


def test_run_warns_of_limits_switched_off(unlimited, tmp_path, capsys, monkeypatch):
    bench = file_bench(tmp_path, 0.5)
    bench.write_text(bench.read_text().replace("[limits]", '[limits]\nforce_peak_n = "unlimited"'))
    words = ("run", unlimited, "--participant", "P01", "--bench", bench)
    code, said, _ = call(capsys, *words, "--dry-run")
    assert (code, said.splitlines()) == (0, [f"study, {FORCE_OFF}", f"bench file, {FORCE_OFF}"])
    monkeypatch.setattr("sys.stdin", io.StringIO())
    assert f"study, {FORCE_OFF}" in call(capsys, *words, "--rig", "console", "--out", tmp_path / "d")[1]


def test_dry_run_refuses_output_that_stops_late(tmp_path, capsys):
    bench = tmp_path / "bench.toml"
    gain = table_toml("output.gain", gain_table(CHAINS["audio"]))
    output = 'kind = "audio"\ndevice = "Interface"\nrate_hz = 192e3\nlatency_s = 10\nungated = true\n'
    bench.write_text(f"[output]\n{output}{gain}")
    code, said, _ = call(capsys, "run", "tutorial", "--participant", "P01", "--bench", bench, "--dry-run")
    assert (code, said.count("\n")) == (3, 0)
    assert "limits.stop_within_s: found an output that may stop after 10.006 s" in said


def test_check_warns_of_limits_switched_off(unlimited):
    findings, _ = _study(str(unlimited), allow_code=False)
    findings += devices(bench_of(limits={"force_peak_n": "unlimited"}), STUDY, None, hands_off=False)
    told = [each.found for each in findings if each.what == "caution" and "switched off" in each.found]
    assert told == [f"study, {FORCE_OFF}", f"bench file, {FORCE_OFF}"]
