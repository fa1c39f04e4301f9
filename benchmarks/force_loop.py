"""Measure the delay from a force sensor to the gate's decision while a window draws.

The window draws at 60 Hz, and the program is idle or busy for 8 ms per frame.

The results for each connection (serial line, LSL, UDP) are the delay from the sample that opens the gate to the
decision in the reader's thread, lost samples, and early decisions. The decision uses the `AppliedForce` and `Trigger`
of a touch. The delay is compared with reading the newest sample in each frame, as usual with PsychoPy. Requires a
display or Xvfb, and the extras window, serial and lsl.
"""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from tactometry.experiments.harness import tell
from tactometry.gates import ForceGate
from tactometry.rigs.touch.gated_samples import AppliedForce
from tactometry.rigs.touch.trigger import Trigger, quick_turns

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "support"))

LISTENED_S, SETTLING_S, HOLD_S = 20.0, 4.0, 0.2
PROFILE = "0.05:30,0.25:100"


def with_display() -> None:
    """Set DISPLAY, if not set, to a virtual server that ends with this process."""
    if "DISPLAY" in os.environ:
        return
    read_end, write_end = os.pipe()
    command = ["setpriv", "--pdeathsig", "KILL", "Xvfb", "-displayfd", str(write_end), "-screen", "0", "1280x800x24"]
    subprocess.Popen(command, pass_fds=[write_end], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    os.close(write_end)
    with os.fdopen(read_end) as answer:
        os.environ["DISPLAY"] = f":{answer.readline().strip()}"


class Gated:
    """Recorder of a gate's decisions in the reader's thread. A new gate follows each opening."""

    def __init__(self, reader: Any) -> None:
        self.counters: list[float] = []
        self.decisions_s: list[float] = []
        self.n_early = 0
        self._taken_s = self._since_s = 0.0
        self._held = False
        self._arm()
        reader.subscribe(self._hear)

    def _arm(self) -> None:
        self.grip = AppliedForce(ForceGate(1.0, 0.2, HOLD_S))
        self.trigger = Trigger(lambda: self.grip.open, lambda: not self.grip.open, self._fire, self._arm)

    def _fire(self) -> float:
        now_s = time.perf_counter()
        self.decisions_s.append(now_s - self._since_s - HOLD_S)
        self.n_early += now_s < self._since_s + HOLD_S
        return now_s

    def _hear(self, block: Any) -> None:
        now_s = time.perf_counter()
        taken_s = now_s - age_s(now_s, block.values[:, 1])
        for at_s, counts in zip(taken_s.tolist(), block.values[:, 2].tolist(), strict=True):
            held, goes_on = abs(0.01 * counts - 1.0) <= 0.2, self._held and at_s - self._taken_s < 0.02
            if not (held and goes_on):
                self._since_s = at_s if held else 0.0
            self._held, self._taken_s = held, at_s
        self.counters += block.values[:, 0].tolist()
        self.grip.on_samples(block.times_s, 0.01 * block.values[:, 2])
        self.trigger.consider()


def age_s(now_s: float, taken_us: np.ndarray) -> np.ndarray:
    """Return the age of samples. Their times are those of the common clock in microseconds, modulo 2**31."""
    return (now_s - taken_us * 1e-6 + 2**30 * 1e-6) % (2**31 * 1e-6) - 2**30 * 1e-6


def peer_delays_s(window: Any, page: Any, listener: Any, work_s: float) -> list[float]:
    """Draw for a while, and return the delays of decisions from the newest sample of each frame."""
    every = newest = ForceGate(1.0, 0.2, HOLD_S)
    delays_s, opened_s, end_s = [], None, time.perf_counter() + LISTENED_S
    window.present(page)
    while time.perf_counter() < end_s:
        busy_s = time.perf_counter() + work_s
        while time.perf_counter() < busy_s:
            sum(range(50))
        window.refresh(page)
        block, now_s = listener.read(), time.perf_counter()
        for taken_s, counts in zip(now_s - age_s(now_s, block.values[:, 1]), block.values[:, 2], strict=True):
            was, every = every.open, every.after(float(taken_s), 0.01 * counts)
            if every.open and not was:
                opened_s = every.since_s + HOLD_S
        if block.times_s.size:
            was, newest = newest.open, newest.after(now_s, 0.01 * block.values[-1, 2])
            if newest.open and not was and opened_s is not None:
                delays_s.append(now_s - opened_s)
    return delays_s


def main() -> None:
    with_display()
    from emulated import Emulator

    from tactometry.rigs.pages.layout import marker_page
    from tactometry.rigs.window import Window

    window, page = Window(fullscreen=False, size=(1280, 800)), marker_page(None, playing=True)
    for kind in sys.argv[1:] or ("serial", "lsl", "udp"):
        for work_s in (0.0, 0.008):
            with tempfile.TemporaryDirectory() as folder:
                device = Emulator(kind, Path(folder), profile=PROFILE)
                gated, listener = Gated(device.reader), device.reader.listen()
                device.reader.open()
                time.sleep(SETTLING_S)
                gated.counters.clear()
                gated.decisions_s.clear()
                listener.read()
                with quick_turns():
                    peer_s = peer_delays_s(window, page, listener, work_s)
                device.close()
            lost = int(np.sum(np.diff(gated.counters) - 1))
            name = f"{kind}, busy {1e3 * work_s:.0f} ms"
            late_ms = 1e3 * float(np.quantile(gated.decisions_s, 0.99)) if gated.decisions_s else np.nan
            tell(f"{name}: decision, 99th percentile by the clock", late_ms, "ms", at_most=10)
            tell(f"{name}: samples lost and decisions too early", lost + gated.n_early, "of all", at_most=0)
            if peer_s and gated.decisions_s:
                ratio = float(np.median(peer_s) / np.median(gated.decisions_s))
                tell(f"{name}: newest sample in each frame over ours, medians", ratio)
    window.close()


if __name__ == "__main__":
    main()
