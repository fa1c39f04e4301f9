"""The course of a procedure, and of a session, under given answers."""

import numpy as np

from tactometry.protocols.batch.answers import Delivery
from tactometry.session.answer import Done
from tactometry.session.request import Record


def follow(rule, answers):
    """Return the levels that a rule asked for until it ended, and the rule after these answers."""
    levels = []
    for answer in answers:
        if rule.finished:
            break
        levels.append(rule.level)
        rule = rule.after(answer)
    return levels, rule


def with_row(progress, row, aborted=None):
    return progress.after(Record(row, aborted), Done(progress.at_s + 1.0))


LEVELS = np.linspace(-1.0, 41.0, 8)
OUTPUT = Delivery(step=0.75, low=3.0, high=36.0)


def own_run(rule, order, answers, output):
    """Return a rule's levels and its run after these answers."""
    run, levels = type(rule.begin())(rule, order=tuple(order)), []
    for answer in answers:
        levels.append(run.level)
        run = run.after(int(answer), float(output(run.level)))
    return levels, run
