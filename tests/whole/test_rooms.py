"""Packages: docstrings, exported names and lazy imports."""

import inspect
import re
import subprocess
import sys
from importlib import import_module
from pkgutil import iter_modules, walk_packages

import numpy as np
import pytest
from places import DOCS, ROOT
from source_tree import sources

import tactometry
from tactometry.signal import Signal

ROOMS = sorted(module.name for module in walk_packages(tactometry.__path__, "tactometry.") if module.ispkg)
PINNED = {
    "analysis.threshold": "fit fit_many ThresholdFit Status",
    "analysis.anova": "repeated_measures",
    "analysis.attrakdiff": "scores",
    "analysis.hierarchical": "fit_hierarchical HierarchicalFit",
    "psychometric": "PsychometricFunction",
    "stimuli.time_reversal": "Plate",
    "stimuli.electrovibration": "Skin electrostatic_force_n Sine Square Trapezoid Step AmplitudeModulated",
    "protocols": "ConstantStimuli Staircase WeightedStaircase QuestPlus",
}
"""Names that users import, which must not move."""
EXPORTING = ("analysis", "protocols", "stimuli.electrovibration", "stimuli.perception", "stimuli.time_reversal")


@pytest.mark.parametrize("name", ROOMS)
def test_package_docstring_states_its_purpose(name):
    room = import_module(name)
    assert room.__doc__
    assert len(room.__doc__.split(".")[0]) < 120


@pytest.mark.parametrize(("room", "names"), PINNED.items())
def test_pinned_names_remain_importable(room, names):
    for name in names.split():
        assert getattr(import_module(f"tactometry.{room}"), name)


@pytest.mark.parametrize("name", ["analysis", *(name for name in PINNED if name.startswith("analysis"))])
def test_exported_names_do_not_shadow_modules(name):
    room = import_module(f"tactometry.{name}")
    assert not {module.name for module in iter_modules(room.__path__)} & set(room.__all__)


def test_public_names_are_those_of_one_page():
    page = (DOCS / "reference" / "api" / "index.md").read_text(encoding="utf-8")
    listed = re.findall(r"^\| `(\w+)` \| \S", page, flags=re.MULTILINE)
    packages = [import_module(name) for name in re.findall(r"^`(tactometry[.\w]*)`$", page, flags=re.MULTILINE)]
    assert sorted(listed) == sorted({name for package in packages for name in package.__all__})
    assert len(listed) <= 90
    assert {package.__name__ for package in packages} == {"tactometry", *(f"tactometry.{name}" for name in EXPORTING)}


def test_listing_package_names_imports_no_library():
    code = "import sys, tactometry.analysis as room; print(*dir(room)); print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    names, modules = (set(line.split()) for line in done.stdout.splitlines())
    assert {"fit", "analyse", "repeated_measures", "scores"} <= names
    assert not {"numpy", "scipy", "pandas", "matplotlib", "statsmodels", "numba"} & modules


def test_unknown_name_is_an_attribute_error():
    room = import_module("tactometry.analysis")
    with pytest.raises(AttributeError, match="has no attribute 'fitt'"):
        _ = room.fitt


@pytest.mark.parametrize("shape", [(1, 0), (1, 1), (32, 200_000)])
def test_signal_repr_is_one_line(shape):
    said = repr(Signal(np.full(shape, -2.5), 250e3, "V"))
    assert "\n" not in said
    assert len(said) < 100
    assert said.startswith(f"Signal({shape[0]} channel")
    assert said.endswith(" 0 V)" if shape[1] == 0 else "peak 2.5 V)")


@pytest.mark.parametrize("name", ["analysis", "stimuli.electrovibration", "stimuli.time_reversal"])
def test_signatures_show_alias_names(name):
    room = import_module(f"tactometry.{name}")
    for public in room.__all__:
        said = str(inspect.signature(getattr(room, public))) if inspect.isfunction(getattr(room, public)) else ""
        assert "_typing" not in said, public
        assert len(said) < 800, public


# --- pages of Python names from docstrings

PAGES = {path.stem: path.read_text(encoding="utf-8") for path in (DOCS / "reference" / "api").glob("*.md")}
OTHERS = ("tactometry.protocols", "tactometry.psychometric", "tactometry.signal", "tactometry.contact")
"""Other modules with public names."""


def faces():
    for path in sources():
        if path.name == "__init__.py" and "exports(__name__" in path.read_text(encoding="utf-8"):
            yield f"tactometry.{'.'.join(path.parent.relative_to(ROOT).parts)}"


def is_part(module):
    """Return whether the package above exports all names of a module."""
    names, above = import_module(module).__all__, import_module(module.rpartition(".")[0])
    return set(names) <= set(getattr(above, "__all__", ()))


@pytest.mark.parametrize("module", [*(face for face in faces() if not is_part(face)), *OTHERS])
def test_a_module_of_public_names_has_its_page(module):
    name = module.removeprefix("tactometry.").replace(".", "_")
    assert f"automodule:: {module}\n   :members:" in PAGES[name]
    assert re.search(rf"^{name}$", PAGES["index"], re.MULTILINE)


@pytest.mark.parametrize("module", [*faces(), "tactometry.protocols"])
def test_package_dir_lists_only_public_names(module):
    face = import_module(module)
    assert dir(face) == sorted(face.__all__)
    assert [name for name in dir(face) if name.startswith("_") or inspect.ismodule(getattr(face, name))] == []


@pytest.mark.parametrize("module", [*faces(), *OTHERS])
def test_public_name_has_docstring(module):
    face = import_module(module)
    named = {name: getattr(face, name) for name in getattr(face, "__all__", [])}
    documented = {name: thing for name, thing in named.items() if isinstance(thing, type) or inspect.isroutine(thing)}
    assert [name for name, thing in documented.items() if not (thing.__doc__ or "").strip()] == []
