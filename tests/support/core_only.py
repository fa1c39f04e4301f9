"""A command where nothing is installed but the core: run as a program, with the command's arguments as JSON.

What `pyproject.toml` names without an extra, and what that needs in turn, can be imported; all else is refused, as if
it was not there. At the end the distributions that were loaded stand on standard error, and all modules, as JSON.
"""

import json
import re
import sys
import tomllib
from collections.abc import Iterator, Sequence
from importlib import metadata
from importlib.machinery import ModuleSpec
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

PROJECT = Path(__file__).parents[2] / "pyproject.toml"
OURS = "tactometry"


def core() -> dict[str, str]:
    """Return top-level modules of the core with their distributions."""
    return {top: name for name in needed(core_requirements()) for top in tops(name)}


def core_requirements() -> list[str]:
    wanted: list[str] = tomllib.loads(PROJECT.read_text(encoding="utf-8"))["project"]["dependencies"]
    return wanted


def needed(requirements: Sequence[str]) -> set[str]:
    """Return the distributions of requirements with their dependencies."""
    found: set[str] = set()
    left = list(requirements)
    while left:
        requirement = Requirement(left.pop())
        name = canonicalize_name(requirement.name)
        if name in found or (requirement.marker and not requirement.marker.evaluate({"extra": ""})):
            continue
        found.add(name)
        left += metadata.requires(name) or []
    return found


def tops(name: str) -> Iterator[str]:
    for file in metadata.files(name) or []:
        top = re.match(r"(\w+)(/|\.py$|\.[\w-]+\.so$|\.pyd$)", file.as_posix())
        if top:
            yield top.group(1)


class Missing:
    """Refuses what is neither of the core nor of Python; names that begin with a line are parts of the latter."""

    def __init__(self, known: frozenset[str]) -> None:
        self.known = known

    def find_spec(self, name: str, path: object = None, target: object = None) -> ModuleSpec | None:
        del path, target
        if not name.startswith("_") and name.partition(".")[0] not in self.known:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)
        return None


def main() -> None:
    modules = core()
    # Modules loaded before belong to the interpreter; path files of this environment load some.
    before = {name.partition(".")[0] for name in sys.modules}
    sys.meta_path.insert(0, Missing(frozenset({*modules, *before, *sys.stdlib_module_names, OURS})))
    for name in [name for name in sys.modules if name.partition(".")[0] == "packaging"]:  # used above, not by a command
        del sys.modules[name]
    from tactometry.cli import main as command

    sys.argv[1:] = json.loads(sys.argv[1])
    try:
        command()
    finally:
        loaded = {modules[top] for top in {name.partition(".")[0] for name in sys.modules} & modules.keys()}
        print(json.dumps([sorted(loaded), list(sys.modules)]), file=sys.stderr)


if __name__ == "__main__":
    main()
