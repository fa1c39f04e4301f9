"""Measure the delay from the loss of force to silence of the output.

A real sound server records how long a stimulus continues in a session with a real window.

*decided* is the time from the last sample of a held force to the command to stop. *silent* is the time from that sample
to the first zero that leaves the card. A silent sensor counts as lost after 100 ms. Requires a display or Xvfb,
PulseAudio, and the extras window and audio.
"""

import math
import os
import sys
import tempfile
import threading
from pathlib import Path
from typing import Any

from force_loop import with_display

from tactometry.devices.sensors.reader import now_s
from tactometry.experiments.harness import tell

sys.path[:0] = [str(Path(__file__).resolve().parents[1] / "tests" / "support")]

N_TOUCHES = 10
CAUSES = {"the sensor falls silent": None, "its samples are lost": math.nan, "the finger leaves": 0.05}


class Kept:
    """Window that several benches share."""

    def __init__(self, window: Any) -> None:
        self._window = window

    def __getattr__(self, name: str) -> Any:
        return getattr(self._window, name)

    def close(self) -> None:
        pass


def touched_s(window: Any, sink: Any, force_n: float | None) -> tuple[float, float]:
    """Return the times to decision and silence for a touch whose force changes to a value."""
    import player
    from zero_scene import PRESS, RATE_HZ, Noting, Scene

    class Timed(Scene):
        def felt(self, time_s: float) -> float | None:
            if self.force_n == 1.0:
                self.held_s = self.source.zero_s + time_s
            return self.force_n

    class Told(Noting):
        told_s = None

        def stop(self) -> None:
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


def main() -> None:
    with_display()
    from sound_server import Sink, alsa_in

    from tactometry.rigs.window import Window

    with tempfile.TemporaryDirectory() as folder:
        sink = Sink(Path(folder), alsa_in(Path(folder)))
        os.environ.update(sink.env)
        try:
            window = Window(fullscreen=False, size=(1280, 800))
            for name, force_n in CAUSES.items():
                touches = [touched_s(window, sink, force_n) for _ in range(N_TOUCHES)]
                for what, times_s in zip(("decided", "silent"), zip(*touches, strict=True), strict=True):
                    tell(f"{name}: {what}, by the clock", [1e3 * one for one in times_s], "ms")
        finally:
            sink.close()


if __name__ == "__main__":
    main()
