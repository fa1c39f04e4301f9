"""The doors of the house stay shut: imports, contracts of import-linter, what a commit may not hold."""

import ast
import json
import os
import re
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
ROOMS = ("stimuli", "protocols", "analysis", "experiments")
FOLDERS = ("tactometry", *ROOMS)
SCRIPTS = Path(sys.executable).parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]

DRIVEN = ("sounddevice", "serial", "pylsl", "nidaqmx")
WORDS = """
numpy scipy pandas matplotlib numba llvmlite statsmodels pingouin sklearn seaborn pyarrow msgspec jinja2
joblib dask distributed h5py psychopy psychtoolbox pyglet
"""
HEAVY = frozenset((*WORDS.split(), *DRIVEN))
IMPORTED_AS = {"pyserial": "serial", "imageio-ffmpeg": "imageio_ffmpeg"}


def sources() -> list[Path]:
    found = (path for folder in FOLDERS for path in (ROOT / folder).rglob("*.py"))
    return sorted(path for path in found if not any(part.is_symlink() for part in (path, *path.parents)))


def imports(source: str) -> Iterator[str]:
    """The top-level names of all absolute imports."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (alias.name.split(".")[0] for alias in node.names)
        if isinstance(node, ast.ImportFrom) and node.module and node.level == 0:
            yield node.module.split(".")[0]


def distribution(requirement: str) -> str:
    name = re.match(r"[\w.-]+", requirement)
    assert name, requirement
    return name.group().lower()


# --- bare names


def lint(source: str) -> str:
    command = [SCRIPTS / "ruff", "check", "--select", "TID251", "--stdin-filename", "tactometry/new.py", "-"]
    return subprocess.run(command, input=source, capture_output=True, text=True, cwd=ROOT, check=False).stdout


@pytest.mark.parametrize("room", ROOMS)
@pytest.mark.parametrize("form", ["import {}", "import {}.part", "from {} import part", "from {}.part import x"])
def test_the_linter_refuses_a_bare_room(room: str, form: str) -> None:
    assert f"`{room}" in lint(form.format(room) + "\n")


def test_the_linter_takes_a_room_under_the_one_name() -> None:
    assert lint("import tactometry.stimuli\nfrom tactometry.analysis import threshold\n") == "All checks passed!\n"


# --- contracts


@pytest.fixture(scope="module")
def copy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the tree that a test may spoil."""
    place = tmp_path_factory.mktemp("tree")
    shutil.copy(ROOT / "pyproject.toml", place)
    for folder in FOLDERS:
        shutil.copytree(ROOT / folder, place / folder, symlinks=True, ignore=shutil.ignore_patterns("__pycache__"))
    return place


def contracts(tree: Path) -> "subprocess.CompletedProcess[str]":
    script = "import sys; sys.path.insert(0, '.'); from importlinter.cli import lint_imports_command; "
    command = [sys.executable, "-c", script + "lint_imports_command()", "--no-cache", "--no-logo"]
    return subprocess.run(command, cwd=tree, capture_output=True, text=True, check=False)


@pytest.mark.parametrize(
    ("file", "line"),
    [
        ("tactometry/rigs/bad.py", "import tactometry.stimuli.electrovibration"),
        ("tactometry/bad.py", "from tactometry.experiments import bad"),
        ("tactometry/bad.py", "from tactometry import cli"),
        ("stimuli/bad.py", "from tactometry.analysis import bad"),
        ("protocols/bad.py", "import tactometry.stimuli"),
        ("analysis/bad.py", "import tactometry.experiments"),
        ("experiments/bad.py", "from tactometry.cli import main"),
        ("tactometry/rigs/bad.py", "from psychopy import visual"),
        ("tactometry/rigs/bad.py", "import sounddevice"),
        ("analysis/bad.py", "import matplotlib.pyplot"),
        ("stimuli/bad.py", "import pingouin"),
        ("analysis/bad.py", "import psignifit"),
    ],
)
def test_a_contract_refuses(copy: Path, file: str, line: str) -> None:
    bad = copy / file
    bad.write_text(line + "\n", encoding="utf-8")
    try:
        result = contracts(copy)
    finally:
        bad.unlink()
    module = "tactometry." + file.removeprefix("tactometry/").removesuffix(".py").replace("/", ".")
    assert result.returncode == 1
    assert f"{module} -> {line.split()[1].partition('.')[0]}" in result.stdout


def test_the_tree_keeps_its_contracts(copy: Path) -> None:
    result = contracts(copy)
    assert (result.returncode, "0 broken" in result.stdout) == (0, True), result.stdout + result.stderr


@pytest.mark.parametrize("library", DRIVEN)
def test_a_device_library_has_one_driver(library: str) -> None:
    drivers = [path.name for path in sources() if library in imports(path.read_text(encoding="utf-8"))]
    assert len(drivers) <= 1


def test_what_the_product_imports_is_declared() -> None:
    extras = PROJECT["optional-dependencies"]
    declared = [
        *PROJECT["dependencies"],
        *(each for name, group in extras.items() if name != "dev" for each in group),
    ]
    names = {IMPORTED_AS.get(name, name) for name in map(distribution, declared)}
    used = {name for path in sources() for name in imports(path.read_text(encoding="utf-8"))}
    assert used - names - set(sys.stdlib_module_names) == {"tactometry"}


# --- what a command loads


def test_help_loads_nothing_heavy() -> None:
    script = (
        "import sys, json; sys.argv = ['tactometry', '--help']; from tactometry.cli import main\n"
        "try: main()\n"
        "finally: print(json.dumps(sorted({name.split('.')[0] for name in sys.modules})), file=sys.stderr)"
    )
    result = subprocess.run([sys.executable, "-I", "-c", script], capture_output=True, text=True, check=False)
    assert "Usage: tactometry" in result.stdout
    assert result.returncode == 0
    assert HEAVY & set(json.loads(result.stderr.splitlines()[-1])) == set()


# --- what a commit may not hold

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
def test_no_commit_holds(what: str) -> None:
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
def test_the_patterns_find(what: str, text: str) -> None:
    assert FORBIDDEN[what].search(text)


@pytest.mark.skipif("PYTEST_XDIST_WORKER" not in os.environ, reason="one process has all tests")
def test_a_file_stays_in_one_process(request: pytest.FixtureRequest) -> None:
    assert request.node.nodeid.endswith(f"@{Path(__file__).name}")
