"""Reference for batch tests: the single run of a rule."""

import numpy as np

from tactometry.protocols.batch.answers import Delivery

LEVELS = np.linspace(-1.0, 41.0, 8)
OUTPUT = Delivery(step=0.75, low=3.0, high=36.0)


def own_run(rule, order, answers, output):
    """Return a rule's levels and its run after these answers."""
    run, levels = type(rule.begin())(rule, order=tuple(order)), []
    for answer in answers:
        levels.append(run.level)
        run = run.after(int(answer), float(output(run.level)))
    return levels, run
