"""Imports, import contracts, and forbidden text in tracked files."""

import ast
import re
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest
from places import ROOT
from source_tree import WINGS, contracts, copy_tree, parsed, sources

PYPROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
PROJECT = PYPROJECT["project"]
CONTRACTS = {contract["name"]: contract for contract in PYPROJECT["tool"]["importlinter"]["contracts"]}

DRIVEN = ("sounddevice", "serial", "pylsl", "nidaqmx")
IMPORTED_AS = {
    "annotated-types": "annotated_types",
    "pyserial": "serial",
    "imageio-ffmpeg": "imageio_ffmpeg",
    "pillow": "PIL",
}


def imports(tree: ast.Module) -> Iterator[str]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name.split(".")[0] for alias in node.names)
        if isinstance(node, ast.ImportFrom) and node.module and node.level == 0:
            yield node.module.split(".")[0]


def distribution(requirement: str) -> str:
    name = re.match(r"[\w.-]+", requirement)
    assert name, requirement
    return name.group().lower()


# --- relative imports within a package, absolute ones across


def misfits(path: Path, tree: ast.Module) -> list[str]:
    """Return the imports of a file whose form is wrong.

    Within a wing (kernel, stimuli, protocols, analysis, experiments) they are relative, so that a room can be moved or
    read alone; across wings absolute and by the one name, since a lab's own folder can shadow a bare `analysis`.
    """
    wing, *rooms = path.parts[:-1]
    found = []
    for node in ast.walk(tree):
        names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        if isinstance(node, ast.ImportFrom):
            leaves = node.level > len(rooms) + 1
            names = ["(another wing)"] if leaves else [node.module or ""] if node.level == 0 else []
            names = [f"{names[0]}.{node.names[0].name}"] if names == ["tactometry"] else names
        found += [f"{path}:{node.lineno} {name}" for name in names if leaves_or_stays_wrongly(name, wing)]
    return found


def leaves_or_stays_wrongly(name: str, wing: str) -> bool:
    top, *rest = name.split(".")
    target = rest[0] if rest and rest[0] in WINGS else "tactometry"
    return top in WINGS or top == "(another wing)" or (top == "tactometry" and target == wing)


def test_imports_are_relative_within_a_package_only() -> None:
    assert [line for path in sources() for line in misfits(path.relative_to(ROOT), parsed(path))] == []


@pytest.mark.parametrize("room", WINGS)
@pytest.mark.parametrize("form", ["import {}", "import {}.part", "from {} import part", "from {}.part import x"])
def test_bare_package_import_is_refused(room: str, form: str) -> None:
    assert misfits(Path("tactometry/rigs/new.py"), ast.parse(form.format(room)))


@pytest.mark.parametrize(
    ("path", "line", "is_right"),
    [
        ("analysis/report/new.py", "from tactometry.analysis.plan import Plan", False),
        ("analysis/report/new.py", "from tactometry.analysis import plan", False),
        ("analysis/report/new.py", "from ...errors import InvalidFile", False),
        ("tactometry/rigs/new.py", "from tactometry.errors import InvalidFile", False),
        ("tactometry/rigs/new.py", "from tactometry import errors", False),
        ("tactometry/new.py", "def late():\n    import tactometry.rigs.bench", False),
        ("analysis/report/new.py", "from tactometry.errors import InvalidFile", True),
        ("analysis/report/new.py", "from ..plan import Plan\nfrom .grid import grid\nimport numpy", True),
        ("tactometry/new.py", "from .errors import InvalidFile", True),
        ("experiments/new.py", "from tactometry import protocols", True),
    ],
)
def test_imports_of_the_wrong_form_are_found(path: str, line: str, is_right: bool) -> None:
    assert bool(misfits(Path(path), ast.parse(line))) is not is_right


# --- contracts


@pytest.fixture(scope="module")
def copy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return copy_tree(tmp_path_factory.mktemp("tree"), "pyproject.toml")


BAD = (
    ("tactometry/rigs", "import tactometry.stimuli.electrovibration"),
    ("tactometry", "from tactometry.experiments import part"),
    ("tactometry", "from tactometry import cli"),
    ("stimuli", "from tactometry.analysis import part"),
    ("protocols", "import tactometry.stimuli"),
    ("analysis", "import tactometry.experiments"),
    ("experiments", "from tactometry.cli import main"),
    ("tactometry/rigs", "from psychopy import visual"),
    ("tactometry/rigs", "import sounddevice"),
    ("experiments/watch", "import uvicorn"),
    ("analysis", "import matplotlib.pyplot"),
    ("stimuli", "import pingouin"),
    ("analysis", "import psignifit"),
    ("tactometry/session", "import tactometry.rigs.bench"),
    ("tactometry/session", "import tactometry.records.journal"),
    ("tactometry/trials", "import tactometry.session.request"),
    ("tactometry/arguments", "import tactometry.config.toml"),
    ("tactometry/rigs/touch", "import tactometry.rigs.bench"),
    ("tactometry/devices/sensors", "import tactometry.devices.outputs.audio"),
    ("tactometry/rigs", "import tactometry.devices.outputs.audio"),
    ("tactometry/rigs", "import tactometry.devices.sensors.lsl"),
    ("protocols", "from tactometry.safety import limits"),
    ("protocols", "import time"),
    ("protocols/procedures", "from tactometry.protocols import block"),
    ("protocols/tasks", "from tactometry.protocols.tasks import yes_no"),
    ("experiments/study", "from tactometry.experiments import bench"),
    ("analysis/tasks", "from tactometry.analysis import report"),
    ("analysis/report/sections", "from tactometry.analysis.report import page"),
    ("analysis/outcomes", "from tactometry.records import journal"),
    ("stimuli/time_reversal", "import tactometry.session.request"),
    ("stimuli/perception", "import tactometry.stimuli.electrovibration.skin.skin"),
    ("stimuli/time_reversal/plate", "import tactometry.stimuli.time_reversal.screen.screen"),
    ("stimuli/electrovibration/waveforms", "import tactometry.stimuli.electrovibration.skin.skin"),
    ("stimuli/scenes/stages", "import tactometry.stimuli.scenes.effects.edges"),
    ("stimuli/scenes/effects", "import tactometry.stimuli.scenes.effects.edges"),
)
BACK_UP = (
    ("analysis/threshold/start_values.py", "from .mode import Mode"),
    ("analysis/anova/design.py", "from .post_hoc import pairs"),
    ("analysis/mixed_models/linear.py", "from .censored import Counts"),
    ("analysis/hierarchical/model.py", "from .tables import SingleFits"),
    ("analysis/outcomes/findings.py", "from .ratings import Ratings"),
    ("analysis/threshold/likelihood.py", "from .log_posterior import Prior"),
    ("analysis/result.py", "from .report import page"),
    ("analysis/means.py", "from .plan import AnalysisPlan"),
    ("analysis/wording.py", "from .reading import rows"),
)
"""Upward imports, each in a file of a lower layer."""


CIRCLES = {
    "tactometry/config": "from . import one",
    "tactometry/files": "def late():\n    from . import one",
    "tactometry/safety": "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from . import one",
}
"""Lines with which a file `two`, imported by `one`, imports it back."""
FLOORS = [contract for contract in CONTRACTS.values() if "containers" in contract]
WITHOUT_A_FLOOR = [f"{room}.on_no_floor" for contract in FLOORS for room in contract["containers"]]


@pytest.fixture(scope="module")
def refused(copy: Path) -> "subprocess.CompletedProcess[str]":
    """Run the contracts on a tree with each bad line in its own file."""
    bad = {copy / folder / f"bad_{n}.py": line for n, (folder, line) in enumerate(BAD)}
    bad |= {copy / f"{module.replace('.', '/')}.py": "" for module in WITHOUT_A_FLOOR}
    for folder, back in CIRCLES.items():
        bad |= {copy / folder / "one.py": "from . import two", copy / folder / "two.py": back}
    sound = {copy / file: (copy / file).read_text(encoding="utf-8") for file, _ in BACK_UP}
    for file, line in [*bad.items(), *zip(sound, (line for _, line in BACK_UP), strict=True)]:
        file.write_text(f"{sound.get(file, '')}\n{line}\n", encoding="utf-8")
    try:
        return contracts(copy)
    finally:
        for file in bad:
            file.unlink()
        for file, text in sound.items():
            file.write_text(text, encoding="utf-8")


def complaints(said: str) -> dict[str, str]:
    details = " ".join(said.partition("Broken contracts")[2].split())
    _, *parts = re.split(rf"({'|'.join(map(re.escape, CONTRACTS))}) -[ -]{{9,}}", details)
    return dict(zip(parts[::2], parts[1::2], strict=True))


@pytest.mark.parametrize("contract", CONTRACTS)
def test_each_contract_is_broken_by_a_bad_line(refused: "subprocess.CompletedProcess[str]", contract: str) -> None:
    assert re.search(r"not allowed to import|llegal import|No cycles", complaints(refused.stdout).get(contract, ""))


@pytest.mark.parametrize("module", WITHOUT_A_FLOOR)
def test_file_without_layer_is_refused(refused: "subprocess.CompletedProcess[str]", module: str) -> None:
    (contract,) = (floors["name"] for floors in FLOORS if module.rpartition(".")[0] in floors["containers"])
    unlisted = complaints(refused.stdout)[contract].partition("not listed as layers")[2]
    assert f"- {module} " in unlisted


@pytest.mark.parametrize("n", range(len(BAD)), ids=[": ".join(bad) for bad in BAD])
def test_import_contract_refuses_bad_module(refused: "subprocess.CompletedProcess[str]", n: int) -> None:
    folder, line = BAD[n]
    module = "tactometry." + f"{folder}/bad_{n}".removeprefix("tactometry/").replace("/", ".")
    assert refused.returncode == 1
    unbroken = " ".join(refused.stdout.split())
    assert f"{module} -> {line.split()[1].partition('.')[0]}" in unbroken


@pytest.mark.parametrize(("file", "line"), BACK_UP)
def test_import_contract_refuses_an_upward_import(
    refused: "subprocess.CompletedProcess[str]", file: str, line: str
) -> None:
    package = "tactometry." + file.rpartition("/")[0].replace("/", ".")
    arrow = f"{package}.{Path(file).stem} -> {package}.{line.split()[1].lstrip('.')}"
    assert arrow in " ".join(refused.stdout.split())  # long lines are broken


@pytest.mark.parametrize("folder", CIRCLES)
def test_import_cycles_are_refused_in_every_folder(refused: "subprocess.CompletedProcess[str]", folder: str) -> None:
    assert f"No cycles are allowed in {folder.replace('/', '.')}." in refused.stdout


def test_the_tree_keeps_its_contracts(copy: Path) -> None:
    result = contracts(copy)
    assert (result.returncode, "0 broken" in result.stdout) == (0, True), result.stdout + result.stderr


@pytest.mark.parametrize("library", DRIVEN)
def test_a_device_library_has_one_driver(library: str) -> None:
    drivers = [path.name for path in sources() if library in imports(parsed(path))]
    assert len(drivers) <= 1


def test_imported_packages_are_declared() -> None:
    extras = PROJECT["optional-dependencies"]
    declared = [*PROJECT["dependencies"], *(each for name, group in extras.items() if name != "dev" for each in group)]
    names = {IMPORTED_AS.get(name, name) for name in map(distribution, declared)}
    used = {name for path in sources() for name in imports(parsed(path))}
    assert used - names - set(sys.stdlib_module_names) == {"tactometry"}


# --- forbidden text in tracked files

INDEX = "|".join(("py" + "pi", "python" + "hosted", "ana" + "conda", "npm" + "js", "art" + "ifactory", "nexus"))
FORBIDDEN = {
    "the host of a package index": re.compile(
        rf"(?:https?:)?//[^\s/\"']*(?:{INDEX})[^\s\"']*|--(?:extra-)?index-url[ =]+\w+:", re.I
    ),
    "a path of one machine": re.compile(
        "(?<![\\w.])/(?:" + "|".join(("wo" + "rk", "ho" + "me/\\w+", "ro" + "ot", "Us" + "ers/\\w+")) + ")/"
    ),
}


def committed() -> list[Path]:
    if not (ROOT / ".git").exists() or not shutil.which("git"):
        pytest.skip("not a git checkout")
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    return [ROOT / name for name in listed.split("\0") if name and (ROOT / name).is_file()]


@pytest.mark.parametrize("what", FORBIDDEN)
def test_tracked_files_contain_no_forbidden_text(what: str) -> None:
    found = [
        f"{path.relative_to(ROOT)}: {match.group()}"
        for path in committed()
        if (match := FORBIDDEN[what].search(path.read_text(encoding="utf-8", errors="replace")))
    ]
    assert found == []


@pytest.mark.parametrize(
    ("what", "text"),
    [
        ("the host of a package index", "https:" + "//files.python" + "hosted.org/x"),
        ("the host of a package index", "--index-url " + "https://here/simple"),
        ("a path of one machine", "'/wo" + "rk/main/a.py'"),
        ("a path of one machine", "open(/ho" + "me/me/x)"),
    ],
)
def test_forbidden_patterns_find_their_examples(what: str, text: str) -> None:
    assert FORBIDDEN[what].search(text)


def test_a_file_stays_in_one_process(request: pytest.FixtureRequest) -> None:
    if not getattr(request.config.option, "loadgroup", False):  # as a process of xdist has it from --dist
        pytest.skip("tests are not dealt out by groups: make test deals them so")
    assert request.node.nodeid.endswith(f"@{Path(__file__).name}")
