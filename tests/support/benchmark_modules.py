"""Benchmarks, which are programs beside the packages, as modules of which tests try a part."""

import importlib.util

from places import ROOT


def benchmark_module(name):
    place = importlib.util.spec_from_file_location(f"benchmark_{name}", ROOT / "benchmarks" / f"{name}.py")
    module = importlib.util.module_from_spec(place)
    place.loader.exec_module(module)
    return module
