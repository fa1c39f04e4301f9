"""Every benchmark finds what it measures: no test runs one whole, so that a move could leave one behind unseen."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
from benchmark_modules import benchmark_module

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
IMPORT = "import runpy, sys; runpy.run_path(sys.argv[1], run_name='imported')"


@pytest.mark.slow
@pytest.mark.parametrize("benchmark", sorted(path.name for path in BENCHMARKS.glob("*.py")))
def test_a_benchmark_is_imported(benchmark: str) -> None:
    done = subprocess.run(
        [sys.executable, "-c", IMPORT, benchmark], cwd=BENCHMARKS, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


def test_every_check_of_the_limits_is_one_that_the_mutation_run_takes_away() -> None:
    mutation = benchmark_module("limits_mutation")
    checks = set(re.findall(r'\b_check\("(\w+)"', mutation.SOURCE))
    assert checks
    assert {f"no {name}" for name in checks} <= mutation.mutants().keys()


def test_the_ways_to_a_level_that_are_timed_are_there() -> None:
    """They assert that effects which are called off are off."""
    benchmark = benchmark_module("scene_in_study")
    for surface in benchmark.SURFACES.values():
        assert {"formula", "default scene"} < benchmark.ways(surface).keys()
