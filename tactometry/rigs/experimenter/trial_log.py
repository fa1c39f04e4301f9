"""How each trial went on the bench, and how its clocks stand in each block: noted as events."""

import time
from collections.abc import Callable, Mapping

from ...session.request import Fact
from ...trials.trial import Trial
from ..frame_timing import timing_of
from ..pages.page import Display
from .supervisor import Supervisor

CLOCK = "_clock_offset_s"
"""How a device's facts say by how much our clock is ahead of its own."""


class TrialLog:
    """Collects what belongs to the trial that is under way.

    Parameters
    ----------
    supervisor : Supervisor
        Notes the events.
    screen : Display
    facts : callable
        What the devices say of themselves now.
    """

    def __init__(self, supervisor: Supervisor, screen: Display, facts: Callable[[], Mapping[str, Fact]]) -> None:
        self._supervisor, self._screen, self._facts = supervisor, screen, facts
        self._trial: Trial | None = None
        self._last: tuple[int, int, int] | None = None
        self._block: int | None = None
        self._first: dict[str, tuple[float, float]] = {}
        self._delays_s: list[float] = []
        self._answered_s: float | None = None

    def note_decision(self, gate_delay_s: float | None) -> None:
        """A gate opened so late."""
        self._delays_s += [] if gate_delay_s is None else [gate_delay_s]

    def note_answer(self, at_s: float) -> None:
        """The last key or touch of an answer, on `time.perf_counter`."""
        self._answered_s = at_s

    def begin_trial(self, trial: Trial) -> None:
        """A row is about to be recorded: the first of a trial, another of it, or one of a questionnaire on its own, in
        which the frames are nobody's."""
        self.finish_trial()
        if trial.is_form:
            self._screen.frame_intervals_s()
            return
        if trial.block != self._block:
            self._block = trial.block
            self._note_clocks()
        if trial.key != self._last:
            self._trial, self._last = trial, trial.key

    def finish_trial(self) -> None:
        """Note the trial that was recorded, if there is one that was not noted."""
        trial, self._trial = self._trial, None
        if trial is None:
            return
        self._supervisor.note(
            "trial",
            block=trial.block,
            trial=trial.trial,
            attempt=trial.attempt,
            **timing_of(self._screen.frame_intervals_s(), self._screen.period_s),
            gate_delay_s=round(max(self._delays_s), 6) if self._delays_s else None,
            key_to_record_s=self._key_to_record_s(),
        )
        self._delays_s, self._answered_s = [], None

    def _key_to_record_s(self) -> float | None:
        recorded_s = None if self._supervisor.log is None else self._supervisor.log.recorded_s
        if recorded_s is None or self._answered_s is None:
            return None
        return round(recorded_s - self._answered_s, 6)

    def _note_clocks(self) -> None:
        offsets = {name: value for name, value in self._facts().items() if name.endswith(CLOCK)}
        for name, offset_s in offsets.items():
            if isinstance(offset_s, float):
                device, now_s = name.removesuffix(CLOCK), time.perf_counter()
                first_s, first_offset_s = self._first.setdefault(device, (now_s, offset_s))
                drift = None if now_s == first_s else (offset_s - first_offset_s) / (now_s - first_s)
                self._supervisor.note(
                    "clock",
                    block=self._block,
                    device=device,
                    clock_offset_s=round(offset_s, 6),
                    clock_drift=None if drift is None else float(f"{drift:.3g}"),
                )
