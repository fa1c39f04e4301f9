"""A bench with force and sound, and a short study on it."""

import importlib.util

import pytest
from study_texts import tutorial_in
from window_sitting import tactometry

N_TRIALS = 3

BENCH = """
[screen]
fullscreen = false
dry_run = false
[output]
kind = "audio"
device = "tofile"
rate_hz = 48000
sample_format = "int16"
{gain}
[output.load]
kind = "electrode"
capacitance_f = "1 nF"
[limits]
voltage_peak_v = 80.0
duration_s = 30.0
current_peak_a = "1 mA"
duty = 0.8
session_s = "1 h"
[sensors.hand]
kind = "lsl"
stream = "{stream}"
rate_hz = 1000
n_channels = 3
[force]
sensor = "hand"
channel = 2
newtons_per_count = 0.01
release = false
"""


@pytest.fixture(scope="module")
def needed():
    for name in ("sounddevice", "pylsl"):
        if importlib.util.find_spec(name) is None:
            pytest.skip(f"no {name}: extras audio, lsl")


def study_in(folder, n_trials=N_TRIALS, duration="200 ms"):
    lasting = {'duration_s = "500 ms"': f'duration_s = "{duration}"\nrate_hz = 48000.0'}
    return tutorial_in(folder, {**STUDY, **lasting, "repeats = 4": f"repeats = {n_trials}"})


def begin(folder, study, bench, env, **ends):
    """Write the bench file, and start a session in the folder `data`."""
    (folder / "bench.toml").write_text(bench, encoding="utf-8")
    words = ("run", study, "--participant", "P01", "--bench", folder / "bench.toml", "--out", folder / "data")
    return tactometry(*words, env=env, **ends)


STUDY = {
    "frequency_hz = [60, 240]": "frequency_hz = [60]",
    "catch_rate = 0.2": "catch_rate = 0.0",
    "levels = [22, 28, 34, 40]": "levels = [34]",
}
