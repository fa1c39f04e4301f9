"""Audio output through PortAudio: an ALSA file and a PulseAudio sink."""

import importlib.util
import json
import re
import signal
import subprocess
import sys
import time
from datetime import date
from pathlib import Path

import numpy as np
import player
import pytest
from benches import gain_table
from hard_cases import hard_case
from hypothesis import given, strategies as st
from patience import LONGEST_PROGRAM_S, LONGEST_WAIT_S
from sound_server import heard_part, played

from tactometry.devices.outputs import frame_feed
from tactometry.devices.outputs.audio import AudioOutput, AudioSettings
from tactometry.devices.outputs.frame_feed import FrameFeed
from tactometry.devices.outputs.gain import Gain
from tactometry.errors import DeviceFailed
from tactometry.experiments.bench.bench_file import parse_bench
from tactometry.safety.limits import Limits
from tactometry.signal import Signal

PROGRAM = [sys.executable, player.__file__]

if importlib.util.find_spec("sounddevice") is None:
    pytest.skip("no sounddevice: pip install 'tactometry[audio]'", allow_module_level=True)


def asked(n_channels, device, duration_s, **more):
    return {"n_channels": n_channels, "rate_hz": 48_000.0, "device": device, "duration_s": duration_s, **more}


def output_of(command, env):
    return subprocess.run(command, env=env, check=True, timeout=LONGEST_PROGRAM_S, capture_output=True).stdout.decode()


@pytest.mark.parametrize(("n_channels", "rate_hz"), [(2, 48e3), (8, 48e3), (32, 48e3), (2, 192e3)])
def test_file_output_receives_every_sample(alsa, tmp_path, n_channels, rate_hz):
    what = asked(n_channels, "tofile", 1.0, rate_hz=rate_hz)
    output_of([*PROGRAM, json.dumps(what)], alsa)
    assert played((tmp_path / "played.raw").read_bytes(), player.frames(what))


def test_signal_fades_to_zero_before_the_next_begins(alsa, tmp_path):
    what = asked(1, "tofile", 60.0, then_s=[0.1])
    output_of([*PROGRAM, json.dumps(what)], alsa)
    heard = heard_part(np.frombuffer((tmp_path / "played.raw").read_bytes(), "<i2")[:, None])[:, 0]
    first, second = (player.frames(asked(1, "tofile", duration_s))[:, 0] for duration_s in (60.0, 0.1))
    assert np.array_equal(heard[-len(second) :], second)
    before = np.trim_zeros(heard[: -len(second)])
    n_whole = len(before) - 48
    assert 0 < n_whole < len(first) - 48
    assert np.array_equal(before[:n_whole], first[:n_whole])
    falling = first[n_whole : n_whole + 48] * (1 - np.arange(48) / 48)
    assert np.all(np.abs(before[n_whole:] - falling) <= 1)


OPEN = """
import json, sys
from tactometry.devices.outputs.audio import AudioSettings
from tactometry.devices.outputs.gain import Gain
try:
    AudioSettings(48e3, **json.loads(sys.argv[1])).driver(Gain(1.0, 1.0)).open()
except Exception as error:
    print(type(error).__name__, error)
"""


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"device": "no such card"}, "cannot open no such card with 1 channels at 48000 Hz as int32"),
        ({"device": "null", "channels": [90_000]}, "with 90001 channels"),
    ],
)
def test_unusable_card_is_named_in_one_sentence(alsa, settings, message):
    report = output_of([sys.executable, "-c", OPEN, json.dumps(settings)], alsa)
    assert report.startswith(f"DeviceFailed output audio: {'cannot open' if 'no' in message else ''}")
    assert message in report
    assert "nothing was played" in report


def test_rounding_never_raises_a_sample():
    signal = Signal(np.random.default_rng(0).uniform(-1, 1, (1, 10_000)), 48e3, "V")
    for sample_format in ("int16", "int32", "float32"):
        final = AudioOutput(AudioSettings(48e3, "card", sample_format=sample_format), Gain(1.0, 1.0)).final(signal)
        assert np.all(np.abs(final.samples) <= np.abs(signal.samples))
        hard_case("samples of 16 bits", final.samples, signal.samples, 6.2e-5, against="the signal", floor=1)


def test_shared_card_is_refused_unless_allowed(sink):
    """The other tests with this sound server set `shared`."""

    def opened(device):
        settings = json.dumps({"device": device, "sample_format": "int16"})
        return output_of([sys.executable, "-c", OPEN, settings], sink.env)

    assert opened("pulse").startswith("DeviceFailed output audio: found 'pulse' (ALSA), which other programs may use")
    assert opened("pulse").endswith("a separate card, or shared = true in [output]; nothing was played\n")
    assert "other programs" not in opened("tofile") + opened("nothing")


def test_gain_is_refused_when_system_volume_differs(sink, monkeypatch):
    monkeypatch.setenv("PULSE_SERVER", sink.env["PULSE_SERVER"])
    table = {"kind": "audio", "device": "pulse", "rate_hz": 48e3, "shared": True, "ungated": True}
    limits = {"voltage_peak_v": 1.0}

    def devices(**more):
        gain = gain_table("audio pulse, int32", **more)
        return parse_bench({"output": {**table, "gain": gain}, "limits": limits}).devices(Limits(1.0), date.today())

    def set_volume(words):
        subprocess.run(["pactl", "set-sink-volume", "finger", words], env=sink.env, check=True)

    assert devices(system_volume=1.0).output.name == "audio pulse"
    with pytest.raises(DeviceFailed, match=r"system_volume: found a measurement at an unknown volume, .* of 100 %,"):
        devices()
    try:
        set_volume("40%")
        with pytest.raises(DeviceFailed, match=r"a volume of 100 %, expected a volume of 40 %, the current setting;"):
            devices(system_volume=1.0)
        assert devices(system_volume=0.4).output.name == "audio pulse"
    finally:
        set_volume("100%")


# --- in real time


N_RUNS = 4
"""On a busy machine the card or the sound server may drop samples, and a run is repeated."""


def runs(sink, what):
    """Yield the report and the recorded frames of each run without an underrun."""
    for _ in range(N_RUNS):
        sink.begin()
        report = output_of([*PROGRAM, json.dumps(what)], sink.env)
        frames = sink.end()
        if json.loads(report.splitlines()[-1])["n_underruns"] == 0:
            yield report, heard_part(frames)


def test_sink_receives_every_sample_in_real_time(sink):
    what = asked(2, "pulse", 1.0, lead_s=0.3, tail_s=0.3, latency_s=0.1)
    assert any(np.array_equal(frames, player.frames(what)) for _, frames in runs(sink, what))


def test_stop_reaches_the_sink_within_a_block(sink):
    what, as_given = asked(2, "pulse", 20.0, lead_s=0.3, tail_s=0.3, stop_s=0.3, latency_s=0.3), []
    for report, frames in runs(sink, what):
        assert len(frames) <= int(report.split("stopped ")[1].split()[0]) + 2 * 240
        as_given.append(np.array_equal(frames[:-48], player.frames(what)[: len(frames) - 48]))
        if as_given[-1]:
            break
    assert any(as_given)


def killed(sink, what):
    """Kill a playing process. Return delivered and recorded frames."""
    with subprocess.Popen([*PROGRAM, json.dumps(what)], env=sink.env, stdout=subprocess.PIPE) as process:
        n_given = 0
        while n_given < 24_000:
            n_given = int(process.stdout.readline())
        process.send_signal(signal.SIGKILL)
        last = process.stdout.read().split()
    return int(last[-1]) if last else n_given, sink.end()


def test_killed_process_falls_silent(sink):
    """The sink records only delivered frames, in one of four attempts."""
    what, as_given = asked(2, "pulse", 20.0, lead_s=0.3, tell=True), []
    while not any(as_given) and len(as_given) < 4:
        sink.begin()
        n_given, frames = killed(sink, what)
        assert not frames[-4800:].any()
        heard = heard_part(frames) if frames.any() else frames
        is_given = np.array_equal(heard, player.frames(what)[: len(heard)])
        as_given.append(heard.any() and is_given and len(heard) <= n_given + 2 * 240)
    assert as_given[-1]


HANGING = """
import sys, time
import player
output = player.settings({"rate_hz": 48000.0, "n_channels": 2, "device": "pulse"}).driver(player.GAIN)
output.open()
output.play(player.noise(2, 48000.0, 20.0))
print("plays", flush=True)
sys.stdin.readline()
begin_s = time.perf_counter()
output.stop()
print(time.perf_counter() - begin_s, flush=True)
try:
    output.close()
except Exception as error:
    print(error, flush=True)
"""


def test_process_ends_when_sound_server_hangs(sink):
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL, "text": True}
    env = {**sink.env, "PYTHONPATH": str(Path(player.__file__).parent)}
    with subprocess.Popen([sys.executable, "-c", HANGING], env=env, **pipes) as process:
        assert process.stdout.readline() == "plays\n"
        sink.server.send_signal(signal.SIGSTOP)
        try:
            said, _ = process.communicate("go\n", timeout=LONGEST_WAIT_S)
        finally:
            sink.server.send_signal(signal.SIGCONT)
    stopped_s, closed = said.splitlines()
    assert float(stopped_s) < 0.1
    assert closed == "audio pulse: it hangs and did not end within 2 s: switch its amplifier off"
    assert process.returncode == 0


def held_up_process(sink, for_s):
    """Suspend a playing process. Return recorded frames and underruns."""
    what = asked(2, "pulse", 2.0, lead_s=0.3, tail_s=1.0, tell=True)
    sink.begin()
    with subprocess.Popen([*PROGRAM, json.dumps(what)], env=sink.env, stdout=subprocess.PIPE) as process:
        while int(process.stdout.readline()) < 14_400:
            pass
        process.send_signal(signal.SIGSTOP)
        time.sleep(for_s)
        process.send_signal(signal.SIGCONT)
        report, _ = process.communicate(timeout=LONGEST_PROGRAM_S)
    return heard_part(sink.end()), json.loads(re.search(rb"\{.*?\}", report)[0])["n_underruns"]


def test_suspended_process_reports_underruns_and_plays_nothing_more(sink):
    """A busy computer may suspend it late, hence three attempts."""

    def is_cut():
        heard, n_underruns = held_up_process(sink, for_s=1.0)
        return 0 < len(heard) < 0.7 * 48_000 and n_underruns >= 1

    assert any(is_cut() for _ in range(3))


@st.composite
def feeds(draw):
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    frames = rng.uniform(-1.0, 1.0, (draw(st.integers(1, 300)), 1))
    sizes = draw(st.lists(st.integers(1, 64), min_size=1, max_size=60))
    return frames, draw(st.integers(1, 100)), sizes, draw(st.integers(0, len(sizes)))


@given(feeds())
def test_stop_fades_over_stated_frames_at_any_blocksize(feed_of):
    frames, n_fade, sizes, stops_before = feed_of
    feed, emitted = FrameFeed(frames, n_fade), []
    for number, size in enumerate([*sizes, *[400] * 2]):
        if number == stops_before:
            feed.stop()
        emitted.extend(feed.take(size)[:, 0].tolist())
    begin = min(sum(sizes[:stops_before]), len(frames))
    fall = np.clip(1 - (np.arange(len(frames)) - begin) / n_fade, 0.0, 1.0)
    expected = frames[:, 0] * np.where(np.arange(len(frames)) < begin, 1.0, fall)
    assert emitted == pytest.approx(expected[: begin + n_fade].tolist(), abs=1e-12)
    assert feed.finished


class HeldUpClock:
    """Clock of a process that is suspended once."""

    now_s = 100.0

    def __call__(self):
        return self.now_s


@given(feeds(), st.integers(0, 60), st.floats(0.0, 5.0))
def test_feed_emits_no_frame_later_than_allowed(feed_of, held_up_before, held_up_s):
    frames, n_fade, sizes, _ = feed_of
    clock, rate_hz, lead_s, allowed_s = HeldUpClock(), 1000.0, 0.05, 1e-3
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(frame_feed, "boot_clock_s", clock)
        feed, at = FrameFeed(frames, n_fade), 0
        feed.begin(0.0, lead_s)
        onset_s = clock.now_s + lead_s
        for number, size in enumerate(sizes):
            clock.now_s += held_up_s if number == held_up_before else 0.0
            feed.give_up_if_late(rate_hz, allowed_s)
            n_taken = len(feed.take(size))
            assert not n_taken or clock.now_s <= onset_s + at / rate_hz + allowed_s + 1e-9
            at, clock.now_s = at + n_taken, clock.now_s + size / rate_hz
    assert feed.n_gaps == (at < min(sum(sizes), len(frames)))


def test_feed_plays_nothing_when_device_asks_too_late(monkeypatch):
    clock = HeldUpClock()
    monkeypatch.setattr(frame_feed, "boot_clock_s", clock)
    feed = FrameFeed(np.ones((1000, 1)), n_fade=48)
    clock.now_s += 0.2
    feed.begin(0.0, 0.05)
    assert (len(feed.take(240)), feed.n_gaps, feed.finished) == (0, 1, True)
