"""Scenes in fresh processes.

Run as a program by tests/stimuli/scenes/test_off.py.
It reads pairs of scene files as JSON, without an effect and with it. For each pair a copy is made of a process that has
only run scenes without any effect.
"""

import gc
import json
import sys
from dataclasses import replace

from copies import in_a_copy

from tactometry.stimuli.scenes.file import scene_of


def counted(plan, given):
    """Python and C calls of a run and its preparation; a collection of garbage, whose listeners count, waits."""
    total, fresh, collects = 0, replace(plan), gc.isenabled()

    def count(frame, event, argument):
        nonlocal total
        total += event in {"call", "c_call"}

    gc.disable()
    sys.setprofile(count)
    try:
        fresh.run(given)
    finally:
        sys.setprofile(None)
        if collects:
            gc.enable()
    return total


def told(table):
    """Return loaded modules, stages of the plan and calls of a run."""
    found = scene_of(table)
    plan = found.scene.resolve()
    given = {name: found.given[name] for name in plan.given}
    plan.run(given)
    modules = [name for name in sys.modules if name.startswith(("tactometry.", "numba", "matplotlib"))]
    stages = [[stage.effect, stage.target.partition(":")[0]] for stage in plan.stages]
    return {"modules": modules, "stages": stages, "calls": counted(plan, given)}


def compared(without, with_it):
    """Compare a scene without an effect with the scene that has it.

    Runs both, and the first one again, in a copy of this process.
    """
    return in_a_copy(lambda: [told(without), told(with_it), told(without)])


def _load_libraries():
    import scipy.signal
    from numba import njit

    del scipy
    njit(lambda: 0)()


def main():
    gc.disable()
    surfaces = json.load(sys.stdin)
    plain = {surface: told(bare) for surface, (bare, _) in surfaces.items()}
    _load_libraries()
    effects = {
        surface: {kind: compared(*pair) for kind, pair in pairs.items()} for surface, (_, pairs) in surfaces.items()
    }
    json.dump([plain, effects], sys.stdout)


if __name__ == "__main__":
    main()
