"""What a scene asks of its stages: the effects that its outputs call for, and the error that each stage may add.

Effects that no output needs are not in it, so that no size of a stage can depend on them.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, TypeVar

from .effect import Effect, FingerContact, Surface

Answer = TypeVar("Answer")


@dataclass(frozen=True)
class Demand:
    """A scene as its stages see it.

    Parameters
    ----------
    surface : Surface
    effects : tuple of Effect
        In their order, those alone that an output needs.
    outputs : tuple of str
    contacts : tuple of FingerContact
    error : float
        The relative error that a stage may add.
    """

    surface: Surface
    effects: tuple[Effect, ...]
    outputs: tuple[str, ...]
    contacts: tuple[FingerContact, ...]
    error: float
    _known: dict[Callable[..., Any], Any] = field(default_factory=dict, init=False, repr=False, compare=False)

    def find(self, slot: str) -> Effect | None:
        """The effect in a slot, or None."""
        return next((effect for effect in self.effects if effect.slot == slot), None)

    def once(self, question: "Callable[[Demand], Answer]") -> Answer:
        """The answer to a question that several stages have, computed when it is first asked for.

        >>> from tactometry.stimuli.scenes.surfaces.electrovibration import Electrovibration
        >>> Demand(Electrovibration(240.0), (), ("voltage_v",), (), 0.01).once(lambda demand: demand.error / 2)
        0.005
        """
        if question not in self._known:
            self._known[question] = question(self)
        answer: Answer = self._known[question]
        return answer
