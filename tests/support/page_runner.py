"""Runner of the code blocks of a docs page, in order."""

import contextlib
import doctest
import io
import os
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import tomlkit
from command_line import status
from page_blocks import Block, blocks_of
from patience import LONGEST_PROGRAM_S
from places import ROOT

from tactometry.analysis.plan import read_plan
from tactometry.analysis.reading.column_map import read_column_map
from tactometry.experiments.bench.bench_file import load_bench
from tactometry.experiments.reference.tables import tables
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.study_file import load, parse
from tactometry.questionnaire import parse as parse_questionnaire
from tactometry.stimuli.scenes.file import load_scene
from tactometry.stimuli.time_reversal.plate.glass import read_plate

LANGUAGES = ("console", "python", "toml", "text")
SAID = re.compile(r"^ *print\(.*\)(?:  |\n *)# (.+)$", re.MULTILINE)
"""Expected output of a print: a comment after it, or on the next line."""


def run_page(page: Path) -> None:
    """Run all blocks; raise `AssertionError` with the place of a difference."""
    names: dict[str, Any] = {"__name__": "page"}
    for block in blocks_of(page):
        run_block(block, names)


def run_block(block: Block, names: dict[str, Any]) -> None:
    """Run one block; Python blocks share names with those above."""
    assert block.language in LANGUAGES, f"{block.place}: found a block of {block.language!r}, expected {LANGUAGES}"
    if block.mark == "not run":
        assert block.said, f"{block.place}: a block that is not run says why"
    elif block.mark == "of":
        assert _lines(block.text) in _lines((ROOT / block.said).read_text(encoding="utf-8")), (
            f"{block.place}: not in {block.said}"
        )
    elif block.mark == "file":
        Path(block.said).write_text(block.text, encoding="utf-8")
    elif absent(block):
        pass
    elif block.language == "console":
        run_console(block)
    elif block.language == "python":
        run_python(block, names)
    elif block.language == "toml":
        assert block.mark in {"study", "keys", *READERS}, (
            f"{block.place}: TOML without a comment that says what reads it"
        )
        read_toml(block)


def absent(block: Block) -> bool:
    """Return True if a block needs a program that is not installed."""
    return block.mark == "with" and shutil.which(block.said) is None


def _lines(text: str) -> str:
    return "\n".join(line.strip() for line in text.strip().splitlines())


def run_python(block: Block, names: dict[str, Any]) -> None:
    """Run Python as doctest, or as a block whose comments state its output."""
    if block.text.startswith(">>>"):
        _run_examples(block, names)
        return
    said = io.StringIO()
    code = compile("\n" * block.line + block.text, str(block.page), "exec", dont_inherit=True)
    with contextlib.redirect_stdout(said):
        exec(code, names)
    shown = "\n".join(SAID.findall(block.text))
    assert alike(shown, said.getvalue()), f"{block.place}: the page says\n{shown}\nand it prints\n{said.getvalue()}"


def _run_examples(block: Block, names: dict[str, Any]) -> None:
    told = io.StringIO()
    test = doctest.DocTestParser().get_doctest(block.text, names, block.place, str(block.page), block.line)
    test.globs = names
    doctest.DocTestRunner(optionflags=ALIKE).run(test, out=told.write, clear_globs=False)
    assert not told.getvalue(), told.getvalue()


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


READERS: dict[str, Callable[[Path], object]] = {
    "bench": load_bench,
    "map": read_column_map,
    "plan": read_plan,
    "plate": read_plate,
    "questionnaire": lambda path: parse_questionnaire(path.read_bytes(), str(path)),
    "scene": load_scene,
}


def read_toml(block: Block) -> None:
    if block.mark == "study" and not block.said:
        wire(parse(block.text.encode(), block.place), block.place)
        return
    if block.mark == "keys":
        table = tables()[block.said]
        values = tomllib.loads(block.text.removeprefix(table.header))
        table.read({key: value for key, value in values.items() if key != "kind" or not table.kind}, block.place)
        return
    if block.mark == "study":
        content = tomlkit.dumps(over(tomllib.loads(load(block.said)[1].decode()), tomllib.loads(block.text)))
        wire(parse(content.encode(), block.place), block.place)
        return
    path = Path("block.toml")
    path.write_text(block.text, encoding="utf-8")
    READERS[block.mark](path)


def over(study: Mapping[str, Any], part: Mapping[str, Any]) -> dict[str, Any]:
    """A study with the keys of a part of one; a table of another `kind` takes the place of that of the study."""
    merged = dict(study)
    for key, value in part.items():
        was = study.get(key)
        both = isinstance(value, dict) and isinstance(was, dict) and value.get("kind", 0) == was.get("kind", 0)
        merged[key] = over(was, value) if both else value
    return merged
