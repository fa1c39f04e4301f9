"""Docstring examples pass, and imports on pages exist."""

import doctest
import importlib
import linecache
import pkgutil
import re
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest
from places import DOCS, ROOT

import tactometry

NOT_EVERYWHERE = ("nidaqmx", "psychopy")
FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


def modules() -> Iterator[str]:
    yield "tactometry"
    yield from (found.name for found in pkgutil.walk_packages(tactometry.__path__, "tactometry."))


def imported(name: str) -> ModuleType:
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as missing:
        if missing.name not in NOT_EVERYWHERE:
            raise
        pytest.skip(f"{name} needs {missing.name}, which is not installed")


@pytest.fixture(autouse=True)
def _no_old_lines() -> None:
    """Clear cached lines, which doctest checks on disk before each run."""
    linecache.clearcache()


@pytest.mark.parametrize("name", list(modules()))
def test_docstring_examples_pass(name: str) -> None:
    failed, _ = doctest.testmod(imported(name), optionflags=FLAGS, report=True)
    assert failed == 0


PAGES = (ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(DOCS.rglob("*.md")))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_page_imports_exist(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    for line in re.findall(r"^(?:>>> )?(from tactometry[\w.]* import [\w, ]+)$", text, re.MULTILINE):
        exec(line, {})
