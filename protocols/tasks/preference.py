"""Pairwise preference."""

from dataclasses import dataclass

import numpy as np

from tactometry.observers.decisions import Decision, most_liked
from tactometry.session.answer import Chosen
from tactometry.session.request import Choose

from .task import Over, Presentation, Reply, Task, TaskKind, TrialCourse, TrialOutcome
from .touch import feel_in_turn


@dataclass(frozen=True)
class Preference(Task):
    """Two alternatives in random order ("which do you prefer?").

    The row contains them as `item` and `item_b` in their order. The response, 1 or 2, is the preferred one, as a
    Bradley-Terry fit requires. Bradley and Terry, Biometrika 39, 324 (1952).
    """

    name = "preference"

    def trial(self, shown: Presentation, rng: np.random.Generator) -> TrialCourse:
        first, second = (shown.alternatives[int(n)] for n in rng.permutation(2))
        touches = yield from feel_in_turn(shown.touch, [first.stimulus, second.stimulus], [shown.level, shown.level])
        if not touches[-1].valid:
            return TrialOutcome(touches, touches[0])
        choice: Chosen = yield Choose("which_preferred", (1, 2), ("1", "2"))
        answer = Reply(choice, choice.option, item=first.label, item_b=second.label)
        return TrialOutcome(touches, touches[0], (answer,))


TASK = TaskKind(
    Over,
    example={"over": "wave"},
    questions={"which_preferred": Decision(most_liked)},
    made=lambda table, form_of: Preference(),
    n_together=2,
)
