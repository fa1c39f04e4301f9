"""A session in a real window, and hands that press its keys."""

import subprocess
import sys
import threading

import numpy as np
from patience import LONGEST_PROGRAM_S


def tactometry(*arguments, **how):
    command = [sys.executable, "-m", "tactometry", *map(str, arguments)]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    return subprocess.Popen(command, text=True, **{**pipes, **how})


def python(*words, check=False, **how):
    """Run Python with these words to its end."""
    pipes = {"capture_output": True, "text": True, "timeout": LONGEST_PROGRAM_S}
    return subprocess.run([sys.executable, *map(str, words)], check=check, **pipes, **how)


def sit(process, hands, keys):
    """Tap the keys until the process ends; return status, output, errors."""
    ended = threading.Event()

    def tap_all():
        for key in keys:
            if ended.wait(PAUSE_S):
                return
            hands.tap(key)

    fingers = threading.Thread(target=tap_all, daemon=True)
    fingers.start()
    try:
        output, errors = process.communicate(timeout=LONGEST_PROGRAM_S)
    finally:
        process.kill()
        ended.set()
        fingers.join(5)
    return process.returncode, output, errors


def any_keys(seed, n=2000):
    for answer in np.random.default_rng(seed).choice(["y", "n"], n):
        yield from ("space", str(answer))


PAUSE_S = 0.03
