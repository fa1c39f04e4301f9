"""Target strings respect the import contracts."""

import ast
import re
from fnmatch import fnmatch
from pathlib import Path

import pytest
from places import ROOT
from source_tree import contracts, copy_tree, parsed, sources
from target_strings import targets

LAG = "tactometry.stimuli.electrovibration.motion.friction_lag"
UPWARDS = {
    "tactometry/devices/clock_map.py": "tactometry.devices.outputs.audio:AudioSettings",
    "stimuli/perception/detection.py": "tactometry.stimuli.scenes.effects.sensitivity:Sensitivity",
    "stimuli/electrovibration/skin/skin.py": f"{LAG}:FrictionLag",
}
"""Files with target strings that point upwards."""
CIRCLE = {"protocols/procedures/procedure.py": "tactometry.protocols.procedures.staircase:Staircase"}
"""A file on one floor with what it names, which imports it."""


def module_of(file: str) -> str:
    inner = file.removeprefix("tactometry/").removesuffix(".py").removesuffix("/__init__")
    return f"tactometry.{inner.replace('/', '.')}"


MODULES = {module_of(path.relative_to(ROOT).as_posix()): path for path in sources()}


def named(tree: ast.Module, module: str) -> dict[tuple[str, str], list[str]]:
    """Return the targets of a module with the modules they name."""
    package = module if MODULES[module].name == "__init__.py" else module.rpartition(".")[0]
    return {
        target: [other for other in MODULES if fnmatch(other, target[0]) and has(other, target[1])]
        for target in targets(tree, module, package)
    }


def has(module: str, name: str) -> bool:
    return re.search(rf"^(?:def |class |){name}\b", MODULES[module].read_text(encoding="utf-8"), re.M) is not None


def with_targets(place: Path, spoilt: dict[str, str]) -> Path:
    copy = copy_tree(place, "pyproject.toml")
    for module, path in MODULES.items():
        file = path.relative_to(ROOT).as_posix()
        tree = ast.parse(f'TARGET = "{spoilt[file]}"') if file in spoilt else parsed(path)
        others = {other for found in named(tree, module).values() for other in found} - {module}
        with (copy / file).open("a", encoding="utf-8") as source:
            source.writelines(f"\nimport {other}\n" for other in sorted(others))
    return copy


def test_targets_point_downwards(tmp_path: Path) -> None:
    result = contracts(with_targets(tmp_path, {}))
    assert (result.returncode, "0 broken" in result.stdout) == (0, True), result.stdout + result.stderr


@pytest.fixture(scope="module")
def refusal(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Return the output of the contracts for upward and circular targets."""
    result = contracts(with_targets(tmp_path_factory.mktemp("spoilt"), UPWARDS | CIRCLE))
    assert result.returncode == 1
    return " ".join(result.stdout.split())  # long lines are broken


@pytest.mark.parametrize("file", UPWARDS)
def test_upward_target_is_refused(refusal: str, file: str) -> None:
    assert f"{module_of(file)} -> {UPWARDS[file].partition(':')[0]}" in refusal


def test_circular_target_is_refused(refusal: str) -> None:
    assert "No cycles are allowed in tactometry.protocols.procedures." in refusal


def test_every_target_names_something_that_is_there() -> None:
    found = {
        target: modules for module, path in MODULES.items() for target, modules in named(parsed(path), module).items()
    }
    assert [target for target, modules in found.items() if not modules] == []
    assert (LAG, "FrictionLag") in found
