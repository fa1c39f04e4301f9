"""From a force sensor in another process to the decision, while a window draws at 60 Hz, idle or busy 8 ms a frame.

Printed for each way in (serial line, LSL, UDP), in one run:

- arrival: from the sample's own stamp to the reader's thread, where a gate may decide (p50, p99, max);
- decision: from the sample that opens the gate to the moment at which the drawing loop knows it, once a frame, and the
  same for PsychoPy's usual way of reading the newest sample in each frame, which is the peer (p50, p99);
- samples lost.

Needs a display, or Xvfb, and the extras window, serial and lsl.
"""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

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


class Arrivals:
    """A listener that notes when each block came, in the reader's thread."""

    def __init__(self, reader):
        self.listener = reader.listen()
        self.late_s, self.counters = [], []
        put = self.listener.put

        def noted(block):
            now_s = time.perf_counter()
            taken_s = block.values[:, 1] * 1e-6
            self.late_s += ((now_s - taken_s + 2**30 * 1e-6) % (2**31 * 1e-6) - 2**30 * 1e-6).tolist()
            self.counters += block.values[:, 0].tolist()
            put(block)

        self.listener.put = noted

    def begin(self):
        """Forget what came up to now: what had waited for the reader to open is no measure of it."""
        self.listener.read(3)
        self.late_s.clear()
        self.counters.clear()


def busy(work_s):
    end_s = time.perf_counter() + work_s
    while time.perf_counter() < end_s:
        sum(range(50))


def decisions_s(window, page, listener, work_s):
    """How late the drawing loop knew of each opening: by every sample, and by the newest of a frame alone."""
    from tactometry.force_gate import ForceGate

    gate = newest = ForceGate(1.0, 0.2, HOLD_S)
    every, peer, end_s = [], [], time.perf_counter() + LISTENED_S
    while time.perf_counter() < end_s:
        busy(work_s)
        window.refresh(page)
        block = listener.read(3)
        now_s = time.perf_counter()
        for time_s, counts in zip(block.times_s.tolist(), block.values[:, 2].tolist(), strict=True):
            was, gate = gate.open, gate.after(time_s, 0.01 * counts)
            if gate.open and not was:
                every.append(now_s - time_s)
                opened_s = time_s
        if block.times_s.size:
            was, newest = newest.open, newest.after(now_s, 0.01 * block.values[-1, 2])
            if newest.open and not was and every:
                peer.append(now_s - opened_s)
    return every, peer


def shown(values_s):
    quantiles = 1e3 * np.quantile(values_s, [0.5, 0.99, 1.0]) if len(values_s) else [np.nan] * 3
    return " ".join(f"{value:7.2f}" for value in quantiles)


def main():
    with_display()
    from test_device_sensors import Emulator

    from tactometry.rigs.layout import marker_page
    from tactometry.rigs.window import Window

    window = Window(fullscreen=False, size=(1280, 800))
    page = marker_page(None, playing=True)
    print("ms (p50, p99, max)        arrival in the thread     known to the loop         peer: newest sample      lost")
    for kind in sys.argv[1:] or ("serial", "lsl", "udp"):
        for work_s in (0.0, 0.008):
            with tempfile.TemporaryDirectory() as folder:
                device = Emulator(kind, Path(folder), profile=PROFILE)
                arrivals = Arrivals(device.reader)
                device.reader.open()
                time.sleep(SETTLING_S)
                arrivals.begin()
                every, peer = decisions_s(window, page, arrivals.listener, work_s)
                device.close()
            lost = int(np.sum(np.diff(arrivals.counters) - 1))
            name, n = f"{kind}, busy {1e3 * work_s:.0f} ms", len(arrivals.counters)
            print(f"{name:<18}{shown(arrivals.late_s)}  {shown(every)}  {shown(peer)}  {lost:5d} of {n}")
    window.close()


if __name__ == "__main__":
    main()
