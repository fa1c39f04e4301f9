"""Supervision of a session: stops, pauses, orders, log of trials and clocks."""

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from typing import Final

from ...errors import Stopped
from ...session.answer import Intervention
from ...session.event import Event, EventLog, Kind, order_facts
from ...session.request import Fact, Intervene
from ...trials.trial import Trial, without
from ..frame_timing import timing_of
from ..pages.page import Display, Input, Page
from ..pages.presenter import CLOSED, linger, reason_to_end
from .terminal import HELP, ExperimenterTerminal, Order

EXPERIMENTER = "the experimenter"
WHEN: Final = "noted; it takes effect after this trial or page"
SAFE = "recorded data are safe: continue with --resume"
STOPPED_S: Final = 10.0
"""Duration of the page that asks the participant to call the experimenter (unverified default). A key ends it
earlier."""
CLOCK = "_clock_offset_s"
"""Suffix of facts that state the offset of a device: local clock minus device clock, s."""


def utc_text(clock_s: float) -> str:
    """Format a time on `time.perf_counter` as ISO 8601."""
    moment = datetime.now(UTC) - timedelta(seconds=time.perf_counter() - clock_s)
    return moment.isoformat(timespec="milliseconds")


@dataclass(eq=False)
class Supervisor:
    """Handler of the participant's Escape key and the experimenter's orders.

    - `mute`: ``mute(on=True)`` sets the output to zero and keeps it there.
    - `page`: Page shown to the participant during a pause.
    - `stopped_page`: Page shown after Escape, for `STOPPED_S` or until the next key.
    - `zero_s`: Start of the session on `time.perf_counter`.
    - `under_way`, `repeat`: True while a trial is running, and True if it will be repeated.
    - `last`: Last recorded trial.
    """

    screen: Display
    terminal: ExperimenterTerminal
    log: EventLog | None
    mute: Callable[..., None]
    page: Page
    stopped_page: Page
    zero_s: float = field(default_factory=time.perf_counter)
    under_way: bool = False
    repeat: bool = False
    last: Trial | None = None

    def __post_init__(self) -> None:
        self._wanted, self._n_pauses = False, 0
        self._interventions: tuple[Intervention, ...] = ()

    def note(self, kind: Kind, **facts: Fact) -> None:
        self._keep(kind, time.perf_counter(), facts)

    def _keep(self, kind: Kind, clock_s: float, facts: Mapping[str, Fact], duration_s: float | None = None) -> None:
        if self.log is not None:
            self.log.note(Event(kind, round(clock_s - self.zero_s, 6), utc_text(clock_s), facts, duration_s))

    def note_stimulus(self, onset_s: float, duration_s: float, charge_c: float) -> None:
        """Record a stimulus at its onset, so that a resumed session counts it."""
        self._keep("stimulus", onset_s, {"charge_c": charge_c}, duration_s)

    def note_stimulus_end(self, charge_c: float) -> None:
        """Record the charge that the last stimulus passed, replacing the first value."""
        self.note("stimulus_end", charge_c=charge_c)

    def attend(self, events: tuple[Input, ...]) -> bool:
        """Handle key presses and orders. Return True if the session was paused.

        Raises `Stopped` after Escape, a closed window, or an order to stop.
        """
        n_pauses = self._n_pauses
        self._look(events)
        if self._wanted:
            self.pause(EXPERIMENTER, lambda: True)
        return self._n_pauses != n_pauses

    def pause(self, by: str, over: Callable[[], bool]) -> None:
        """Pause with the output at zero until `over` and the experimenter agree."""
        self.mute(on=True)
        self._n_pauses += 1
        self.note("pause", text=by)
        self.terminal.tell(self.terminal.phrase("paused", by=by) + (" (g goes on)" if self._wanted else ""))
        self.screen.present(self.page)
        while self._wanted or not over():
            self.screen.refresh(self.page)
            self._look(self.screen.events())
        self.note("resume", text=by)
        self.terminal.tell(self.terminal.phrase("goes_on"))
        self.mute(on=False)

    def _look(self, events: tuple[Input, ...]) -> None:
        why = reason_to_end(events)
        if why is not None:
            stopped = self.stop(why)
            if why != CLOSED:
                linger(self.screen, self.stopped_page, STOPPED_S)
            raise stopped
        for order in self.terminal.orders():
            self._obey(order)

    def stop(self, why: str, recorded: str = "") -> Stopped:
        """Set the output to zero permanently and return the exception to raise."""
        self.mute(on=True)
        self.note("stop", text=why)
        return Stopped(f"{why}; {SAFE}{recorded}")

    def _obey(self, order: Order) -> None:
        match order.wish:
            case "stop":
                raise self.stop("the experimenter stopped the session")
            case "pause" | "go":
                self._wanted = order.wish == "pause"
            case "note":
                self.note("remark", text=order.text)
                self.terminal.tell("noted")
            case "repeat":
                self._repeat()
            case "help":
                self.terminal.tell(HELP)
                self.terminal.tell(self.terminal.status_text)
            case "invalidate":
                if self.last is None:
                    self.terminal.tell("no trial has been recorded yet, so none can be invalidated")
                elif not self.last.valid:
                    self.terminal.tell(f"trial {self.last.trial} is already invalid")
                else:
                    self._intervene(Intervention("invalidate", self.last.key), f"trial {self.last.trial}: {WHEN}")
            case "skip" | "rest" | "end":
                self._intervene(Intervention(order.wish), WHEN)

    def _repeat(self) -> None:
        if not self.under_way:
            self.terminal.tell("no trial is running, so none can be repeated")
            return
        self.repeat = True
        self.note("repeat", text=EXPERIMENTER)
        self.terminal.tell("this trial will be repeated")

    def _intervene(self, intervention: Intervention, words: str) -> None:
        if intervention in self._interventions:
            self.terminal.tell(f"already {WHEN}")
            return
        self._interventions += (intervention,)
        self.note("order", **order_facts(intervention))
        self.terminal.tell(words)

    def goes_on_with(self, trials: Sequence[Trial]) -> None:
        """Restore the last trial and the pending orders of an earlier sitting."""
        self._recorded(trials)
        self._interventions = () if self.log is None else self.log.wanted
        for intervention in self._interventions:
            self.terminal.tell(f"pending order from the last sitting: {intervention.wanted}")

    def _recorded(self, trials: Iterable[Trial]) -> None:
        self.last = next((trial for trial in reversed(tuple(trials)) if not trial.is_form), self.last)

    def end_trial(self, trial: Trial) -> None:
        self.under_way = self.repeat = False
        self._recorded([trial])

    def take_interventions(self) -> tuple[Intervention, ...]:
        """Return and clear the interventions since the last call."""
        taken, self._interventions = self._interventions, ()
        return taken

    def carry_out(self, request: Intervene) -> None:
        """Report the result of an intervention."""
        if self.last is not None:
            (self.last,) = without([self.last], request.retracted)
        self.terminal.tell(request.said)


class TrialLog:
    """Collector of the current trial's timing, which `supervisor` records."""

    def __init__(self, supervisor: Supervisor, screen: Display, facts: Callable[[], Mapping[str, Fact]]) -> None:
        self._supervisor, self._screen, self._facts = supervisor, screen, facts
        self._trial: Trial | None = None
        self._last: tuple[int, int, int] | None = None
        self._block: int | None = None
        self._first: dict[str, tuple[float, float]] = {}
        self._delays_s: list[float] = []
        self._answered_s: float | None = None

    def note_decision(self, gate_delay_s: float | None) -> None:
        self._delays_s += [] if gate_delay_s is None else [gate_delay_s]

    def note_answer(self, at_s: float) -> None:
        """Store the time of the last key or touch of an answer (`time.perf_counter`)."""
        self._answered_s = at_s

    def begin_trial(self, trial: Trial) -> None:
        """Prepare for the row of a new trial, the same trial, or a questionnaire."""
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
        """Note the timing of the recorded trial, once."""
        trial, self._trial = self._trial, None
        if trial is None:
            return
        log = self._supervisor.log
        recorded_s = None if log is None else log.recorded_s
        key_to_record_s = None
        if recorded_s is not None and self._answered_s is not None:
            key_to_record_s = round(recorded_s - self._answered_s, 6)
        self._supervisor.note(
            "trial",
            block=trial.block,
            trial=trial.trial,
            attempt=trial.attempt,
            **timing_of(self._screen.frame_intervals_s(), self._screen.period_s),
            gate_delay_s=round(max(self._delays_s), 6) if self._delays_s else None,
            key_to_record_s=key_to_record_s,
        )
        self._delays_s, self._answered_s = [], None

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
