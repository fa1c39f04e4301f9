"""Loops that numba compiles as it does by default; what wants more of it names the decorator itself.

Machine code on disk is found by the types of its arguments. An `entry` takes plain tuples therefore: a named one would
tie a file that outlives this source to the name of a class in it. `uniform` arguments keep it to one machine code: a
whole number for a float, or columns for rows, would be compiled anew, which takes seconds.
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
"""Without what only Python calls, a third of the time that compiling takes."""


def compiled(loop: Loop) -> Loop:
    """A loop as a part of the entries that call it, compiled with them; to Python it stays the plain function."""
    made: Loop = register_jitable(**AS_PART)(loop)
    return made


def entry(loop: Loop) -> Loop:
    """A loop that Python calls, as machine code that is kept on disk."""
    made: Loop = njit(cache=True)(loop)
    return made


@cache
def called(function: Loop) -> Loop:
    """A plain function that a loop made for it may call. On disk the loop is then found by the function's name, where a
    compiled one would have another in each process; `sources` in the loop tell it from that of other code."""
    made: Loop = register_jitable(**AS_PART)(function)
    return made


def sources(*functions: Callable[..., object]) -> str:
    """A digest of the files that functions stand in: a loop on disk knows what it calls by its name alone, or by its
    code where that stands in no file."""
    files = map(Path, sorted({inspect.getfile(function) for function in functions}))
    return hashlib.sha256(b"".join(file.read_bytes() for file in files if file.is_file())).hexdigest()


def uniform(values: Iterable[object]) -> tuple[Any, ...]:
    """The values as a plain tuple: arrays by rows, whole numbers as floats."""
    return tuple(map(_uniform, values))


def _uniform(value: object) -> object:
    if isinstance(value, np.ndarray):
        return np.ascontiguousarray(value)
    return float(value) if isinstance(value, int | np.integer) and not isinstance(value, bool) else value
