"""Benchmark programs as importable modules."""

import importlib.util
import sys

from places import ROOT

FOLDER = ROOT / "benchmarks"


def benchmark_module(name):
    place = importlib.util.spec_from_file_location(f"benchmark_{name}", FOLDER / f"{name}.py")
    module = sys.modules[place.name] = importlib.util.module_from_spec(place)
    sys.path.append(str(FOLDER))
    try:
        place.loader.exec_module(module)
    finally:
        sys.path.remove(str(FOLDER))
    return module
