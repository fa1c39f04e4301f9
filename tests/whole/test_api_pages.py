"""Every public package has a page of Python names from docstrings."""

import inspect
import re
from importlib import import_module

import pytest
from places import DOCS, ROOT
from source_tree import sources

PAGES = {path.stem: path.read_text(encoding="utf-8") for path in (DOCS / "reference" / "api").glob("*.md")}
PINNED = ("tactometry.protocols", "tactometry.psychometric", "tactometry.signal", "tactometry.contact")
"""Other modules with public names."""


def faces():
    """Return the packages with public names."""
    for path in sources():
        if path.name == "__init__.py" and "exports(__name__" in path.read_text(encoding="utf-8"):
            yield f"tactometry.{'.'.join(path.parent.relative_to(ROOT).parts)}"


def is_part(module):
    """Return whether the package above exports all names of a module."""
    names, above = import_module(module).__all__, import_module(module.rpartition(".")[0])
    return set(names) <= set(getattr(above, "__all__", ()))


@pytest.mark.parametrize("module", [*(face for face in faces() if not is_part(face)), *PINNED])
def test_a_module_of_public_names_has_its_page(module):
    name = module.removeprefix("tactometry.").replace(".", "_")
    assert f"automodule:: {module}\n   :members:" in PAGES[name]
    assert re.search(rf"^{name}$", PAGES["index"], re.MULTILINE)


@pytest.mark.parametrize("module", [*faces(), "tactometry.protocols"])
def test_package_dir_lists_only_public_names(module):
    face = import_module(module)
    assert dir(face) == sorted(face.__all__)
    assert [name for name in dir(face) if name.startswith("_") or inspect.ismodule(getattr(face, name))] == []


@pytest.mark.parametrize("module", [*faces(), *PINNED])
def test_public_name_has_docstring(module):
    face = import_module(module)
    public = getattr(face, "__all__", [])
    named = {name: getattr(face, name) for name in public}
    told = {name: thing for name, thing in named.items() if isinstance(thing, type) or inspect.isroutine(thing)}
    assert [name for name, thing in told.items() if not (thing.__doc__ or "").strip()] == []
