"""What the rigs have in common that answer each kind of request in their own way."""

from abc import ABC, abstractmethod
from collections.abc import Callable

from ..session.answer import Adjusted, Chosen, Done, Filled, Played, Rated, Touched
from ..session.request import (
    A,
    Adjust,
    Choose,
    Enter,
    Fill,
    Intervene,
    Play,
    Press,
    Rate,
    Record,
    Request,
    Show,
    Slide,
    Wait,
)


class LiveRig(ABC):
    """A rig with a method for each kind of request, which `answer` finds by the name of the kind: `_press` for `Press`.

    The methods are private, so that there is one way in.
    """

    def answer(self, request: Request[A]) -> A:
        method: Callable[[Request[A]], A] = getattr(self, f"_{type(request).__name__.lower()}")
        return method(request)

    @abstractmethod
    def _play(self, request: Play) -> Played: ...

    @abstractmethod
    def _press(self, request: Press) -> Touched: ...

    @abstractmethod
    def _slide(self, request: Slide) -> Touched: ...

    @abstractmethod
    def _choose(self, request: Choose) -> Chosen: ...

    @abstractmethod
    def _rate(self, request: Rate) -> Rated: ...

    @abstractmethod
    def _enter(self, request: Enter) -> Rated: ...

    @abstractmethod
    def _fill(self, request: Fill) -> Filled: ...

    @abstractmethod
    def _adjust(self, request: Adjust) -> Adjusted: ...

    @abstractmethod
    def _wait(self, request: Wait) -> Done: ...

    @abstractmethod
    def _show(self, request: Show) -> Done: ...

    @abstractmethod
    def _record(self, request: Record) -> Done: ...

    def _intervene(self, request: Intervene) -> Done:
        """What came of an intervention: a rig in whose answers there is none is not asked."""
        raise NotImplementedError(f"{type(self).__name__}: found {request}, and its answers hold no intervention")
