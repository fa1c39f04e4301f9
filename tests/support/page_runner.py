"""Runner of a docs page: executes its blocks in order."""

import contextlib
import doctest
import io
import re
import shutil
from pathlib import Path
from typing import Any

from page_blocks import Block, blocks_of
from page_console import ALIKE, alike, run_console
from page_files import READERS, read_toml
from places import ROOT

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
