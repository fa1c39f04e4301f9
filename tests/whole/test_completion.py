"""Completion of names in real shells in a terminal."""

import os
import pty
import re
import select
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

BIN = Path(sys.executable).parent
SHELLS = {"bash": ["bash", "--norc", "--noprofile", "-i"], "zsh": ["zsh", "-f", "-i"]}
BEGINS = {
    "bash": 'eval "$(_TACTOMETRY_COMPLETE=bash_source tactometry)"',
    "zsh": 'autoload -Uz compinit; compinit -u; eval "$(_TACTOMETRY_COMPLETE=zsh_source tactometry)"',
}
"""Line that a user types once, or adds to the shell's start-up file."""
IN_FISH = "_TACTOMETRY_COMPLETE=fish_source tactometry | source"
PATIENCE_S = 60.0
ESCAPES = re.compile(r"\x1b(?:\[[0-9;?=<>]*[A-Za-z]|\][^\x07]*\x07|[()][A-B0-2]|[=>])")

pytestmark = pytest.mark.skipif(not hasattr(os, "openpty"), reason="no terminals of this kind here")


class Terminal:
    """A shell in a pseudo-terminal, and its output."""

    def __init__(self, shell: str, home: Path) -> None:
        self.master, slave = pty.openpty()
        place = {"HOME": str(home), "PATH": f"{BIN}:{os.environ['PATH']}", "TERM": "xterm", "LC_ALL": "C.UTF-8"}
        streams = {"stdin": slave, "stdout": slave, "stderr": slave}
        self.process = subprocess.Popen(SHELLS[shell], cwd=home, env=place, start_new_session=True, **streams)
        os.close(slave)
        self.text = ""

    def type(self, keys: str) -> None:
        os.write(self.master, keys.encode())

    def shows(self, text: str) -> bool:
        """Wait for a text; return True if it was written."""
        until = time.monotonic() + PATIENCE_S
        while text not in ESCAPES.sub("", self.text) and time.monotonic() < until:
            if select.select([self.master], [], [], 0.5)[0]:
                self.text += os.read(self.master, 4096).decode(errors="replace")
        return text in ESCAPES.sub("", self.text)

    def close(self) -> None:
        self.process.kill()
        self.process.wait()
        os.close(self.master)


@pytest.fixture(params=SHELLS)
def terminal(request, tmp_path):
    if shutil.which(request.param) is None:
        pytest.skip(f"no {request.param} here")
    shown = Terminal(request.param, tmp_path)
    shown.type(f"{BEGINS[request.param]}; echo be''gun\n")
    assert shown.shows("begun"), shown.text
    yield shown
    shown.close()


def test_studies_and_key_tables_are_completed(terminal):
    terminal.type("tactometry new tu\t")
    assert terminal.shows("tactometry new tutorial"), terminal.text
    terminal.type("\x15tactometry keys procedure.st\t")
    assert terminal.shows("tactometry keys procedure.staircase"), terminal.text


@pytest.mark.skipif(shutil.which("fish") is None, reason="no fish here")
def test_fish_completes_studies_and_key_tables(tmp_path):
    """Fish has a command that prints its completions."""
    asked = f"{IN_FISH}; complete -C 'tactometry new tu'; complete -C 'tactometry keys procedure.st'"
    place = {"HOME": str(tmp_path), "PATH": f"{BIN}:{os.environ['PATH']}"}
    done = subprocess.run(["fish", "-c", asked], env=place, capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["tutorial", "procedure.staircase"]


@pytest.mark.parametrize(
    ("typed", "expected"),
    [("ke", "plain,keys"), ("run --resu", "plain,--resume"), ("scene a4", "plain,a4-screen"), ("run min", "file,min")],
)
def test_names_are_completed_and_paths_left_to_shell(typed, expected):
    place = {**os.environ, "COMP_WORDS": f"tactometry {typed}", "COMP_CWORD": str(1 + typed.count(" "))}
    place["_TACTOMETRY_COMPLETE"] = "bash_complete"
    done = subprocess.run([BIN / "tactometry"], env=place, capture_output=True, text=True, check=True)
    assert done.stdout.split() == [expected]
