"""The wheel holds the tree, once, and runs where nothing else of ours is; versions have no addresses.

The wheel is installed into a new virtual environment. In reduced form that environment reads the dependencies
from the site-packages of the running interpreter through a path file, which does not reach the editable
Tactometry there (path files of such a folder are not read). At full size (TACTOMETRY_SOAK=1) the environment
is empty, and pip installs the dependencies and checks their hashes.
"""

import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tomllib
import zipfile
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from patience import LONGEST_PROGRAM_S
from places import ROOT
from soak import SOAK
from source_tree import WINGS, copy_tree

from tactometry import __version__

KEPT = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "COV_", "COVERAGE"))}
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
MARKERS = [{"python_version": version, "python_full_version": f"{version}.2"} for version in ("3.11", "3.12")]


def files(folder: Path) -> set[str]:
    """Return the files of a package folder without links and caches."""
    found = (path.relative_to(folder) for path in folder.rglob("*") if path.is_file())
    own = (path for path in found if not any((folder / part).is_symlink() for part in (path, *path.parents)))
    return {path.as_posix() for path in own if "__pycache__" not in path.parts and not path.name.startswith(".")}


def tree() -> set[str]:
    rooms = {f"tactometry/{room}/{file}" for room in WINGS for file in files(ROOT / room)}
    return rooms | {f"tactometry/{file}" for file in files(ROOT / "tactometry")}


def run(*command: str | Path, cwd: Path) -> str:
    options = {"capture_output": True, "text": True, "timeout": LONGEST_PROGRAM_S}
    result = subprocess.run(command, cwd=cwd, env=KEPT, check=False, **options)
    assert result.returncode == 0, result.stdout[-2000:] + result.stderr[-2000:]
    return result.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    source = copy_tree(tmp_path_factory.mktemp("source"), "pyproject.toml", "setup.py", "README.md")
    shutil.copytree(ROOT / "LICENSES", source / "LICENSES")
    out = source / "dist"
    run(sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", out, ".", cwd=source)
    (built,) = out.glob("*.whl")
    return built


@pytest.fixture(scope="module")
def environment(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the scripts folder of an environment with the wheel."""
    place = tmp_path_factory.mktemp("environment")
    run(sys.executable, "-m", "venv", *([] if SOAK else ["--without-pip"]), place, cwd=place)
    scripts = place / ("Scripts" if os.name == "nt" else "bin")
    install = [sys.executable, "-m", "pip", "--python", scripts / "python", "install", "--quiet"]
    if SOAK:
        run(*install, "--require-hashes", "--requirement", ROOT / "requirements" / "core.txt", cwd=place)
    else:
        (site,) = place.glob("lib/python*/site-packages") if os.name != "nt" else [place / "Lib" / "site-packages"]
        (site / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n", encoding="utf-8")
    run(*install, "--no-deps", wheel, cwd=place)
    return scripts


@pytest.fixture
def foreign(tmp_path: Path) -> Path:
    """Return a folder whose own packages have the names of ours."""
    for room in (*WINGS, "benchmarks"):
        (tmp_path / room).mkdir()
        (tmp_path / room / "__init__.py").write_text("raise RuntimeError('the lab has its own')\n", encoding="utf-8")
    return tmp_path


def test_wheel_contains_every_file_once(wheel: Path) -> None:
    names = zipfile.ZipFile(wheel).namelist()
    assert sorted(name for name in names if ".dist-info/" not in name) == sorted(tree())
    assert {name.split("/")[0] for name in names} == {"tactometry", f"tactometry-{__version__}.dist-info"}
    assert any(name.endswith("licenses/LICENSES/GPL-3.0-or-later.txt") for name in names)
    assert PROJECT["license"] == "GPL-3.0-or-later"


def test_installed_packages_take_precedence_over_local_folders(environment: Path, foreign: Path) -> None:
    names = ", ".join(f"tactometry.{room}" for room in WINGS)
    script = f"import {names}; print(*(m.__file__ for m in ({names},)), sep='\\n')"
    found = run(environment / "python", "-c", script, cwd=foreign).splitlines()
    assert len(found) == len(WINGS)
    assert all(Path(file).is_relative_to(environment.parent) for file in found)


@pytest.mark.slow
def test_installed_command_runs_demo_in_another_folder(environment: Path, foreign: Path) -> None:
    run(environment / "tactometry", "demo", "--out", "out", cwd=foreign)
    assert list((foreign / "out").rglob("*_data.csv"))
    assert list((foreign / "out").rglob("*.html"))


def constraints() -> dict[str, list[Requirement]]:
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
    pins = [Requirement(line) for line in lines if not line.startswith("#")]
    return {canonicalize_name(pin.name): [each for each in pins if each.name == pin.name] for pin in pins}


def pinned(name: str, marker: dict[str, str]) -> list[str]:
    pins = constraints().get(canonicalize_name(name), [])
    valid = [pin for pin in pins if pin.marker is None or pin.marker.evaluate(marker)]
    return [specifier.version for pin in valid for specifier in pin.specifier if specifier.operator == "=="]


@pytest.mark.parametrize("marker", MARKERS, ids=lambda marker: marker["python_version"])
@pytest.mark.parametrize(
    "needed",
    [*PROJECT["dependencies"], *(each for group in PROJECT["optional-dependencies"].values() for each in group)],
)
def test_each_requirement_has_one_admitted_version(needed: str, marker: dict[str, str]) -> None:
    requirement = Requirement(needed)
    versions = pinned(requirement.name, marker)
    assert len(versions) == 1
    assert requirement.specifier.contains(versions[0])


def test_the_constraints_hold_versions_and_no_address() -> None:
    for pins in constraints().values():
        assert all(pin.url is None and len(pin.specifier) == 1 for pin in pins)


def hashed(name: str) -> dict[str, list[str]]:
    text = (ROOT / "requirements" / f"{name}.txt").read_text(encoding="utf-8").replace("\\\n", "")
    pins = [line.split(" --hash=") for line in map(" ".join, map(str.split, text.splitlines())) if "==" in line]
    return {pin: hashes for pin, *hashes in pins}


@pytest.mark.parametrize("name", ["core", "all"])
def test_every_requirement_has_hashes(name: str) -> None:
    pins = hashed(name)
    assert "setuptools" in {Requirement(pin).name for pin in pins}  # builds the editable package
    assert all(pins.values())
    assert all(re.fullmatch("sha256:[0-9a-f]{64}", each) for hashes in pins.values() for each in hashes)


def test_hashed_requirements_are_the_constraints() -> None:
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
    of_macos = "pyobjc-framework-"  # frameworks of macOS, which follow from pyobjc
    assert {pin for pin in hashed("all") if not pin.startswith(of_macos)} == set(lines[1:])


def test_hashed_core_holds_what_the_core_needs() -> None:
    core, every = ({Requirement(pin).name: Requirement(pin) for pin in hashed(name)} for name in ("core", "all"))
    assert {Requirement(needed).name for needed in PROJECT["dependencies"]} <= core.keys()
    assert all(every[name].specifier == pin.specifier for name, pin in core.items() if not pin.marker)


def test_make_installs_packages_by_hash_alone() -> None:
    rules = (ROOT / "Makefile").read_text(encoding="utf-8").partition("$(VENV)/.core:")[2]
    assert "$(INSTALL)" not in rules
    assert {"core", "all"} == set(re.findall(r"\$\(HASHED\) requirements/(\w+)\.txt", rules))


def test_window_extra_bounds_pyglet() -> None:
    [pyglet] = [each for each in map(Requirement, PROJECT["optional-dependencies"]["window"]) if each.name == "pyglet"]
    assert not pyglet.specifier.contains("2.0")
