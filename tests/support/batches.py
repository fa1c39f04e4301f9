"""What tests of batches hold them to: a rule's own run, told what was delivered."""

import numpy as np

from tactometry.protocols.batch.answers import Delivery

LEVELS = np.linspace(-1.0, 41.0, 8)
OUTPUT = Delivery(step=0.75, low=3.0, high=36.0)


def own_run(rule, order, answers, output):
    """The levels that a rule asks for, and its run, told the answers of a track to what was delivered."""
    run, levels = type(rule.begin())(rule, order=tuple(order)), []
    for answer in answers:
        levels.append(run.level)
        run = run.after(int(answer), float(output(run.level)))
    return levels, run
