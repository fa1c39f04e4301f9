"""Checks by name, listed in `checks.toml`. Each is imported when requested."""

from importlib import import_module
from typing import Any, Final

from tactometry.config.toml import shipped_table
from tactometry.loading import resolve

from ..check import Check

_LISTED: Final[dict[str, dict[str, Any]]] = shipped_table(__package__, "checks")
CHECKS: Final = tuple(_LISTED)
"""Names of the checks, in the order of the page."""


def check_of(name: str) -> Check:
    """Return a check by its name."""
    listed = dict(_LISTED[name])
    module, _, settings = listed.pop("settings").partition(":")
    simulations = import_module(f"{__name__}.{module}")
    words = listed.pop("words").format(m=simulations)
    kind = resolve(f"{Check.__module__}:{listed.pop('kind')}")
    keys = tuple(listed.pop("keys"))
    return Check(name=name, words=words, kind=kind, keys=keys, settings=getattr(simulations, settings), **listed)
