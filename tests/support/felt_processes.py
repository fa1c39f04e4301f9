"""Studies that compute sensations in fresh processes.

A program of tests/experiments/test_scene_imports.py.

It reads study files by name as JSON, and computes the first stimulus of each in a copy of a process that has computed
none.
"""

import gc
import json
import sys
from functools import partial

from copies import in_a_copy

from tactometry.contact import Contact
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.study_file import parse


def modules_of(text):
    """Return the modules that are loaded after computing a level."""
    cell = next(iter(wire(parse(text.encode(), "study"), "study").cells.values()))
    cell.sensation.sensation_db(cell.stimulus.at(12.0), Contact(1.0, 0.05))
    return [name for name in sys.modules if name.startswith("tactometry.")]


if __name__ == "__main__":
    gc.disable()
    import scipy.signal  # noqa: F401 - slow to load, and of no effect alone

    json.dump({name: in_a_copy(partial(modules_of, text)) for name, text in json.load(sys.stdin).items()}, sys.stdout)
