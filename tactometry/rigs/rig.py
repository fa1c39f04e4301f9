"""The one interface of everything that answers requests."""

from collections.abc import Sequence
from typing import Protocol

from ..session.request import (
    Adjust,
    Adjusted,
    Choose,
    Chosen,
    Done,
    Enter,
    Fill,
    Filled,
    Play,
    Played,
    Press,
    Rate,
    Rated,
    Record,
    Show,
    Slide,
    Touched,
    Wait,
)
from ..trials.trial import Trial


class Rig(Protocol):
    """Whatever answers: a bench, a simulated participant, a recording, a terminal.

    Only a rig owns a clock. `resume` is called once, before the first live request of a session that goes on after an
    interruption, with the rows that are recorded and the time at which the session stopped. `close` may be called
    more than once and leaves every output at zero.
    """

    def facts(self) -> dict[str, str | int | float | bool | None]:
        """What the journal's head says of display, outputs, clock."""

    def resume(self, trials: Sequence[Trial], elapsed_s: float) -> None: ...

    def close(self) -> None: ...

    def play(self, request: Play) -> Played: ...

    def press(self, request: Press) -> Touched: ...

    def slide(self, request: Slide) -> Touched: ...

    def choose(self, request: Choose) -> Chosen: ...

    def rate(self, request: Rate) -> Rated: ...

    def enter(self, request: Enter) -> Rated: ...

    def fill(self, request: Fill) -> Filled: ...

    def adjust(self, request: Adjust) -> Adjusted: ...

    def wait(self, request: Wait) -> Done: ...

    def show(self, request: Show) -> Done: ...

    def record(self, request: Record) -> Done: ...
