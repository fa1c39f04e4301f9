"""Of several processes that need a loop one compiles it, for up to ten seconds; the others find it on the disk."""

from pathlib import Path

import portalocker
from numba.core.caching import NullCache
from numba.core.dispatcher import Dispatcher


def compile_once():
    """Who compiles what is kept on the disk holds its source meanwhile."""
    compiled = Dispatcher.compile

    def alone(loop, signature):
        if isinstance(loop._cache, NullCache):
            return compiled(loop, signature)
        with Path(loop.py_func.__code__.co_filename).open() as source:
            portalocker.lock(source, portalocker.LOCK_EX)
            return compiled(loop, signature)  # which looks on the disk first

    Dispatcher.compile = alone
