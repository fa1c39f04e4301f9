"""What a command does not load, in a fresh process. How long one takes is measured in benchmarks/cold_start.py."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.signal.windows import blackmanharris

from tactometry.stimuli.electrovibration.skin.stack import _zero
from tactometry.stimuli.perception.detection import blackman_harris

DRAWING_AND_TABLES = {"matplotlib", "pandas", "statsmodels", "pingouin"}
EDITOR = "tomlkit"
"""Edits a file: `calibrate --write` needs it, and a study that names a form by its file."""
RECORDED = str(Path(__file__).parents[1] / "recorded" / "electrovibration-threshold")
DRY_RUN = ("run", "electrovibration-threshold", "--participant", "P01", "--dry-run")
SIMULATE = ("simulate", "tutorial", "--participants", "1", "--seed", "1", "--out", "made")
NEVER = {
    ("--help",): {*DRAWING_AND_TABLES, EDITOR, "numba", "scipy", "numpy"},
    ("calibrate", "--help"): {EDITOR},
    ("studies",): {*DRAWING_AND_TABLES, "numba", "scipy"},
    ("scene", "electrovibration-panel"): {*DRAWING_AND_TABLES, "numba", "scipy"},
    ("scene", "a4-screen"): {*DRAWING_AND_TABLES, "numba", "scipy"},
    ("validate", RECORDED): {*DRAWING_AND_TABLES, "numba", "scipy"},
    ("replay", RECORDED): {*DRAWING_AND_TABLES, "numba", "scipy"},
    DRY_RUN: {*DRAWING_AND_TABLES, EDITOR, "scipy.signal", "scipy.optimize", "scipy.stats", "scipy.special"},
    SIMULATE: {*DRAWING_AND_TABLES, EDITOR, "numba", "scipy.linalg"},
}
ASK = """
import json, sys
from tactometry.cli import main
sys.argv[1:] = json.loads(sys.argv[1])
try:
    main()
finally:
    print(json.dumps(list(sys.modules)), file=sys.stderr)
"""


@pytest.mark.parametrize("command", NEVER, ids=lambda command: f"{command[0]} {Path(command[-1]).name}")
def test_a_command_does_not_load(command: tuple[str, ...], tmp_path: Path) -> None:
    asked = [sys.executable, "-c", ASK, json.dumps(command)]
    done = subprocess.run(asked, capture_output=True, text=True, check=True, cwd=tmp_path)
    assert not NEVER[command] & set(json.loads(done.stderr.splitlines()[-1]))


@pytest.mark.parametrize("n", [4, 5, 37079])
def test_the_window_of_a_spectrum_is_that_of_scipy_bit_for_bit(n: int) -> None:
    np.testing.assert_array_equal(blackman_harris(n), blackmanharris(n, sym=False))


@pytest.mark.parametrize("root", [5e-324, 1e-305, 0.3, 1e300])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_root_is_found_to_the_last_bit(root: float, sign: int) -> None:
    assert _zero(lambda x: abs(x) - root, sign * 1e305) == sign * root
