"""Modules that a command loads in a new process.

Times are measured in benchmarks/cold_start.py.
"""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from core_only import Missing, core_requirements, needed
from places import RECORDED, ROOT
from scipy.signal.windows import blackmanharris

from tactometry.stimuli.electrovibration.skin.stack import _zero
from tactometry.stimuli.perception.detection import blackman_harris

THRESHOLDS, ONE_PARTICIPANT = str(RECORDED / "electrovibration-threshold"), str(RECORDED / "forced-choice")
SESSION = ("run", "tutorial", "--participant", "P01", "--rig", "simulated", "--out", "made")
DRY_RUN = ("run", "electrovibration-threshold", "--participant", "P01", "--dry-run")
SIMULATE = ("simulate", "tutorial", "--participants", "1", "--seed", "1", "--out", "made")
STUDY = {"annotated-types", "click", "msgspec", "numpy"}
RECORDS = STUDY | {"portalocker"}
TABLES = STUDY | {"scipy", "pandas", "python-dateutil"}
TERMINAL = TABLES | {"rich", "jinja2", "markupsafe"}
LOADS = {
    ("--help",): {"click"},
    ("calibrate", "--help"): STUDY,
    ("studies",): STUDY,
    ("keys", "touch.slide"): STUDY | {"rich"},
    ("scene", "electrovibration-panel"): STUDY,
    ("scene", "a4-screen"): STUDY,
    ("validate", THRESHOLDS): STUDY,
    ("replay", THRESHOLDS): RECORDS,
    SESSION: RECORDS,
    SIMULATE: RECORDS,
    DRY_RUN: RECORDS | {"numba", "llvmlite", "scipy"},
    ("analyse", THRESHOLDS): TERMINAL,
    ("analyse", ONE_PARTICIPANT): TERMINAL,
}
"""All distributions that a command loads."""
NEVER = {
    DRY_RUN: {"scipy.signal", "scipy.optimize", "scipy.stats", "scipy.special"},
    ("analyse", THRESHOLDS): {"scipy.stats"},
    ("analyse", ONE_PARTICIPANT): {"scipy.interpolate", "scipy.optimize", "scipy.stats"},
}
DRAWING = {"matplotlib", "cycler", "fonttools", "kiwisolver", "packaging", "pillow", "pyparsing"}
REPORT = TERMINAL | DRAWING
CORE_ONLY = ROOT / "tests" / "support" / "core_only.py"


def loaded(command: tuple[str, ...], folder: Path) -> tuple[set[str], set[str]]:
    asked = [sys.executable, CORE_ONLY, json.dumps(command)]
    done = subprocess.run(asked, capture_output=True, text=True, check=False, cwd=folder)
    assert done.returncode == 0, done.stderr[-2000:]
    distributions, modules = json.loads(done.stderr.splitlines()[-1])
    # msgspec imports typing_extensions where it is installed, and statsmodels brings it.
    return set(distributions) - {"typing-extensions"}, set(modules)


@pytest.mark.parametrize(
    ("module", "library"), [("tactometry.cli.power", "matplotlib"), ("tactometry.experiments.watch.server", "pandas")]
)
def test_module_starts_without_a_slow_library(module: str, library: str) -> None:
    ask = f"import sys, {module}; sys.exit({library!r} in sys.modules)"
    assert subprocess.run([sys.executable, "-c", ask], check=False).returncode == 0


@pytest.mark.parametrize("command", LOADS, ids=lambda command: f"{command[0]} {Path(command[-1]).name}")
def test_command_loads_only_expected_core_distributions(command: tuple[str, ...], tmp_path: Path) -> None:
    distributions, modules = loaded(command, tmp_path)
    assert distributions == LOADS[command]
    assert not NEVER.get(command, set()) & modules


@pytest.mark.slow
def test_report_of_core_equals_that_with_extras(tmp_path: Path) -> None:
    """pandas stores texts differently if pyarrow is installed."""
    distributions, _ = loaded(("analyse", THRESHOLDS, "--report", "core.html"), tmp_path)
    assert distributions == REPORT
    analyse = [sys.executable, "-m", "tactometry", "analyse", THRESHOLDS, "--report", "all.html"]
    subprocess.run(analyse, capture_output=True, check=True, cwd=tmp_path)
    tables = {path.name: path.read_bytes() for path in (tmp_path / "core_tables").iterdir()}
    assert len(tables) > 5
    assert tables == {path.name: path.read_bytes() for path in (tmp_path / "all_tables").iterdir()}


def test_core_install_loads_no_extras() -> None:
    needs = needed(core_requirements())
    assert {"numpy", "llvmlite", "python-dateutil"} < needs
    assert not {"pyarrow", "psychopy", "psignifit"} & needs
    missing = Missing(frozenset({"numpy"}))
    assert missing.find_spec("numpy.linalg") is None
    with pytest.raises(ModuleNotFoundError, match="pyarrow"):
        missing.find_spec("pyarrow")


@pytest.mark.parametrize("n", [4, 5, 37079])
def test_blackman_harris_window_equals_scipy_exactly(n: int) -> None:
    np.testing.assert_array_equal(blackman_harris(n), blackmanharris(n, sym=False))


@pytest.mark.parametrize("root", [5e-324, 1e-305, 0.3, 1e300])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_root_is_found_to_the_last_bit(root: float, sign: int) -> None:
    assert _zero(lambda x: abs(x) - root, sign * 1e305) == sign * root
