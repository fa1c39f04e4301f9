"""The examples in the docstrings are true: every module of the package, imported by its own name."""

import doctest
import importlib
import pkgutil
from collections.abc import Iterator
from types import ModuleType

import pytest

import tactometry

NOT_EVERYWHERE = ("nidaqmx",)
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


@pytest.mark.parametrize("name", list(modules()))
def test_the_examples_of(name: str) -> None:
    failed, _ = doctest.testmod(imported(name), optionflags=FLAGS, report=True)
    assert failed == 0
