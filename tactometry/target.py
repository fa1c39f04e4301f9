"""Target strings, `module:name`: what is imported when it is asked for, and not before."""

import importlib
from typing import Any


def resolve(target: str) -> Any:
    """The object of a target string.

    >>> resolve("math:pi")
    3.141592653589793
    """
    module, _, name = target.partition(":")
    return getattr(importlib.import_module(module), name)
