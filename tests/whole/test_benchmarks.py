"""Every benchmark finds what it measures: no test runs one whole, so that a move could leave one behind unseen."""

import subprocess
import sys
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
IMPORT = "import runpy, sys; runpy.run_path(sys.argv[1], run_name='imported')"


@pytest.mark.slow
@pytest.mark.parametrize("benchmark", sorted(path.name for path in BENCHMARKS.glob("*.py")))
def test_a_benchmark_is_imported(benchmark: str) -> None:
    done = subprocess.run(
        [sys.executable, "-c", IMPORT, benchmark], cwd=BENCHMARKS, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
