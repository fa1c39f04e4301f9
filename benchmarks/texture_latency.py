"""From the place of a finger to the voltage that answers it: a session, a UDP sensor of 1 kHz, a sound server.

Printed for some settings of the output, each a whole session in one run, in this process alone:

- stated: what the output says that the latency is, ms;
- measured: from the moment at which the finger crossed an edge of a square grating, by the clock that all processes
  share, to the edge that was emitted, by the card's time of its frame (p50, p99, max of all edges), ms;
- late: the part of the samples whose position had not come when they were needed;
- heard: touches whose samples the sink heard as they were emitted, of all (those with a gap are asked again);
- processor: time of the processor over that of the wall, of the whole session with its opening, in per cent of a core.

The clocks' relation and the card's own time of a frame are in all of it. Needs PulseAudio and the extra audio.
"""

import contextlib
import io
import os
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from measured import tell

sys.path[:0] = [str(Path(__file__).resolve().parents[1] / "tests" / "support")]

N_TOUCHES = 8
SETTINGS = {"50 ms, 5 ms": (0.05, 0.005), "20 ms, 5 ms": (0.02, 0.005), "10 ms, 2 ms": (0.01, 0.002)}
RATE_HZ, EDGE_M, LEAST = 48_000.0, 1e-3, 0.3
LINE = "{:<14}{:>8}{:>26}{:>10}{:>8}{:>12}"


class Taken:
    """When the emulator took its samples, by the clock that all processes share: it counts a thousand a second."""

    def __init__(self):
        from tactometry.devices.sensors import udp

        self._records, self._udp = udp.records, udp
        self.zero_s = 0.0
        udp.records = self.noting

    def noting(self, datagram):
        received = self._records(datagram)
        if received:
            n, due_us = received[-1][3][:2]
            now_s = time.perf_counter()
            age_s = (now_s - due_us * 1e-6 + 2**30 * 1e-6) % (2**31 * 1e-6) - 2**30 * 1e-6
            self.zero_s = now_s - age_s - n / 1000
        return received

    def end(self):
        self._udp.records = self._records


def edges_s(part, strongest, onset_s):
    """When the part (0..1) of a carrier passes a half, where the carrier is large enough to tell."""
    clear = np.flatnonzero(np.abs(strongest) > LEAST * np.abs(strongest).max())
    values = part[clear] - 0.5
    at = np.flatnonzero(np.diff(np.sign(values)))
    share = values[at] / (values[at] - values[at + 1])
    return onset_s + (clear[at] + share * (clear[at + 1] - clear[at])) / RATE_HZ


def latencies_s(feed, stimulus, speed_m_per_s, zero_s):
    """Of each edge that was emitted."""
    emitted = feed.frames()[:, 0].astype(float)
    strongest = feed._frames[: len(emitted), 0].astype(float)
    part = np.divide(emitted, strongest, out=np.zeros(len(emitted)), where=strongest != 0)
    answered_s = edges_s(part, strongest, feed.onset_s)
    crossed_s = answered_s - feed.latency_s - stimulus.rise_s / 2  # about: to the nearest edge of the grating
    nearest = np.round((crossed_s - zero_s) * speed_m_per_s / EDGE_M) * EDGE_M / speed_m_per_s + zero_s
    return answered_s - stimulus.rise_s / 2 - nearest


def measured(folder, sink, latency_s, block_s):
    import texture_bench
    from emulated import Emulator

    from tactometry.devices.outputs.audio import AudioOutput
    from tactometry.devices.outputs.frame_feed import FollowingFeed
    from tactometry.experiments.bench.bench_file import load_bench
    from tactometry.experiments.sessions.recording import Who, record
    from tactometry.experiments.sessions.rig_kinds import rig_kind
    from tactometry.experiments.study.experiment import wire
    from tactometry.experiments.study.study_file import parse

    folder.mkdir()
    changes = {'"500 ms"': '"1 s"', "repeats = 2": f"repeats = {N_TOUCHES}"}
    study = texture_bench.texture_study(folder, {})
    text = study.read_text()
    for old, new in changes.items():
        text = text.replace(old, new)
    device, taken, feeds = Emulator("udp", folder, profile=texture_bench.RELEASED), Taken(), []
    more = f"block_s = {block_s}"
    bench = load_bench(_faster(texture_bench.texture_bench(folder, device.udp_port, more=more), latency_s))
    experiment, who = wire(parse(text.encode(), "study"), "study"), Who("P01")
    (stimulus,) = experiment.bank.values()
    course = AudioOutput.course

    def noting(self):
        if isinstance(self._course, FollowingFeed) and self._course not in [feed for feed, _ in feeds]:
            self._course.ended.wait(2)
            feeds.append((self._course, taken.zero_s))
        return course(self)

    AudioOutput.course = noting
    sys.stdin = io.StringIO("1\n" * 100)
    sink.begin()
    begin_s, begin_cpu_s = time.perf_counter(), time.process_time()
    try:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            record(experiment, text.encode(), folder / "d", who, rig_kind("console", experiment, who, bench))
        part = (time.process_time() - begin_cpu_s) / (time.perf_counter() - begin_s)
        frames = sink.end()
    finally:
        AudioOutput.course = course
        taken.end()
        device.close()
    late_s = np.concatenate([latencies_s(feed, stimulus, 0.05, zero_s) for feed, zero_s in feeds])
    heard = texture_bench.stretches(frames)
    n_like = sum(any(_alike(feed, each) for each in heard) for feed, _ in feeds)
    return feeds, late_s, n_like, part


def _faster(path, latency_s):
    path.write_text(path.read_text().replace("latency_s = 0.02", f"latency_s = {latency_s}"))
    return path


def _alike(feed, heard):
    emitted = feed.frames()[:, 0]
    sounding = np.flatnonzero(emitted)
    return np.array_equal(emitted[sounding[0] : sounding[-1] + 1], heard[:, 0])


def main():
    from sound_server import Sink, alsa_in

    with tempfile.TemporaryDirectory() as folder:
        sink = Sink(Path(folder), alsa_in(Path(folder)))
        os.environ.update(sink.env)
        try:
            print(LINE.format("latency, block", "stated", "measured (p50, p99, max)", "late", "heard", "processor"))
            for n, (name, (latency_s, block_s)) in enumerate(SETTINGS.items()):
                feeds, late_s, n_like, part = measured(Path(folder) / str(n), sink, latency_s, block_s)
                stated = f"{1e3 * np.mean([feed.latency_s for feed, _ in feeds]):.1f}"
                quantiles = " ".join(f"{1e3 * value:7.2f}" for value in np.quantile(late_s, [0.5, 0.99, 1.0]))
                late = f"{np.mean([feed.late for feed, _ in feeds]):.4f}"
                print(LINE.format(name, stated, quantiles, late, f"{n_like}/{len(feeds)}", f"{100 * part:.1f} %"))
                tell(f"{name}: of a core, the whole session", 100 * part, "%", at_most=30)
                tell(f"{name}: place to voltage, 99th percentile by the clock", 1e3 * np.quantile(late_s, 0.99), "ms")
        finally:
            sink.close()


if __name__ == "__main__":
    main()
