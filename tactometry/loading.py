"""Late imports by target strings, and public names of packages."""

import ast
import sys
from collections.abc import Callable
from importlib import import_module
from inspect import ismodule
from operator import attrgetter
from pathlib import Path
from typing import Any


def resolve(target: str) -> Any:
    """Return the object of a target string.

    >>> resolve("math:pi"), resolve("builtins:str.upper")("pi")
    (3.141592653589793, 'PI')
    """
    module, _, name = target.partition(":")
    return attrgetter(name)(import_module(module))


def exports(package: str, file: str) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """Return `__getattr__` and `__dir__` of a package for late imports.

    The package names each export under ``if TYPE_CHECKING:`` as ``from .module import Name as Name``, which type
    checkers treat as a re-export. Those lines are parsed here and set ``__all__``.

    >>> import tactometry.analysis.threshold
    >>> tactometry.analysis.threshold.__all__
    ['Status', 'ThresholdFit', 'fit', 'fit_many']
    """
    module_of = dict(_named_under_type_checking(Path(file).read_text(encoding="utf-8")))
    names = sorted(module_of)
    vars(sys.modules[package])["__all__"] = names

    def ask(name: str) -> Any:
        if name not in module_of:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        thing = getattr(import_module(f"{package}.{module_of[name]}"), name)
        setattr(sys.modules[package], name, thing)
        return thing

    return ask, names.copy


def named(package: str) -> Callable[[], list[str]]:
    """Return `__dir__` of a package, and set its ``__all__``.

    >>> import tactometry.protocols
    >>> dir(tactometry.protocols)[:3]
    ['AdjustmentTask', 'Block', 'Comparison']
    """
    things = vars(sys.modules[package])
    public = {name: thing for name, thing in things.items() if not (name.startswith("_") or ismodule(thing))}
    names = sorted(public.keys() - {named.__name__})
    things["__all__"] = names
    return names.copy


def _named_under_type_checking(source: str) -> list[tuple[str, str]]:
    """Return each name with the module from which it is imported.

    >>> _named_under_type_checking("if TYPE_CHECKING:\\n    from .a.b import C as C, d as d")
    [('C', 'a.b'), ('d', 'a.b')]
    """
    return [
        (alias.name, line.module or "")
        for block in ast.parse(source).body
        if isinstance(block, ast.If) and isinstance(block.test, ast.Name) and block.test.id == "TYPE_CHECKING"
        for line in block.body
        if isinstance(line, ast.ImportFrom)
        for alias in line.names
    ]
