"""Texture sessions with a UDP position sensor and a sound server."""

import importlib.util
import json
import threading
from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest
from command_line import at_the_console, call
from emulated import Emulator, wait_for
from sound_server import Sink, alsa_in
from study_texts import changed
from tables import rows_of, trial_rows
from texture_bench import (
    POSITION,
    RELEASED,
    check_kept_as_heard,
    console_session,
    texture_bench,
    texture_study,
    touches_heard_as_asked,
)

from tactometry.devices.outputs.frame_feed import FollowingFeed
from tactometry.devices.outputs.guarded import Guarded
from tactometry.errors import InvalidParameter, LimitExceeded
from tactometry.experiments.bench.bench_file import Devices, load_bench
from tactometry.experiments.bench.preflight_checks import findings_of, position
from tactometry.experiments.data_sets.validation import validate
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.study_file import parse
from tactometry.position_dependent import N_KEPT, FingerPath, FollowedSignal, PlayedPath, felt_under
from tactometry.rigs.touch.gated_samples import Trace
from tactometry.rigs.touch.touch import TouchRun
from tactometry.safety.limits import Limits
from tactometry.safety.load import Load
from tactometry.signal import Signal
from tactometry.stimuli.electrovibration import Grating
from tactometry.stimuli.electrovibration.textures.followed_texture import FollowedTexture
from tactometry.stimuli.electrovibration.textures.texture import Region


@pytest.fixture
def needed():
    if importlib.util.find_spec("sounddevice") is None:
        pytest.skip("no sounddevice: extra audio")


def test_sound_output_follows_measured_positions(needed, sink, tmp_path, capsys):
    study, device = texture_study(tmp_path), Emulator("udp", tmp_path, profile=RELEASED)
    sink.begin()
    try:
        # positions arrive late on a busy computer, hence the long latency
        bench = texture_bench(tmp_path, device.udp_port, more="position_latency_s = 0.2")
        bench.write_text(bench.read_text().replace("\nlatency_s = 0.02", "\nlatency_s = 0.1"))
        status, _, errors = console_session(study, bench, tmp_path / "d", sink.env)
        frames = sink.end()
    finally:
        device.close()
    assert status == 0, errors
    touched = touches_heard_as_asked(study, tmp_path / "d", frames)
    check_kept_as_heard(tmp_path / "d", frames)
    assert validate(tmp_path / "d").defects == ()
    assert call(capsys, "export", tmp_path / "d", "--to", "bids", "--out", tmp_path / "bids")[0] == 0
    (stored,) = (tmp_path / "d" / "traces").glob("*_stim.tsv.gz")
    copied = tmp_path / "bids" / "sourcedata" / "traces" / stored.name
    assert copied.read_bytes() == stored.read_bytes()
    ends = rows_of(copied.with_name(stored.name.replace(".tsv.gz", "_touches.tsv")))
    assert len(ends) == len(touched)
    assert int(ends[-1]["first_byte"]) + int(ends[-1]["n_bytes"]) == len(copied.read_bytes())
    (positions,) = (tmp_path / "d" / "journals").glob("*_positions.tsv")
    kept = positions.read_bytes()
    positions.write_bytes(kept[:-3] + b"9\n")
    (defect,) = validate(tmp_path / "d").defects
    assert "found another path than the recorded one under" in str(defect)
    positions.unlink()
    (defect,) = validate(tmp_path / "d").defects
    assert f"found no such file, expected the positions of {len(touched)} trials" in str(defect)
    positions.write_bytes(kept)
    assert call(capsys, "replay", tmp_path / "d")[0] == 0
    assert call(capsys, "analyse", tmp_path / "d", "--report", tmp_path / "r.html")[0] == 0
    journal = next((tmp_path / "d" / "journals").glob("*.jsonl")).read_text().splitlines()
    assert json.loads(journal[0])["facts"]["output_position_latency_s"] == 0.2


NO_SENSOR = "position: found none, expected the sensor that tells where the finger is, as a texture follows it"
REFUSED = {
    "no position": ({"position": ""}, {}, 2, NO_SENSOR),
    "a file": (
        {"position": POSITION}, {'kind = "audio"': 'kind = "file"\nfolder = "played"'}, 3,
        "found a texture, whose signal follows the finger, expected a signal known at its onset; use",
    ),
    "no such channel": (
        {}, {"channels = [0]": "channels = [99]"}, 2,
        "position.channels: found 99, expected a channel of udp 127.0.0.1:9, from 0 to 5",
    ),
    "a place of long ago": (
        {"more": "position_latency_s = 2.5"}, {}, 2,
        "bench.toml, output.position_latency_s: found 2.5, expected at most 1",
    ),
    "a block of years": (
        {"more": "block_s = 1e11"}, {}, 2, "bench.toml, output.block_s: found 1e+11, expected at most 1",
    ),
    "a block of nothing": (
        {"more": "block_s = 1e-9"}, {}, 2,
        "bench.toml, output.block_s: found 4.8e-05 samples, expected at least one sample at rate_hz",
    ),
    "too slow": (
        {"position": POSITION}, {"rate_hz = 1000\n": "rate_hz = 40\n"}, 2,
        "sensors.hand.rate_hz: found 40.0 reports per second, expected more than 50 for a period of 0.002 m at 0.05",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("how", "changes", "status", "words"), REFUSED.values(), ids=REFUSED)
def test_unsuitable_texture_bench_is_refused_before_opening(tmp_path, capsys, monkeypatch, how, changes, status, words):
    study, bench = texture_study(tmp_path), texture_bench(tmp_path, 9, **how)
    text = changed(bench.read_text(), changes)
    if "folder" in text:  # a file has no gain, device or latency
        begin, end = text.index('device = "pulse"'), text.index("[output.load]")
        text = text[:begin] + "rate_hz = 48000\n" + text[end:]
    bench.write_text(text)
    monkeypatch.setattr("tactometry.experiments.bench.bench_file.BenchFile.check_gate", lambda bench: None)
    monkeypatch.setattr("tactometry.devices.outputs.gain.Gain.check", lambda *words: None)
    found, said, _ = at_the_console(capsys, monkeypatch, study, tmp_path / "d", "", "--bench", bench)
    assert (found, words in said) == (status, True), said


@pytest.mark.slow
def test_session_keeps_data_when_sound_server_dies(needed, tmp_path):
    own, device = Sink(tmp_path, alsa_in(tmp_path)), Emulator("udp", tmp_path, profile=RELEASED)
    study = texture_study(tmp_path, {"repeats = 4": "repeats = 200"})
    bench, data = texture_bench(tmp_path, device.udp_port), tmp_path / "d"

    def pull_the_plug():
        wait_for(lambda: any('"Record"' in path.read_text() for path in (data / "journals").glob("*.jsonl")))
        own.server.kill()

    plug = threading.Thread(target=pull_the_plug)
    plug.start()
    try:
        status, _, errors = console_session(study, bench, data, own.env)
        plug.join()
    finally:
        device.close()
        own.close()
    assert status == 3, errors
    [said] = [line for line in errors.splitlines() if line.startswith("tactometry: ")]
    assert "output 'audio pulse': found a closed or stopped device, expected an open device; nothing was played" in said
    assert "Traceback" not in errors
    assert len(trial_rows(data)) >= 1
    assert validate(data).defects == ()


def test_check_reports_missing_position_sensor(tmp_path):
    study, bench = texture_study(tmp_path), load_bench(texture_bench(tmp_path, 9, position=""))
    experiment = wire(parse(study.read_bytes(), "s.toml"), "s.toml")
    connected = Devices(Guarded(bench.output.settings.driver(bench.output.gain), bench.limits), None, None, {})
    *_, finding = findings_of("position", position(connected, bench, experiment))
    assert (finding.fine, finding.found.startswith(NO_SENSOR)) == (False, True)


def feed(texture, positions, stamps_s, **keys):
    """Return a constant-voltage feed from 1 s on that follows positions."""
    stimulus = FollowedTexture(texture, duration_s=0.1, ramp_s=0.0, **keys)
    path = FingerPath()
    path.on_samples(np.asarray(stamps_s), np.asarray(positions)[:, None])
    signal = FollowedSignal(np.full((1, 2000), 1.0), 20e3, "V", stimulus, path)
    made = FollowingFeed(np.full((2000, 1), 1000.0), 20, signal, latency_s=0.05)
    made.onset_s = 1.0
    return made


def test_feed_uses_position_one_latency_earlier():
    made = feed(Region(0.01, 0.03), [0.0, 0.02], [0.9, 1.1], rise_s=5e-5)
    emitted = np.concatenate([made.take(n)[:, 0] for n in (7, 993, 500, 500)])
    # 0.01 m at 1.0 s is played 50 ms later, 1000 frames after the onset
    assert emitted[:999].max() == 0.0
    assert emitted[1001:].min() == 1000.0
    assert (made.late, made.unknown) == (0.0, 0.0)


def test_missing_position_is_held_then_unknown():
    made = feed(Region(-1.0, 1.0), [0.0, 0.0], [0.8, 0.86], rise_s=5e-5)
    emitted = made.take(2000)[:, 0]
    # the first frame uses 0.95 s; a position is held for 0.1 s, until 0.96 s: 200 frames
    assert made.late == 1.0
    assert made.unknown == pytest.approx(0.9, abs=2e-3)
    assert emitted[:199].min() == 1000.0
    assert emitted[203:].max() == 0.0


@dataclass(frozen=True)
class Custom(FollowedTexture):
    """A texture whose custom code returns these parts in turn."""

    returned: tuple = ()

    def parts(self, x_m, before=None):
        return np.resize(self.returned, x_m.size), before


@pytest.mark.parametrize("returned", [(7.0, -3.0), (np.nan, 1.0), (np.inf, -np.inf), (0.0, 0.0, 1.0), (1.0, 0.2)])
def test_followed_frames_keep_what_the_guard_assumed(returned):
    stimulus = Custom(Region(-1.0, 1.0), duration_s=0.1, ramp_s=0.0, rise_s=1e-3, returned=returned)
    signal = FollowedSignal(np.full((1, 2000), 1.0), 20e3, "V", stimulus, FingerPath())
    made = FollowingFeed(np.full((2000, 1), 1000.0), 20, signal, latency_s=0.05)
    emitted = np.concatenate([made.take(n)[:, 0] for n in (7, 993, 1000)])
    assert np.isfinite(emitted).all()
    assert 0.0 <= emitted.min() <= emitted.max() <= 1000.0
    assert np.abs(np.diff(emitted)).max() <= 50.0 * (1 + 1e-6)  # 1000 in 1 ms at 20 kHz


@pytest.mark.parametrize("rise_s", [0.0, -1e-3, np.nan, np.inf])
def test_followed_signal_refuses_impossible_rise(rise_s):
    stimulus = FollowedTexture(Region(-1.0, 1.0))
    object.__setattr__(stimulus, "rise_s", rise_s)
    with pytest.raises(InvalidParameter, match=r"FollowedSignal\.rise_s"):
        FollowedSignal(np.ones((1, 10)), 20e3, "V", stimulus, FingerPath())


def test_paths_never_exceed_current_and_charge_bounds():
    rng = np.random.default_rng(3)
    stimulus = FollowedTexture(Grating(1e-3), rate_hz=48e3, duration_s=0.2, carrier_hz=500.0, rise_s=5e-4)
    strongest, load = stimulus.at(40.0), Load("electrode", 1e-9, 1e7)
    most_a, most_c = (of(strongest, stimulus.rise_s) for of in (load.current_peak_a, load.charge_peak_c))
    for _ in range(20):
        times_s = np.arange(0.0, 0.2, 1e-3)
        wild = felt_under(stimulus, strongest, times_s, np.cumsum(rng.normal(0.0, 1e-3, times_s.size)))
        assert load.current_peak_a(wild) <= most_a
        assert load.charge_peak_c(wild) <= most_c
        assert load.passed_c(wild).largest_c <= load.passed_c(strongest, stimulus.rise_s).largest_c
    assert most_a > load.current_peak_a(strongest)
    limits = Limits(200.0, duration_s=1.0, current_peak_a=load.current_peak_a(strongest), duty=1.0, session_s=60.0)
    limits.check_load(strongest, load)
    with pytest.raises(LimitExceeded, match="current_peak_a"):
        limits.check_load(strongest, load, stimulus.rise_s)


def test_guard_checks_followed_signal_at_its_strongest(tmp_path):
    bench = load_bench(texture_bench(tmp_path, 9))
    stimulus = FollowedTexture(Grating(1e-3), rate_hz=48e3)
    plain = stimulus.at(30.0)
    followed = FollowedSignal(plain.samples, plain.rate_hz, plain.unit, stimulus, FingerPath())
    assert followed != plain
    tight = replace(bench.limits, current_peak_a=bench.output.load.filtered_current_a(plain, 0.0) * (1 + 1e-9))
    guarded = Guarded(bench.output.settings.driver(bench.output.gain), tight, bench.output.load)
    guarded.check(plain)
    with pytest.raises(LimitExceeded, match="current_peak_a"):
        guarded.check(followed)


def test_finger_path_drops_backward_stamps():
    path = FingerPath()
    for n in range(N_KEPT + 10):
        path.on_samples(np.array([1e-3 * n, 1e-3 * n - 0.5]), np.array([[1.0 * n], [-1.0]]))
    path.on_samples(np.array([1e3]), np.array([[np.nan]]))
    assert path.last_s == pytest.approx(1e-3 * (N_KEPT + 9))
    times_s = 1e-3 * np.arange(N_KEPT - 100, N_KEPT + 10)
    np.testing.assert_allclose(path.at(times_s), times_s * 1e3)
    assert np.isnan(path.at(np.array([0.0, 1e3]))).all()


def test_first_position_is_kept_when_stamps_repeat():
    """Touch screens without kernel stamps may send several positions at once."""
    places, path, kept = Trace(), FingerPath(), []
    for on_samples in (places.on_samples, path.on_samples):
        on_samples(np.array([1.0, 1.0, 1.1]), np.array([[0.0], [5.0], [0.1]]))
    course = PlayedPath(Signal(np.zeros((1, 100)), 1e3, "V"), latency_s=0.0, late=0.0, unknown=0.0)
    setup = SimpleNamespace(keep_path=lambda digest, lines: kept.append(lines))
    TouchRun(None, setup, places)._positions_digest(1.05, course)
    assert kept == [b"-0.050000\t0.000000000\n0.050000\t0.100000000\n"]
    assert path.at(np.array([1.05])) == pytest.approx(0.05)
