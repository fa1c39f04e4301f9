"""What is heard agrees with what is recorded: onsets of touches against the monitor of a real sound server.

A console asks for `N_TOUCHES` touches through the guard, PortAudio and PulseAudio; the sink's monitor is recorded on
the clock of the session, and once more, by a process of its own, sample by sample. Printed, in one run:

- the load of the machine;
- of the touches without a gap: by how much later than recorded each was heard (median, and 1, 5, 95, 99 % about it),
  and the part within 10 ms;
- of all touches: how many were heard torn, how many of these were told to be whole (there must be none), and how many
  were told to be torn and heard whole.

A quiet machine is to have 99 of 100 within 10 ms. Needs PulseAudio and the extra audio.
"""

import io
import os
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from measured import tell

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "support"))

N_TOUCHES = 100
DURATION_S, PAUSE_S, RATE_HZ = 0.3, 0.4, 48_000
WITHIN_S = 0.01
ROUNDING = 3 / 32768


class Monitor:
    """What the sink hears, frame by frame, each with a time on `time.perf_counter`."""

    def __init__(self):
        import sounddevice

        self._blocks, self._times_s = [], []
        asked = {"channels": 2, "samplerate": RATE_HZ, "dtype": "int16", "blocksize": 240, "latency": 0.02}
        self._stream = sounddevice.InputStream(device="monitor", callback=self._hear, **asked)
        self._stream.start()

    def _hear(self, frames, n_frames, times, status):
        del n_frames, status
        self._times_s.append(time.perf_counter() + times.inputBufferAdcTime - times.currentTime)
        self._blocks.append(frames[:, 0].copy())

    def end(self):
        """Samples, and their times by the straight line through those of the blocks of the ten seconds around each."""
        self._stream.stop()
        samples, first = np.concatenate(self._blocks), np.cumsum([0, *map(len, self._blocks)])[:-1]
        offsets_s = np.array(self._times_s) - first / RATE_HZ
        n_around = int(5.0 * RATE_HZ / 240)
        smooth_s = [np.median(offsets_s[max(0, k - n_around) : k + n_around]) for k in range(len(offsets_s))]
        return samples, np.arange(len(samples)) / RATE_HZ + np.repeat(smooth_s, [len(block) for block in self._blocks])


def noise_of(touch):
    """Samples of which none is zero, others for each touch."""
    from tactometry.signal import Signal

    rng = np.random.default_rng(touch)
    n_samples = round(DURATION_S * RATE_HZ)
    return Signal(rng.uniform(1.0, 49.0, (1, n_samples)) * rng.choice([-1.0, 1.0], n_samples), RATE_HZ, "V")


def console(output):
    """A console whose levels are noises."""
    from tactometry.devices.outputs.guarded import Guarded
    from tactometry.rigs.console import Console
    from tactometry.rigs.device_rig import Equipment
    from tactometry.rigs.texts import texts_in
    from tactometry.safety.limits import Limits
    from tactometry.safety.load import Load

    class Noise:
        level_unit = "V"

        def at(self, level):
            return noise_of(round(level))

    limits = Limits(100.0, duration_s=1.0, current_peak_a=100.0, duty=1.0, session_s=3600.0)
    guarded = Guarded(output, limits, Load("electrode", 1e-9))
    return Console(
        Equipment(guarded, {"noise": Noise()}, limits, ramp_s=0.0), texts_in("en", {}), io.StringIO(), io.StringIO()
    )


def touches(rig):
    """Onset on `time.perf_counter` and gaps of each touch, as they are recorded."""
    from tactometry.session.request import Press

    gate = {"target_n": 1.0, "tolerance": 0.2, "hold_s": PAUSE_S, "timeout_s": 30.0}
    for n in range(N_TOUCHES):
        touched = rig.answer(Press("noise", float(n), DURATION_S, **gate))
        yield touched.onset_s + rig._supervisor.zero_s, touched.n_gaps


def first_heard_s(samples, times_s, onset_s):
    """When the first sample was heard after the silence before a touch."""
    begin = int(np.searchsorted(times_s, onset_s - PAUSE_S / 2))
    return times_s[begin + int(np.argmax(samples[begin:] != 0))]


def is_in(samples, wanted):
    """Whether all of `wanted` stands in a record, sample by sample, to the last bits of 16."""
    begins = np.flatnonzero((np.abs(samples[: -len(wanted)] - wanted[0]) < ROUNDING) & (samples[: -len(wanted)] != 0))
    return any(np.abs(samples[begin : begin + len(wanted)] - wanted).max() < ROUNDING for begin in begins)


def report(late_s, whole, told_whole):
    middle_s = np.median(late_s)
    spread = ", ".join(f"{1e3 * each:+.1f}" for each in np.percentile(late_s - middle_s, [1, 5, 95, 99]))
    share = np.mean(np.abs(late_s) <= WITHIN_S)
    print(f"load of the machine: {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
    print(f"{len(late_s)} of {len(whole)} touches without a gap; heard later than recorded by {1e3 * middle_s:.1f} ms")
    print(f"about that {spread} ms (1, 5, 95, 99 %); within 10 ms: {share:.0%}")
    tell("touches heard within 10 ms of what is recorded", 100 * share, "%", at_least=99)
    tell("touches that were heard torn and told to be whole", int(np.sum(~whole & told_whole)), "touches", at_most=0)
    print(f"heard torn: {np.sum(~whole)}, of these told to be whole: {np.sum(~whole & told_whole)}", end="; ")
    print(f"told to be torn and heard whole: {np.sum(whole & ~told_whole)}")


def main():
    from player import GAIN, settings
    from sound_server import Sink, alsa_in

    with tempfile.TemporaryDirectory() as folder:
        sink = Sink(Path(folder), alsa_in(Path(folder)))
        os.environ.update(sink.env)
        try:
            asked = {"rate_hz": RATE_HZ, "n_channels": 1, "device": "pulse", "latency_s": 0.1}
            output = settings(asked).driver(GAIN)
            rig, monitor = console(output), Monitor()
            time.sleep(1.0)
            sink.begin()
            recorded = list(touches(rig))
            frames = sink.end()[:, 0] / 32768
            rig.close()
            samples, times_s = monitor.end()
            noises = (output.final(noise_of(n)).samples[0] / GAIN.load_volts_per_unit for n in range(N_TOUCHES))
            whole = np.array([is_in(frames, each) for each in noises])
            told_whole = np.array([not n_gaps for _, n_gaps in recorded])
            late_s = np.array([first_heard_s(samples, times_s, onset_s) - onset_s for onset_s, _ in recorded])
            report(late_s[told_whole], whole, told_whole)
        finally:
            sink.close()


if __name__ == "__main__":
    main()
