"""A program that plays noise and prints its progress.

`python player.py JSON`.
"""

import json
import os
import sys
import threading
import time

import numpy as np

from tactometry.devices.outputs.audio import AudioSettings
from tactometry.devices.outputs.gain import Gain
from tactometry.signal import Signal

GAIN = Gain(50.0, 1.0)


def noise(n_channels, rate_hz, duration_s):
    """Return noise without a zero sample."""
    rng = np.random.default_rng(n_channels)
    values = rng.uniform(1.0, 50.0, (n_channels, round(duration_s * rate_hz)))
    return Signal(values * rng.choice([-1.0, 1.0], values.shape), rate_hz, "V")


def settings(asked):
    channels, latency_s = tuple(range(asked["n_channels"])), asked.get("latency_s", 0.05)
    return AudioSettings(asked["rate_hz"], asked["device"], channels, "int16", latency_s=latency_s, shared=True)


def frames(asked):
    """Return the expected frames, (n_frames, n_channels) of 16 bits."""
    output = settings(asked).driver(GAIN)
    signal = noise(asked["n_channels"], asked["rate_hz"], asked["duration_s"])
    return np.round(output.final(signal).samples.T / 50.0 * 32767).astype("<i2")


def tell(course):
    while True:
        os.write(1, f"{course._at}\n".encode())
        time.sleep(0.001)


def main(asked):
    output = settings(asked).driver(GAIN)
    durations_s = [asked["duration_s"], *asked.get("then_s", [])]
    signals = [noise(asked["n_channels"], asked["rate_hz"], duration_s) for duration_s in durations_s]
    output.open()
    time.sleep(asked.get("lead_s", 0.0))
    for signal in signals:
        output.play(signal)
    if asked.get("tell"):
        threading.Thread(target=tell, args=(output._feed,), daemon=True).start()
    if "stop_s" in asked:
        time.sleep(asked["stop_s"])
        output.stop()
        os.write(1, f"stopped {output._feed._at}\n".encode())
    output._feed.ended.wait(60)
    time.sleep(asked.get("tail_s", 0.0))
    facts = output.facts()
    output.close()
    print(json.dumps(facts), flush=True)


if __name__ == "__main__":
    main(json.loads(sys.argv[1]))
