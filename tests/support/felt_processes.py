"""Studies that are felt in processes that know nothing else: a program of tests/experiments/test_scene_in_study.py.

It reads study files by name as JSON, and feels the first stimulus of each in a copy of a process that has felt none.
"""

import gc
import json
import os
import sys

from tactometry.contact import Contact
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.study_file import parse


def modules_of(text):
    """The modules that are there behind a level."""
    cell = next(iter(wire(parse(text.encode(), "study"), "study").cells.values()))
    cell.sensation.sensation_db(cell.stimulus.at(12.0), Contact(1.0, 0.05))
    return [name for name in sys.modules if name.startswith("tactometry.")]


def in_a_copy(text):
    """The same, in a copy of this process."""
    read, write = os.pipe()
    child = os.fork()
    if not child:
        with os.fdopen(write, "w") as answer:
            json.dump(modules_of(text), answer)
        os._exit(0)
    os.close(write)
    with os.fdopen(read) as heard:
        answer = json.load(heard)
    os.waitpid(child, 0)
    return answer


if __name__ == "__main__":
    gc.disable()
    import scipy.signal  # noqa: F401 - slow to load, and of no effect alone

    json.dump({name: in_a_copy(text) for name, text in json.load(sys.stdin).items()}, sys.stdout)
