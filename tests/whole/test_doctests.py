"""The examples in docstrings are true; what a page imports is there."""

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
    """Before each run doctest asks the disk about every file of which lines are kept, for half of the time."""
    linecache.clearcache()


@pytest.mark.parametrize("name", list(modules()))
def test_the_examples_of(name: str) -> None:
    failed, _ = doctest.testmod(imported(name), optionflags=FLAGS, report=True)
    assert failed == 0


PAGES = (ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(DOCS.rglob("*.md")))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_page_imports_exist(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    for line in re.findall(r"^(?:>>> )?(from tactometry[\w.]* import [\w, ]+)$", text, re.MULTILINE):
        exec(line, {})
