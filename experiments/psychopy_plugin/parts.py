"""Objects that the code of Builder components uses in an experiment."""

import atexit
from collections.abc import Mapping
from functools import cache
from typing import Any

from tactometry.errors import Stopped
from tactometry.protocols.tasks.task import TrialOutcome
from tactometry.rigs.touch.touch import ConcurrentPlay

from .loop import Loop, Values, of_stimulus, of_touch, of_trial
from .script import PsychoPyStudy

Factors = Mapping[str, float | str]


@cache
def study_of(window: Any, study: str, bench: str) -> PsychoPyStudy:
    """Return the study, shared by components with the same files."""
    shared = PsychoPyStudy(window, study, bench or None)
    atexit.register(shared.close)
    return shared


class StudyPart:
    """Component with its study, cell, and values for the current row."""

    def __init__(self, window: Any, study: str, bench: str, factors: Factors) -> None:
        self.study, self.factors = study_of(window, study, bench), dict(factors)
        self.status: Any = None  # PsychoPy's attribute
        self.values: Values = {}


class TouchPart(StudyPart):
    """Touch on pages of Tactometry. Asks the study's question with `asks`."""

    def __init__(self, window: Any, study: str, bench: str, factors: Factors, *, asks: bool) -> None:
        super().__init__(window, study, bench, factors)
        self.asks, self.outcome = asks, TrialOutcome(())

    def run(self, level: float | None) -> bool:
        """Run to the end. Returns False if Escape was pressed."""
        self.values = {}
        try:
            if self.asks:
                self.outcome = self.study.trial(level, **self.factors)
                self.values = of_trial(self.outcome)
            else:
                self.values = of_touch(self.study.touch(level, **self.factors))
        except Stopped:
            return False
        return True


class StimulusPart(StudyPart):
    """Stimulus that plays during a routine. `stopped` is True after Escape."""

    _beside: ConcurrentPlay | None = None
    stopped = False

    def start(self, level: float | None) -> None:
        self.values = {}
        self._beside = self.study.begin(level, **self.factors)

    def plays(self) -> bool:
        """Return True while the stimulus plays. Call in each frame."""
        try:
            return self._beside is not None and self._beside.look()
        except Stopped:
            self.stopped = True
            return False

    def finish(self) -> None:
        """Set the output to zero at the end of the routine."""
        if self._beside is not None:
            self.values = of_stimulus(self._beside.end()) | {"cut": int(self._beside.cut)}
            self._beside = None


class FormPart(StudyPart):
    """Questionnaire on pages of Tactometry, with a data row for each item."""

    def run(self, name: str, experiment: Any) -> bool:
        """Run to the end. Returns False if Escape was pressed."""
        try:
            self.study.questionnaire(name, experiment)
        except Stopped:
            return False
        return True


def loop_of(name: str, window: Any, study: str, bench: str, factors: Factors) -> Loop:
    """Return the study's procedure as a loop with this name."""
    return study_of(window, study, bench).loop(name, **factors)
