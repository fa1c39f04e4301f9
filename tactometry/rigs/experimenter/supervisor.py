"""Who looks after a session: stops it, pauses it, and writes down what the experimenter wants."""

import time
from collections.abc import Callable, Mapping
from datetime import UTC, datetime, timedelta

from ...devices.outputs.guarded import GuardedSignal
from ...errors import Stopped
from ...session.event import Event, EventLog, Kind
from ...session.request import Fact
from ..pages.page import Display, Input, Page
from ..pages.presenter import reason_to_end
from .terminal import HELP, ExperimenterTerminal, Order

EXPERIMENTER = "the experimenter"
SAFE = "what was recorded is safe: go on with --resume"


def utc_text(clock_s: float) -> str:
    """ISO 8601 of a moment on `time.perf_counter`, by the offset of now."""
    moment = datetime.now(UTC) - timedelta(seconds=time.perf_counter() - clock_s)
    return moment.isoformat(timespec="milliseconds")


class Supervisor:
    """Attends to the participant's Escape key and the experimenter's orders, in each frame.

    Parameters
    ----------
    screen : Display
    terminal : ExperimenterTerminal
    log : EventLog or None
        Where events are kept.
    mute : callable
        ``mute(on=True)`` puts the output to zero and keeps it there.
    page : Page
        What the participant sees in a pause.
    """

    def __init__(
        self,
        screen: Display,
        terminal: ExperimenterTerminal,
        log: EventLog | None,
        mute: Callable[..., None],
        page: Page,
    ) -> None:
        self._screen, self._mute, self._page = screen, mute, page
        self.terminal, self.log = terminal, log
        self.zero_s = time.perf_counter()
        self.under_way = False
        """Whether a trial is."""
        self.repeat = False
        """Whether the trial that is under way is to be repeated."""
        self._wanted = False
        self._n_pauses = 0

    def note(self, kind: Kind, **facts: Fact) -> None:
        """Keep an event, with the time of now."""
        self._keep(kind, time.perf_counter(), facts)

    def _keep(self, kind: Kind, clock_s: float, facts: Mapping[str, Fact], duration_s: float | None = None) -> None:
        if self.log is not None:
            self.log.note(Event(kind, round(clock_s - self.zero_s, 6), utc_text(clock_s), facts, duration_s))

    def note_stimulus(self, emission: GuardedSignal) -> None:
        """Keep a stimulus as it begins: what is kept counts when the session goes on."""
        self._keep("stimulus", emission.onset_s, {"charge_c": emission.charge_c}, emission.duration_s)

    def attend(self, events: tuple[Input, ...]) -> bool:
        """Look at what was pressed and typed: True if the session was paused meanwhile.

        Raises
        ------
        Stopped
            If Escape was pressed, the window closed, or the experimenter wants to stop.
        """
        n_pauses = self._n_pauses
        self._look(events)
        if self._wanted:
            self.pause(EXPERIMENTER, lambda: True)
        return self._n_pauses != n_pauses

    def pause(self, by: str, over: Callable[[], bool]) -> None:
        """The output is at zero and a page says so, until it is over and the experimenter wants no pause."""
        self._mute(on=True)
        self._n_pauses += 1
        self.note("pause", text=by)
        self.terminal.tell(f"paused: {by}" + (" (g goes on)" if self._wanted else ""))
        self._screen.present(self._page)
        while self._wanted or not over():
            self._screen.refresh(self._page)
            self._look(self._screen.events())
        self.note("resume", text=by)
        self.terminal.tell("it goes on")
        self._mute(on=False)

    def _look(self, events: tuple[Input, ...]) -> None:
        why = reason_to_end(events)
        if why is not None:
            raise self.stop(why)
        for order in self.terminal.orders():
            self._obey(order)

    def stop(self, why: str, recorded: str = "") -> Stopped:
        """Put the output to zero for good: what is to be raised, which says what is `recorded`."""
        self._mute(on=True)
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

    def _repeat(self) -> None:
        if not self.under_way:
            self.terminal.tell("no trial is under way that could be repeated")
            return
        self.repeat = True
        self.note("repeat", text=EXPERIMENTER)
        self.terminal.tell("this trial will be asked again")
