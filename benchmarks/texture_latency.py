"""Measure the delay from a finger's position to the voltage of a texture.

The measurement uses a session, a UDP sensor with 1 kHz and a sound server.

Each combination of output latency and block size is a whole session in this process. The results are the delay from the
finger crossing an edge of a square grating to the emitted edge (by the card's time of its frame), and the share of a
core. Requires PulseAudio and the extra audio.
"""

import contextlib
import io
import os
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from tactometry.devices.outputs.audio import AudioOutput
from tactometry.devices.outputs.frame_feed import FollowingFeed
from tactometry.devices.sensors import udp
from tactometry.experiments.bench.bench_file import load_bench
from tactometry.experiments.harness import tell
from tactometry.experiments.sessions.recording import Who, record
from tactometry.experiments.sessions.rig_kinds import rig_kind
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.study_file import parse

sys.path[:0] = [str(Path(__file__).resolve().parents[1] / "tests" / "support")]

SETTINGS = {"50 ms, 5 ms": (0.05, 0.005), "20 ms, 5 ms": (0.02, 0.005), "10 ms, 2 ms": (0.01, 0.002)}
N_TOUCHES, RATE_HZ, EDGE_M, LEAST, SPEED_M_PER_S = 8, 48_000.0, 1e-3, 0.3, 0.05


class Taken:
    """Time zero of the emulator's samples, which are sent at 1 kHz of the common clock."""

    def __init__(self) -> None:
        self._records, self.zero_s = udp.records, 0.0
        udp.records = self.noting

    def noting(self, datagram: bytes) -> Any:
        received = self._records(datagram)
        if received:
            n, due_us = received[-1][3][:2]
            now_s = time.perf_counter()
            age_s = (now_s - due_us * 1e-6 + 2**30 * 1e-6) % (2**31 * 1e-6) - 2**30 * 1e-6
            self.zero_s = now_s - age_s - n / 1000
        return received

    def end(self) -> None:
        udp.records = self._records


def edges_s(part: np.ndarray, strongest: np.ndarray, onset_s: float) -> np.ndarray:
    """Return the times at which a carrier's relative amplitude crosses one half, where the carrier is large enough."""
    clear = np.flatnonzero(np.abs(strongest) > LEAST * np.abs(strongest).max())
    values = part[clear] - 0.5
    at = np.flatnonzero(np.diff(np.sign(values)))
    share = values[at] / (values[at] - values[at + 1])
    return onset_s + (clear[at] + share * (clear[at + 1] - clear[at])) / RATE_HZ


def latencies_s(feed: Any, rise_s: float, zero_s: float) -> np.ndarray:
    """Return the delay of each emitted edge after the nearest edge of the grating."""
    emitted = feed.frames()[:, 0].astype(float)
    strongest = feed._frames[: len(emitted), 0].astype(float)
    part = np.divide(emitted, strongest, out=np.zeros(len(emitted)), where=strongest != 0)
    answered_s = edges_s(part, strongest, feed.onset_s)
    crossed_s = answered_s - feed.latency_s - rise_s / 2
    nearest_s = np.round((crossed_s - zero_s) * SPEED_M_PER_S / EDGE_M) * EDGE_M / SPEED_M_PER_S + zero_s
    return answered_s - rise_s / 2 - nearest_s


def session(folder: Path, latency_s: float, block_s: float) -> tuple[np.ndarray, float]:
    """Record a session, and return the delays of its edges and its share of a core."""
    import texture_bench
    from emulated import Emulator

    folder.mkdir()
    text = texture_bench.texture_study(folder, {}).read_text()
    text = text.replace('"500 ms"', '"1 s"').replace("repeats = 2", f"repeats = {N_TOUCHES}")
    device = Emulator("udp", folder, profile=texture_bench.RELEASED)
    path = texture_bench.texture_bench(folder, device.udp_port, more=f"block_s = {block_s}")
    path.write_text(path.read_text().replace("latency_s = 0.02", f"latency_s = {latency_s}"))
    bench, experiment, who = load_bench(path), wire(parse(text.encode(), "study"), "study"), Who("P01")
    (stimulus,) = experiment.bank.values()
    taken, played_path = Taken(), AudioOutput.played_path
    feeds: dict[int, tuple[Any, float]] = {}

    def noting(self: Any) -> Any:
        if isinstance(self._feed, FollowingFeed) and id(self._feed) not in feeds:
            self._feed.ended.wait(2)
            feeds[id(self._feed)] = self._feed, taken.zero_s
        return played_path(self)

    AudioOutput.played_path = noting
    sys.stdin = io.StringIO("1\n" * 100)
    begin_s, begin_cpu_s = time.perf_counter(), time.process_time()
    try:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            record(experiment, text.encode(), folder / "d", who, rig_kind("console", experiment, who, bench))
        share = (time.process_time() - begin_cpu_s) / (time.perf_counter() - begin_s)
    finally:
        AudioOutput.played_path = played_path
        taken.end()
        device.close()
    return np.concatenate([latencies_s(feed, stimulus.rise_s, zero_s) for feed, zero_s in feeds.values()]), share


def main() -> None:
    from sound_server import Sink, alsa_in

    with tempfile.TemporaryDirectory() as folder:
        sink = Sink(Path(folder), alsa_in(Path(folder)))
        os.environ.update(sink.env)
        try:
            for n, (name, (latency_s, block_s)) in enumerate(SETTINGS.items()):
                late_s, share = session(Path(folder) / str(n), latency_s, block_s)
                print(f"{name}: median {1e3 * np.median(late_s):.2f} ms, at most {1e3 * late_s.max():.2f} ms")
                tell(f"{name}: of a core, the whole session", 100 * share, "%", at_most=30)
                late_ms = 1e3 * np.quantile(late_s, 0.99)
                tell(f"{name}: place to voltage, 99th percentile by the clock", late_ms, "ms")
        finally:
            sink.close()


if __name__ == "__main__":
    main()
