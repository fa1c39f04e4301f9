"""What a command does not load, in a fresh process. How long one takes is measured in benchmarks/cold_start.py."""

import json
import subprocess
import sys

import numpy as np
import pytest
from scipy.signal.windows import blackmanharris
from threadpoolctl import threadpool_info, threadpool_limits

from tactometry.experiments.scenes import path_of
from tactometry.stimuli.electrovibration.motion import driven_motion
from tactometry.stimuli.electrovibration.skin.stack import _zero
from tactometry.stimuli.perception.detection import blackman_harris
from tactometry.stimuli.scenes.file import load_scene

DRAWING_AND_TABLES = {"matplotlib", "pandas", "statsmodels", "pingouin"}
NEVER = {
    ("scene", "electrovibration-panel"): {*DRAWING_AND_TABLES, "scipy.signal", "scipy.optimize", "scipy.stats"},
    ("scene", "a4-screen"): {*DRAWING_AND_TABLES, "scipy.signal", "scipy.optimize", "scipy.stats"},
    ("studies",): {*DRAWING_AND_TABLES, "numba", "scipy"},
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


@pytest.mark.parametrize("command", NEVER, ids=" ".join)
def test_a_command_does_not_load(command: tuple[str, ...]) -> None:
    asked = [sys.executable, "-c", ASK, json.dumps(command)]
    done = subprocess.run(asked, capture_output=True, text=True, check=True)
    assert not NEVER[command] & set(json.loads(done.stderr.splitlines()[-1]))


@pytest.mark.parametrize("n", [4, 5, 37079])
def test_the_window_of_a_spectrum_is_that_of_scipy_bit_for_bit(n: int) -> None:
    np.testing.assert_array_equal(blackman_harris(n), blackmanharris(n, sym=False))


@pytest.mark.parametrize("root", [5e-324, 1e-305, 0.3, 1e300])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_root_is_found_to_the_last_bit(root: float, sign: int) -> None:
    assert _zero(lambda x: abs(x) - root, sign * 1e305) == sign * root


def test_small_exponentials_run_on_one_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two threads take 20 times as long for them."""
    seen: set[int] = set()
    flow = driven_motion.flow

    def watched(*arguments: object) -> object:
        seen.update(pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas")
        return flow(*arguments)

    monkeypatch.setattr(driven_motion, "flow", watched)
    driven_motion.plan_of.cache_clear()
    found = load_scene(path_of("electrovibration-panel"))
    with threadpool_limits(2, "blas"):
        found.scene.resolve().run(found.given)
    assert seen == {1}
