"""Packages: docstrings, exported names and lazy imports."""

import inspect
import json
import re
import subprocess
import sys
from importlib import import_module
from pkgutil import iter_modules, walk_packages

import numpy as np
import pytest
from places import DOCS

import tactometry
from tactometry.signal import Signal

ROOMS = sorted(
    module.name.removeprefix("tactometry.")
    for module in walk_packages(tactometry.__path__, "tactometry.")
    if module.ispkg
)
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
FACES = ("analysis", *PINNED)
EXPORTING = ("analysis", "protocols", "stimuli.electrovibration", "stimuli.perception", "stimuli.time_reversal")


@pytest.mark.parametrize("name", ROOMS)
def test_package_docstring_states_its_purpose(name):
    room = import_module(f"tactometry.{name}")
    assert room.__doc__
    assert len(room.__doc__.split(".")[0]) < 120


@pytest.mark.parametrize(("room", "names"), PINNED.items())
def test_pinned_names_remain_importable(room, names):
    for name in names.split():
        assert getattr(import_module(f"tactometry.{room}"), name)


def handed_on(room):
    """Return the exported names of a package, lazy or imported."""
    plain = {name for name, thing in vars(room).items() if name[0] != "_" and not inspect.ismodule(thing)}
    return set(getattr(room, "__all__", plain))


@pytest.mark.parametrize("name", [name for name in FACES if name != "psychometric"])
def test_exported_names_exist_with_docstrings(name):
    room = import_module(f"tactometry.{name}")
    public_names = handed_on(room)
    assert public_names
    assert public_names <= set(dir(room))
    for public in public_names:
        found = getattr(room, public)
        if inspect.isclass(found) or inspect.isfunction(found):
            assert inspect.getdoc(found), f"{name}.{public}"


@pytest.mark.parametrize("name", [name for name in FACES if name.startswith("analysis")])
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


def test_unknown_name_is_an_attribute_error():
    room = import_module("tactometry.analysis")
    with pytest.raises(AttributeError, match="has no attribute 'fitt'"):
        _ = room.fitt


def test_listing_package_names_imports_no_library():
    ask = (
        "import json, sys, tactometry.analysis as room; names = dir(room); "
        "print(json.dumps([names, sorted({name.partition('.')[0] for name in sys.modules})]))"
    )
    said = subprocess.run([sys.executable, "-c", ask], capture_output=True, text=True, check=True)
    names, loaded = json.loads(said.stdout)
    assert {"fit", "analyse", "repeated_measures", "scores"} <= set(names)
    assert not {"numpy", "scipy", "pandas", "matplotlib", "statsmodels", "numba"} & set(loaded)


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
