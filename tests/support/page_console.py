"""Commands of a page, each run as a reader types it, and what they say compared with what the page shows.

Those of Tactometry run within this process, which is a hundred times as fast; the others in bash.
"""

import contextlib
import doctest
import io
import os
import shlex
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from command_line import status
from page_blocks import Block
from patience import LONGEST_PROGRAM_S

ALIKE = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
COLUMNS = "80"
COMPLAINT = "tactometry: "
"""Prefix of the reason why a command was refused; the exit status is then not 0."""


@dataclass(frozen=True)
class Command:
    line: str
    shown: str


def commands_of(text: str) -> Iterator[Command]:
    r"""Each line behind `$ ` with the lines below it; one that ends in a backslash goes on."""
    for part in f"\n{text}".split("\n$ ")[1:]:
        line, _, shown = part.replace("\\\n", " ").partition("\n")
        yield Command(" ".join(line.split()) if "'" not in line and '"' not in line else line, shown)


def said_by(line: str) -> tuple[int, str]:
    words = shlex.split(line, comments=True)
    # Reused processes of --jobs stay in the folder in which they were started.
    shell = words[0] != "tactometry" or {"|", ">", "&&", "--jobs"} & set(words)
    return _of_the_shell(line) if shell else _own(words[1:])


def _own(words: list[str]) -> tuple[int, str]:
    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        return status(*words), said.getvalue()


def _of_the_shell(line: str) -> tuple[int, str]:
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    env, ends = {**os.environ, "PATH": path}, {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    ends |= {"stdin": subprocess.DEVNULL, "timeout": LONGEST_PROGRAM_S}
    done = subprocess.run(["bash", "-c", line], env=env, text=True, check=False, **ends)
    return done.returncode, done.stdout


def alike(shown: str, said: str) -> bool:
    """Return True if output matches the page; `...` matches any part."""
    return doctest.OutputChecker().check_output(shown.strip() + "\n", said.strip() + "\n", ALIKE)


def run_console(block: Block) -> None:
    """Each command of a block; below one that the page shows nothing of, anything may have been said."""
    for command in commands_of(block.text):
        ended, said = said_by(command.line)
        refused = command.shown.startswith(COMPLAINT) or f"\n{COMPLAINT}" in command.shown
        assert (ended != 0) == refused, f"{block.place}: {command.line}: ended with {ended}:\n{said}"
        assert not command.shown.strip() or alike(command.shown, said), (
            f"{block.place}: {command.line}: the page shows\n{command.shown}\nand the command says\n{said}"
        )
