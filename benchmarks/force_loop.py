"""From a force sensor in another process to the decision, while a window draws at 60 Hz, idle or busy 8 ms a frame.

Printed for each way in (serial line, LSL, UDP), in one run:

- arrival: from the moment at which the source took a sample to the reader's thread (p50, p99, max);
- decision: from the moment at which the source took the sample that opens the gate to the decision in the reader's
  thread, by the same `AppliedForce` and `Trigger` that a touch has (p50, p99, max); the limit is 10 ms at p99;
- frame: the same for a decision that the drawing loop takes once a frame from all samples, as it was before;
- peer: the same for PsychoPy's usual way of reading the newest sample in each frame;
- samples lost, decisions too early by the source's own samples, and frames that were dropped.

Needs a display, or Xvfb, and the extras window, serial and lsl.
"""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from measured import tell

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "support"))

LISTENED_S = 20.0
SETTLING_S = 4.0
PROFILE = "0.05:30,0.25:100"
HOLD_S = 0.2


def with_display():
    """A DISPLAY: the one that is there, or that of a virtual server which ends with this process."""
    if "DISPLAY" in os.environ:
        return
    read_end, write_end = os.pipe()
    command = ["setpriv", "--pdeathsig", "KILL", "Xvfb", "-displayfd", str(write_end), "-screen", "0", "1280x800x24"]
    subprocess.Popen(command, pass_fds=[write_end], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    os.close(write_end)
    with os.fdopen(read_end) as answer:
        os.environ["DISPLAY"] = f":{answer.readline().strip()}"


class Gated:
    """Notes in the reader's thread when each sample came and when a gate on them fired, each opening anew."""

    def __init__(self, reader):
        self.late_s, self.counters, self.decisions_s, self.n_early = [], [], [], 0
        self._taken_s = self._since_s = 0.0
        self._arm()
        reader.subscribe(self._hear)

    def _arm(self):
        from tactometry.gates import ForceGate
        from tactometry.rigs.touch.gated_samples import AppliedForce
        from tactometry.rigs.touch.trigger import Trigger

        self.grip = AppliedForce(ForceGate(1.0, 0.2, HOLD_S))
        self.trigger = Trigger(lambda: self.grip.open, lambda: not self.grip.open, self._fire, self._arm)

    def _fire(self):
        now_s = time.perf_counter()
        self.decisions_s.append(now_s - self._since_s - HOLD_S)
        self.n_early += now_s < self._since_s + HOLD_S
        return now_s

    def _hear(self, block):
        now_s = time.perf_counter()
        late_s = age_s(now_s, block.values[:, 1])
        for taken_s, counts in zip((now_s - late_s).tolist(), block.values[:, 2].tolist(), strict=True):
            held = abs(0.01 * counts - 1.0) <= 0.2
            self._since_s = (
                (self._since_s if self._held and taken_s - self._taken_s < 0.02 else taken_s) if held else 0.0
            )
            self._held, self._taken_s = held, taken_s
        self.late_s += late_s.tolist()
        self.counters += block.values[:, 0].tolist()
        self.grip.on_samples(block.times_s, 0.01 * block.values[:, 2])
        self.trigger.consider()

    _held = False

    def begin(self):
        """Forget what came up to now: what had waited for the reader to open is no measure of it."""
        for each in (self.late_s, self.counters, self.decisions_s):
            each.clear()


def age_s(now_s, taken_us):
    """How old samples are whose times are microseconds modulo 2**31 of the clock that all processes share."""
    return (now_s - taken_us * 1e-6 + 2**30 * 1e-6) % (2**31 * 1e-6) - 2**30 * 1e-6


def busy(work_s):
    end_s = time.perf_counter() + work_s
    while time.perf_counter() < end_s:
        sum(range(50))


def drawn(window, page, listener, work_s):
    """How late a drawing loop knows of each opening: by every sample, and by the newest of a frame alone."""
    from tactometry.gates import ForceGate

    gate = newest = ForceGate(1.0, 0.2, HOLD_S)
    every, peer, opened_s, end_s = [], [], None, time.perf_counter() + LISTENED_S
    window.present(page)
    window.frame_intervals_s()
    while time.perf_counter() < end_s:
        busy(work_s)
        window.refresh(page)
        block = listener.read()
        now_s = time.perf_counter()
        for taken_s, counts in zip(now_s - age_s(now_s, block.values[:, 1]), block.values[:, 2], strict=True):
            was, gate = gate.open, gate.after(float(taken_s), 0.01 * counts)
            if gate.open and not was:
                opened_s = gate.since_s + HOLD_S
                every.append(now_s - opened_s)
        if block.times_s.size:
            was, newest = newest.open, newest.after(now_s, 0.01 * block.values[-1, 2])
            if newest.open and not was and opened_s is not None:
                peer.append(now_s - opened_s)
    return every, peer, window.frame_intervals_s()


def shown(values_s):
    quantiles = 1e3 * np.quantile(values_s, [0.5, 0.99, 1.0]) if len(values_s) else [np.nan] * 3
    return " ".join(f"{value:7.2f}" for value in quantiles)


def main():
    with_display()
    from emulated import Emulator

    from tactometry.rigs.frame_timing import timing_of
    from tactometry.rigs.pages.layout import marker_page
    from tactometry.rigs.touch.trigger import quick_turns
    from tactometry.rigs.window import Window

    window = Window(fullscreen=False, size=(1280, 800))
    page = marker_page(None, playing=True)
    columns = ("arrival", "decision in the thread", "decision by frame", "peer: newest sample")
    print(f"ms (p50, p99, max){'':<4}" + "".join(f"{name:<26}" for name in columns) + "lost, early, dropped")
    for kind in sys.argv[1:] or ("serial", "lsl", "udp"):
        for work_s in (0.0, 0.008):
            with tempfile.TemporaryDirectory() as folder:
                device = Emulator(kind, Path(folder), profile=PROFILE)
                gated, listener = Gated(device.reader), device.reader.listen()
                device.reader.open()
                time.sleep(SETTLING_S)
                gated.begin()
                listener.read()
                with quick_turns():
                    every, peer, intervals_s = drawn(window, page, listener, work_s)
                device.close()
            lost, n = int(np.sum(np.diff(gated.counters) - 1)), len(gated.counters)
            dropped = timing_of(intervals_s, window.period_s)["n_dropped_frames"]
            figures = "  ".join(shown(each) for each in (gated.late_s, gated.decisions_s, every, peer))
            name = f"{kind}, busy {1e3 * work_s:.0f} ms"
            print(f"{name:<18}{figures}  {lost} of {n}, {gated.n_early}, {dropped} of {len(intervals_s)}")
            late_ms = 1e3 * float(np.quantile(gated.decisions_s, 0.99)) if gated.decisions_s else np.nan
            tell(f"{name}: decision, 99th percentile by the clock", late_ms, "ms", at_most=10)
            tell(f"{name}: samples lost and decisions too early", lost + gated.n_early, "of all", at_most=0)
            if peer and gated.decisions_s:
                late = float(np.median(peer) / np.median(gated.decisions_s))
                tell(f"{name}: newest sample in each frame over ours, medians", late)
    window.close()


if __name__ == "__main__":
    main()
