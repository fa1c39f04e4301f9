"""Localisation among alternatives."""

from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import combinations
from math import dist

import numpy as np

from tactometry.observers.decisions import Decision, locate
from tactometry.session.answer import Chosen, Touched
from tactometry.session.request import Choose

from .task import Over, Places, Presentation, Task, TaskKind, TrialCourse, TrialOutcome


@dataclass(frozen=True)
class Localisation(Task):
    """Forced choice among m alternatives, which are places or foci.

    `target` is the number of the alternative, from 1. The chance level is 1 / m. For alternatives with places,
    `separation_m` is the smallest distance between two of them, and `error_m` the distance of the answer from the
    target.
    """

    name = "localisation"

    def trial(self, shown: Presentation, rng: np.random.Generator) -> TrialCourse:
        target = int(rng.integers(1, len(shown.alternatives) + 1))
        chosen = shown.alternatives[target - 1]
        touch: Touched = yield shown.touch.request(chosen.stimulus, shown.level, None)
        separation_m = _separation_m(tuple(alternative.places_m for alternative in shown.alternatives))
        outcome = TrialOutcome((touch,), touch, target=target, factors=chosen.factors, separation_m=separation_m)
        if not touch.valid:
            return outcome
        numbers = tuple(range(1, len(shown.alternatives) + 1))
        labels = tuple(alternative.label for alternative in shown.alternatives)
        stimuli = tuple(alternative.stimulus for alternative in shown.alternatives)
        choice: Chosen = yield Choose("which_place", numbers, labels, stimuli)
        outcome = replace(outcome, error_m=_distance_m(chosen.places_m, shown.alternatives[choice.option - 1].places_m))
        return outcome.score(choice, correct=choice.option == target)


@lru_cache(maxsize=256)  # equal in every trial of a track
def _separation_m(alternatives: tuple[Places, ...]) -> float | None:
    """Return the smallest distance between two alternatives."""
    distances_m = [_distance_m(one, other) for one, other in combinations(alternatives, 2)]
    return min((distance_m for distance_m in distances_m if distance_m is not None), default=None)


def _distance_m(one: Places, other: Places) -> float | None:
    """Return the Hausdorff distance (whole nm), or None without places."""
    if not (one and other):
        return None
    pairs = ((one, other), (other, one))
    return round(max(min(dist(a, b) for b in those) for these, those in pairs for a in these), 9)


TASK = TaskKind(
    Over,
    example={"over": "place"},
    questions={"which_place": Decision(locate, 1)},
    made=lambda table, form_of: Localisation(),
)
