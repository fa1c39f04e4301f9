"""A folder with the study of docs/how_to/psychopy.md and a bench: signals go into a file, a hand presses 1 N."""

import os
import subprocess
import sys

from benches import PRESSED_ELECTRODE
from emulated import Emulator
from page_blocks import texts_of
from window_sitting import sit


def hand_and_bench(folder):
    """The hand, to be closed; study, bench and the maps of the page lie in the folder."""
    hand = Emulator("udp", folder, profile="1:100")
    names = ("touch.toml", "columns.toml", "attrakdiff.toml")
    written = dict(zip(names, texts_of("how_to/psychopy.md", "toml"), strict=True))
    written["bench.toml"] = PRESSED_ELECTRODE.format(folder="played", port=hand.udp_port)
    for name, text in written.items():
        (folder / name).write_text(text, encoding="utf-8")
    return hand


def run_script(folder, hands, script, keys):
    """Run a script of the folder, whose hand presses 1 N; return status, output and errors."""
    hand, pipes = hand_and_bench(folder), dict.fromkeys(("stdout", "stderr"), subprocess.PIPE)
    process = subprocess.Popen([sys.executable, script], cwd=folder, text=True, env=os.environ, **pipes)
    try:
        return sit(process, hands, keys)
    finally:
        hand.close()
