"""A folder with the study of docs/psychopy.md and a bench: signals go into a file, a hand presses 1 N."""

from benches import UDP_HAND
from emulated import Emulator
from pages_of_docs import blocks

BENCH = """
[screen]
fullscreen = false
[output]
kind = "file"
folder = "played"
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


def hand_and_bench(folder):
    """The hand, to be closed; study, bench and the maps of the page lie in the folder."""
    hand = Emulator("udp", folder, profile="1:100")
    names = ("touch.toml", "columns.toml", "attrakdiff.toml")
    written = dict(zip(names, blocks("psychopy.md", "toml"), strict=True))
    written["bench.toml"] = BENCH + UDP_HAND.format(port=hand.udp_port) + "release = false\n"
    for name, text in written.items():
        (folder / name).write_text(text, encoding="utf-8")
    return hand
