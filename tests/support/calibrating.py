"""`tactometry calibrate` in a test, and a sound card's loopback."""

import io
import subprocess

import pytest
from benches import gain_toml
from command_line import call
from window_sitting import python

LOOPBACK = """
[output]
kind = "audio"
device = "pulse"
rate_hz = 48000
channels = [0, 1]
sample_format = "int16"
shared = true
{gain}
[output.load]
kind = "piezo"
capacitance_f = "1 nF"
displacement_m_per_v = [1e-6]
[limits]
voltage_peak_v = 20.0
duration_s = 10.0
current_peak_a = "10 mA"
displacement_peak_m = "1 mm"
duty = 1.0
session_s = "10 min"
[sensors.card]
kind = "audio"
device = "monitor"
rate_hz = 48000
n_channels = 2
""".format(gain=gain_toml("audio pulse, int16", 20.0, 1.0, system_volume=1.0))


def calibrate_with(env, cwd, *arguments, answers=""):
    """Run `tactometry calibrate` in a new process with environment `env`."""
    return python("-m", "tactometry", "calibrate", *arguments, cwd=cwd, env=env, input=answers)


@pytest.fixture
def calibrate(tmp_path, monkeypatch, capsys):
    def run(*arguments, answers=""):
        monkeypatch.setattr("sys.stdin", io.StringIO(answers))
        status, said, out = call(capsys, "calibrate", *arguments)
        return subprocess.CompletedProcess(arguments, status, out, said)

    monkeypatch.chdir(tmp_path)
    return run
