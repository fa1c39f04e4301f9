"""Where was it?"""

from dataclasses import dataclass

import numpy as np

from tactometry.observers.decisions import Decision, locate
from tactometry.session.answer import Chosen, Touched
from tactometry.session.request import Choose

from .task import Over, Presentation, Task, TaskKind, TrialCourse, TrialOutcome


@dataclass(frozen=True)
class Localisation(Task):
    """One of several alternatives (places, foci), drawn at random, then: which? An m-alternative forced choice.

    `target` is the number of the alternative, from 1; chance is one over their number.
    """

    name = "localisation"

    def trial(self, shown: Presentation, rng: np.random.Generator) -> TrialCourse:
        target = int(rng.integers(1, len(shown.alternatives) + 1))
        chosen = shown.alternatives[target - 1]
        touch: Touched = yield shown.touch.request(chosen.stimulus, shown.level, None)
        outcome = TrialOutcome((touch,), touch, target=target, factors=chosen.factors)
        if not touch.valid:
            return outcome
        numbers = tuple(range(1, len(shown.alternatives) + 1))
        labels = tuple(alternative.label for alternative in shown.alternatives)
        stimuli = tuple(alternative.stimulus for alternative in shown.alternatives)
        choice: Chosen = yield Choose("which_place", numbers, labels, stimuli)
        return outcome.score(choice, correct=choice.option == target)


TASK = TaskKind(
    Over,
    example={"over": "place"},
    questions={"which_place": Decision(locate, 1)},
    made=lambda table, form_of: Localisation(),
)
