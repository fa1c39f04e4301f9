"""Decorators for loops that numba compiles.

Numba finds compiled code on disk by argument types. An `entry` therefore accepts plain tuples, because a named tuple
would tie the file to a class name. Its arguments must be `uniform`, because other types would be compiled again,
which takes seconds.
"""

import hashlib
import inspect
from collections.abc import Callable, Iterable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numba import njit
from numba.extending import register_jitable

Loop = TypeVar("Loop", bound=Callable[..., object])
AS_PART = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
"""Skip the wrappers for calls from Python, which take a third of the compilation time."""


def compiled(loop: Loop) -> Loop:
    """Compile a loop that is called by entries."""
    made: Loop = register_jitable(**AS_PART)(loop)
    return made


def entry(loop: Loop) -> Loop:
    """Compile a loop that Python calls, and cache it on disk."""
    made: Loop = njit(cache=True)(loop)
    return made


@cache
def called(function: Loop) -> Loop:
    """Compile a plain function for loops that call it.

    On disk the loop is found by the function's name. `sources` in the loop distinguishes it from other code.
    """
    made: Loop = register_jitable(**AS_PART)(function)
    return made


def sources(*functions: Callable[..., object]) -> str:
    """Return a digest of the source files of functions, empty without a file."""
    files = map(Path, sorted({inspect.getfile(function) for function in functions}))
    return hashlib.sha256(b"".join(file.read_bytes() for file in files if file.is_file())).hexdigest()


def uniform(values: Iterable[object]) -> tuple[Any, ...]:
    """Return values as a plain tuple of contiguous arrays and floats."""

    def plain(value: object) -> object:
        if isinstance(value, np.ndarray):
            return np.ascontiguousarray(value)
        return float(value) if isinstance(value, int | np.integer) and not isinstance(value, bool) else value

    return tuple(map(plain, values))
