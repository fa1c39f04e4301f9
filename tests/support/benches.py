"""Parts that several test benches share."""

from datetime import date


def gain_table(measured_with, volts_per_unit=2.0, amplifier_gain=50.0, measured_on=None, **more):
    """Return the table of a gain measured today, or on another day."""
    return {
        "volts_per_unit": volts_per_unit,
        "amplifier_gain": amplifier_gain,
        "measured_on": measured_on or date.today(),
        "measured_by": "ZG",
        "measured_with": measured_with,
        **more,
    }


def gain_toml(measured_with, *values, **more):
    """Return the gain table as text of a bench file."""
    table = gain_table(measured_with, *values, **more)
    rows = (f'{name} = "{value}"' if isinstance(value, str) else f"{name} = {value}" for name, value in table.items())
    return "\n".join(["[output.gain]", *rows, ""])


UDP_HAND = """\
[sensors.hand]
kind = "udp"
address = "127.0.0.1"
port = {port}
rate_hz = 1000
[force]
sensor = "hand"
channel = 2
newtons_per_count = 0.01
"""
"""A force that comes in datagrams."""

FILE_OUTPUT = """
[screen]
fullscreen = false
dry_run = false
[output]
kind = "file"
folder = "{folder}"
"""
FILE_BENCH = (
    FILE_OUTPUT
    + """\
[limits]
voltage_peak_v = 100.0
duration_s = 10.0
duty = {duty}
duty_window_s = {window_s}
session_s = "1 h"
"""
)

PRESSED_ELECTRODE = (
    FILE_OUTPUT
    + """\
[output.load]
kind = "electrode"
capacitance_f = "1 nF"
[output.gain]
volts_per_unit = 100.0
amplifier_gain = 1.0
[limits]
voltage_peak_v = 80.0
duration_s = 30.0
current_peak_a = "1 mA"
duty = 0.8
session_s = "1 h"
"""
    + UDP_HAND
    + "release = false\n"
)
"""A file in the place of an amplifier and its electrode, and a force that comes in datagrams."""


def file_bench(folder, duty, window_s=60):
    """Write a bench file whose output writes into the folder `played`."""
    path = folder / "bench.toml"
    path.write_text(FILE_BENCH.format(folder=folder / "played", duty=duty, window_s=window_s), encoding="utf-8")
    return path
