"""Compilation of a cached loop by one of several test processes."""

from contextlib import contextmanager
from pathlib import Path

import portalocker
from numba.core.caching import NullCache
from numba.core.dispatcher import Dispatcher

HELD = set()
"""Files that this process has locked: compiling a loop may compile another one of the same file."""


@contextmanager
def alone_with(path):
    if path in HELD:
        yield
        return
    with Path(path).open() as source:
        portalocker.lock(source, portalocker.LOCK_EX)
        HELD.add(path)
        try:
            yield
        finally:
            HELD.discard(path)


def compile_once():
    """Make numba lock a loop's source file while it compiles the loop."""
    compiled = Dispatcher.compile

    def alone(loop, signature):
        if isinstance(loop._cache, NullCache):
            return compiled(loop, signature)
        with alone_with(loop.py_func.__code__.co_filename):
            return compiled(loop, signature)  # reads the disk cache first

    Dispatcher.compile = alone
