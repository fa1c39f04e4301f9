"""Compare recorded onsets of touches with the monitor of a real sound server.

A console requests `N_TOUCHES` touches, played through the guard, PortAudio and PulseAudio. The sink's monitor is
recorded with the session's clock, and again by another process, sample by sample. Touches with gaps on the monitor must
not be recorded as free of gaps. Requires PulseAudio and the extra audio.
"""

import io
import os
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from tactometry.devices.outputs.guarded import Guarded
from tactometry.experiments.harness import tell
from tactometry.rigs.console import Console
from tactometry.rigs.device_rig import Equipment
from tactometry.rigs.texts import texts_in
from tactometry.safety.limits import Limits
from tactometry.safety.load import Load
from tactometry.session.request import Press
from tactometry.signal import Signal

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "support"))

N_TOUCHES, DURATION_S, PAUSE_S, RATE_HZ = 100, 0.3, 0.4, 48_000
WITHIN_S, ROUNDING = 0.01, 3 / 32768
GATE = {"target_n": 1.0, "tolerance": 0.2, "hold_s": PAUSE_S, "timeout_s": 30.0}


class Monitor:
    """Recorder of the sink's samples, with times of `time.perf_counter`."""

    def __init__(self) -> None:
        import sounddevice

        self._blocks: list[np.ndarray] = []
        self._times_s: list[float] = []
        format_of_stream = {"channels": 2, "samplerate": RATE_HZ, "dtype": "int16", "blocksize": 240, "latency": 0.02}
        self._stream = sounddevice.InputStream(device="monitor", callback=self._hear, **format_of_stream)
        self._stream.start()

    def _hear(self, frames: np.ndarray, n_frames: int, times: Any, status: Any) -> None:
        del n_frames, status
        self._times_s.append(time.perf_counter() + times.inputBufferAdcTime - times.currentTime)
        self._blocks.append(frames[:, 0].copy())

    def end(self) -> tuple[np.ndarray, np.ndarray]:
        """Return samples and times. The clock offset is the median over ten seconds around each block."""
        self._stream.stop()
        lengths = [len(block) for block in self._blocks]
        offsets_s = np.array(self._times_s) - np.cumsum([0, *lengths])[:-1] / RATE_HZ
        n = int(5.0 * RATE_HZ / 240)
        smooth_s = [np.median(offsets_s[max(0, k - n) : k + n]) for k in range(len(offsets_s))]
        samples = np.concatenate(self._blocks)
        return samples, np.arange(len(samples)) / RATE_HZ + np.repeat(smooth_s, lengths)


class Noise:
    """Stimulus with different non-zero samples for each level."""

    level_unit = "V"

    def at(self, level: float) -> Signal:
        rng, n_samples = np.random.default_rng(round(level)), round(DURATION_S * RATE_HZ)
        return Signal(rng.uniform(1.0, 49.0, (1, n_samples)) * rng.choice([-1.0, 1.0], n_samples), RATE_HZ, "V")


def console(output: Any) -> Console:
    limits = Limits(200.0, duration_s=1.0, current_peak_a=100.0, duty=1.0, session_s=3600.0, stop_within_s=0.2)
    equipment = Equipment(Guarded(output, limits, Load("electrode", 1e-9)), {"noise": Noise()}, limits, ramp_s=0.0)
    return Console(equipment, texts_in("en", {}), io.StringIO(), io.StringIO())


def touches(rig: Console) -> Iterator[tuple[float, int]]:
    """Yield the recorded onset (`time.perf_counter`) and number of gaps of each touch."""
    for n in range(N_TOUCHES):
        touched = rig.answer(Press("noise", float(n), DURATION_S, **GATE))
        yield touched.onset_s + rig._supervisor.zero_s, touched.n_gaps


def first_heard_s(samples: np.ndarray, times_s: np.ndarray, onset_s: float) -> float:
    """Return the time of the first sample after the silence before a touch."""
    begin = int(np.searchsorted(times_s, onset_s - PAUSE_S / 2))
    return times_s[begin + int(np.argmax(samples[begin:] != 0))]


def is_in(samples: np.ndarray, wanted: np.ndarray) -> bool:
    """Return True if a record contains all of `wanted`, within the rounding to 16 bits."""
    begins = np.flatnonzero((np.abs(samples[: -len(wanted)] - wanted[0]) < ROUNDING) & (samples[: -len(wanted)] != 0))
    return any(np.abs(samples[begin : begin + len(wanted)] - wanted).max() < ROUNDING for begin in begins)


def main() -> None:
    from player import GAIN, settings
    from sound_server import Sink, alsa_in

    with tempfile.TemporaryDirectory() as folder:
        sink = Sink(Path(folder), alsa_in(Path(folder)))
        os.environ.update(sink.env)
        try:
            options = {"rate_hz": RATE_HZ, "n_channels": 1, "device": "pulse", "latency_s": 0.1}
            output = settings(options).driver(GAIN)
            rig, monitor = console(output), Monitor()
            time.sleep(1.0)
            sink.begin()
            recorded = list(touches(rig))
            frames = sink.end()[:, 0] / 32768
            rig.close()
            samples, times_s = monitor.end()
        finally:
            sink.close()
    noises = (output.final(Noise().at(n)).samples[0] / GAIN.load_volts_per_unit for n in range(N_TOUCHES))
    is_whole = np.array([is_in(frames, each) for each in noises])
    is_told_whole = np.array([not n_gaps for _, n_gaps in recorded])
    late_s = np.array([first_heard_s(samples, times_s, onset_s) - onset_s for onset_s, _ in recorded])[is_told_whole]
    share = np.mean(np.abs(late_s - np.median(late_s)) <= WITHIN_S)
    n_torn = int(np.sum(~is_whole & is_told_whole))
    print(
        f"{len(late_s)} of {N_TOUCHES} touches without a gap; heard {1e3 * np.median(late_s):.1f} ms after their record"
    )
    tell("touches heard within 10 ms of what is recorded", 100 * share, "%", at_least=99)
    tell("touches that were heard torn and told to be whole", n_torn, "touches", at_most=0)


if __name__ == "__main__":
    main()
