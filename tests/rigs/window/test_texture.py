"""A texture that follows the pointer in a real window."""

import importlib.util
import os
import threading
import time
from contextlib import contextmanager

import pytest
from emulated import Emulator
from hands import SCREEN_PX, Hands
from tables import is_sound
from texture_bench import RELEASED, texture_bench, texture_study, touches_heard_as_asked
from window_sitting import sit, tactometry

from tactometry.devices.sensors.touch_screen import ABSOLUTE, EVENT, SYNC, TRACKING
from tactometry.gates import triangle

METRES_PER_PX, EVERY_S = 2e-4, 0.004
SPEED_M_PER_S, PATH_M = 0.05, 0.1
POSITION = f"""
[sensors.pointer]
kind = "touch"
path = "{{path}}"
rate_hz = {1 / EVERY_S}
[position]
sensor = "pointer"
channels = [0]
metres_per_count = {METRES_PER_PX}
zero_counts = [{SCREEN_PX[0] // 2 - PATH_M / METRES_PER_PX / 2 - 0.5}]
"""
"""The offset keeps pixels off the grating edges, where rounding would decide the side."""


@contextmanager
def sliding_pointer(path):
    """Move the pointer back and forth and write it to a pipe as touch events."""
    os.mkfifo(path)
    line, ended, pointer = os.open(path, os.O_RDWR), threading.Event(), Hands(os.environ["DISPLAY"])
    first_px = (SCREEN_PX[0] - round(PATH_M / METRES_PER_PX)) // 2
    begin_s = time.perf_counter()

    def slide():
        while not ended.wait(EVERY_S):
            place_m = triangle(SPEED_M_PER_S * (time.perf_counter() - begin_s), PATH_M)
            x_px, _ = pointer.point(first_px + round(float(place_m) / METRES_PER_PX), SCREEN_PX[1] // 2)
            told = ((*TRACKING, 1), (ABSOLUTE, 0, x_px), (SYNC, 0, 0))
            os.write(line, b"".join(EVENT.pack(0, 0, *event) for event in told))

    thread = threading.Thread(target=slide, daemon=True)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join(5)
        pointer.close()
        os.close(line)


def numbers():
    """Yield keys that answer 1 to number questions and leave other pages."""
    for _ in range(2000):
        yield from ("space", "1", "Return")


@pytest.mark.slow
@pytest.mark.skipif(importlib.util.find_spec("sounddevice") is None, reason="no sounddevice: extra audio")
def test_window_texture_follows_pointer_positions(display, sink, tmp_path):
    study, device = texture_study(tmp_path), Emulator("udp", tmp_path, profile=RELEASED)
    position = POSITION.format(path=tmp_path / "pointer")
    bench = texture_bench(tmp_path, device.udp_port, position, "position_latency_s = 0.2")
    bench.write_text(bench.read_text().replace("\nlatency_s = 0.02", "\nlatency_s = 0.1"))
    sink.begin()
    run = ("run", study, "--participant", "P01", "--rig", "bench", "--bench", bench, "--out", tmp_path / "d")
    try:
        with sliding_pointer(tmp_path / "pointer"):
            environment = {**sink.env, **{name: os.environ[name] for name in ("DISPLAY", "HOME")}}
            status, output, errors = sit(tactometry(*run, env=environment), display, numbers())
        frames = sink.end()
    finally:
        device.close()
    assert status == 0, (output, errors)
    touched = touches_heard_as_asked(study, tmp_path / "d", frames)
    assert {row["response"] for row in touched if row["valid"] == "1"} == {"1"}
    assert is_sound(tmp_path / "d")
