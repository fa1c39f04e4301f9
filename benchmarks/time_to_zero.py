"""From the loss of a force to silence: a real sound server hears how long a stimulus goes on, in a real window.

Printed for a sensor that falls silent and for a finger that leaves, in one run (median, largest, of `N_TOUCHES`):

- decision: from the stamp of the last sample of a held force to the order to stop;
- zero: from the same stamp to the first zero that leaves the card, by the card's own time of the first frame and the
  number of frames that the sink heard.

The sensor is lost after 100 ms; the output's block and latency come on top. Needs a display or Xvfb, PulseAudio, and
the extras window and audio.
"""

import math
import os
import sys
import tempfile
import threading
from pathlib import Path

import numpy as np
from measured import tell

sys.path[:0] = [str(Path(__file__).resolve().parents[1] / "tests" / "support"), str(Path(__file__).resolve().parent)]

N_TOUCHES = 10
CAUSES = {"the sensor falls silent": None, "its samples are lost": math.nan, "the finger leaves": 0.05}


class Kept:
    """A window for many benches."""

    def __init__(self, window):
        self._window = window

    def __getattr__(self, name):
        return getattr(self._window, name)

    def close(self):
        pass


def touched(window, sink, force_n):
    """(decision, zero) of one touch whose force becomes this, s."""
    import player
    from zero_scene import PRESS, RATE_HZ, Noting, Scene

    from tactometry.devices.sensors.reader import now_s

    class Timed(Scene):
        def felt(self, time_s):
            if self.force_n == 1.0:
                self.held_s = self.source.zero_s + time_s
            return self.force_n

    class Told(Noting):
        told_s = None

        def stop(self):
            self.told_s = self.told_s or now_s()
            super().stop()

    sink.begin()
    driver = Told(player.settings({"rate_hz": RATE_HZ, "n_channels": 2, "device": "pulse"}).driver(player.GAIN))
    scene = Timed(Kept(window), driver, sink)
    ender = threading.Thread(target=scene.when_heard, args=(setattr, scene, "force_n", force_n))
    ender.start()
    scene.bench.answer(PRESS)
    ender.join()
    n_heard, onset_s = scene.heard(), driver._feed.onset_s
    scene.bench.close()
    return driver.told_s - scene.held_s, onset_s + n_heard / RATE_HZ - scene.held_s


def main():
    from force_loop import with_display
    from sound_server import Sink, alsa_in

    from tactometry.rigs.window import Window

    with_display()
    with tempfile.TemporaryDirectory() as folder:
        sink = Sink(Path(folder), alsa_in(Path(folder)))
        os.environ.update(sink.env)
        try:
            window = Window(fullscreen=False, size=(1280, 800))
            print(f"{'ms (median, largest)':<26}{'decision':>18}{'zero':>18}")
            for name, force_n in CAUSES.items():
                took_s = np.array([touched(window, sink, force_n) for _ in range(N_TOUCHES)])
                for what, each in zip(("decided", "silent"), took_s.T, strict=True):
                    tell(f"{name}: {what}, by the clock", [1e3 * one for one in each], "ms")
                columns = (f"{1e3 * np.median(each):9.1f}{1e3 * max(each):9.1f}" for each in took_s.T)
                print(f"{name:<26}" + "".join(columns))
        finally:
            sink.close()


if __name__ == "__main__":
    main()
