"""Loops that numba compiles: the one import of its decorator.

Machine code on disk is found by the types of its arguments. An `entry` takes plain tuples therefore: a named one would
tie a file that outlives this source to the name of a class in it.
"""

from collections.abc import Callable
from typing import TypeVar

from numba import njit

Loop = TypeVar("Loop", bound=Callable[..., object])


def compiled(loop: Loop) -> Loop:
    """A loop as machine code, a part of the entries that call it."""
    made: Loop = njit(loop)
    return made


def entry(loop: Loop) -> Loop:
    """A loop that Python calls, as machine code that is kept on disk."""
    made: Loop = njit(cache=True)(loop)
    return made
