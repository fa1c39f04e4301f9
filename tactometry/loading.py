"""Public names of a package, each imported when it is first asked for."""

import sys
from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any


def exports(package: str, names: Mapping[str, str]) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """The `__getattr__` and `__dir__` of `package`, by its modules and the names, parted by spaces, that each holds.

    Examples
    --------
    >>> ask, listed = exports("email", {"message": "EmailMessage", "utils": "formatdate parsedate"})
    >>> ask("EmailMessage").__name__, "formatdate" in listed()
    ('EmailMessage', True)
    """
    module_of = {name: module for module, held in names.items() for name in held.split()}

    def ask(name: str) -> Any:
        if name not in module_of:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        found = getattr(import_module(f"{package}.{module_of[name]}"), name)
        setattr(sys.modules[package], name, found)
        return found

    def listed() -> list[str]:
        return sorted({*vars(sys.modules[package]), *module_of})

    return ask, listed
