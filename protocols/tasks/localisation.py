"""Where was it?"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from math import dist

import numpy as np

from tactometry.observers.decisions import Decision, locate
from tactometry.session.answer import Chosen, Touched
from tactometry.session.request import Choose

from .task import Alternative, Over, Presentation, Task, TaskKind, TrialCourse, TrialOutcome


@dataclass(frozen=True)
class Localisation(Task):
    """One of several alternatives (places, foci), drawn at random, then: which? An m-alternative forced choice.

    `target` is the number of the alternative, from 1; chance is one over their number. Of alternatives with places,
    `separation_m` is the distance between the two that are nearest to each other, and `error_m` that of the answered
    one from the right one.
    """

    name = "localisation"

    def trial(self, shown: Presentation, rng: np.random.Generator) -> TrialCourse:
        target = int(rng.integers(1, len(shown.alternatives) + 1))
        chosen = shown.alternatives[target - 1]
        touch: Touched = yield shown.touch.request(chosen.stimulus, shown.level, None)
        separation_m = _separation_m(shown.alternatives)
        outcome = TrialOutcome((touch,), touch, target=target, factors=chosen.factors, separation_m=separation_m)
        if not touch.valid:
            return outcome
        numbers = tuple(range(1, len(shown.alternatives) + 1))
        labels = tuple(alternative.label for alternative in shown.alternatives)
        stimuli = tuple(alternative.stimulus for alternative in shown.alternatives)
        choice: Chosen = yield Choose("which_place", numbers, labels, stimuli)
        outcome = replace(outcome, error_m=_distance_m(chosen, shown.alternatives[choice.option - 1]))
        return outcome.score(choice, correct=choice.option == target)


def _separation_m(alternatives: Sequence[Alternative]) -> float | None:
    """Between the two that are nearest to each other."""
    distances_m = [_distance_m(one, other) for one, other in combinations(alternatives, 2)]
    return min((distance_m for distance_m in distances_m if distance_m is not None), default=None)


def _distance_m(one: Alternative, other: Alternative) -> float | None:
    """Hausdorff's, in whole nanometres: how far a place of either is at most from the nearest of the other; None
    without places."""
    if not (one.places_m and other.places_m):
        return None
    pairs = ((one.places_m, other.places_m), (other.places_m, one.places_m))
    return round(max(min(dist(a, b) for b in those) for these, those in pairs for a in these), 9)


TASK = TaskKind(
    Over,
    example={"over": "place"},
    questions={"which_place": Decision(locate, 1)},
    made=lambda table, form_of: Localisation(),
)
