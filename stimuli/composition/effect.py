"""What a scene is made of: stages, the effects and surfaces that bring them, and what is asked of them.

A stage is sized by what is asked of all, and an effect is asked for stages: they are one contract.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Protocol, TypeVar

from tactometry.errors import InvalidParameter
from tactometry.target import resolve

Answer = TypeVar("Answer")

Setting = float | int | str | tuple[float, ...] | tuple[str, ...]


@dataclass(frozen=True)
class Size:
    """How finely a stage works: settings that the tolerated error chooses, the error that is left, and the work.

    `n_operations` is the predicted number of floating-point operations of one run.
    """

    settings: Mapping[str, Setting] = field(default_factory=dict)
    error: float = 0.0
    n_operations: float = 0.0


@dataclass(frozen=True)
class Stage:
    """One step from quantities to a quantity.

    Parameters
    ----------
    name : str
        What the step is, in the words of `tactometry scene --explain`; a key of ``[settings]`` in a scene file.
    needs : tuple of str
        Names of the quantities that it reads. If `gives` is among them the stage changes that quantity; if not, it
        takes the place of whatever gave it before.
    gives : str
        Name of the quantity.
    target : str
        ``module:function``; the function takes the settings by name and returns the callable of the run, which takes
        the needed quantities in their order. It is imported when the plan is bound, and not before.
    settings : mapping
        Numbers and texts that are fixed when the plan is made.
    error : float
        Predicted relative error of what it gives; 0 for an exact stage.
    n_operations : float
        Predicted number of floating-point operations of one run.
    effect : str
        Kind of the effect that brings it; empty for a stage of the surface.
    size : callable, optional
        What is left to say of settings, error and work: asked for once the stage is known to be needed, so that what
        no output needs is neither computed nor refused.
    """

    name: str
    needs: tuple[str, ...]
    gives: str
    target: str
    settings: Mapping[str, Setting] = field(default_factory=dict)
    error: float = 0.0
    n_operations: float = 0.0
    effect: str = ""
    size: "Callable[[Demand], Size] | None" = field(default=None, repr=False, compare=False)

    @property
    def changes(self) -> bool:
        """Whether it changes a quantity, rather than to make it."""
        return self.gives in self.needs

    def sized(self, demand: "Demand") -> "Stage":
        """The stage with all its settings."""
        if self.size is None:
            return self
        size = self.size(demand)
        settings = {**self.settings, **size.settings}
        return replace(self, settings=settings, error=size.error, n_operations=size.n_operations)

    def bind(self) -> Callable[..., Any]:
        """The callable of the run, with the settings in it."""
        call: Callable[..., Any] = resolve(self.target)(**self.settings)
        return call


@dataclass(frozen=True)
class FingerContact:
    """A finger on the surface.

    Parameters
    ----------
    force_n : float
        Normal force, above 0.
    speed_m_per_s : float
        Of sliding, at least 0; 0 is a finger at rest.
    x_m, y_m : float or None
        Where it rests; None is at the focus.

    >>> FingerContact(1.0, speed_m_per_s=0.05).slides
    True
    """

    force_n: float
    speed_m_per_s: float = 0.0
    x_m: float | None = None
    y_m: float | None = None

    def __post_init__(self) -> None:
        if not 0 < self.force_n < float("inf"):
            raise InvalidParameter(
                f"FingerContact.force_n: found {self.force_n}, expected a finite number above 0; without a finger "
                "leave the contact out"
            )
        if not 0 <= self.speed_m_per_s < float("inf"):
            raise InvalidParameter(
                f"FingerContact.speed_m_per_s: found {self.speed_m_per_s}, expected a finite number, at least 0"
            )

    @property
    def slides(self) -> bool:
        return self.speed_m_per_s > 0


class Surroundings(Protocol):
    """What of a scene an effect may look at."""

    @property
    def surface(self) -> "Surface": ...

    @property
    def contacts(self) -> tuple[FingerContact, ...]: ...

    @property
    def outputs(self) -> tuple[str, ...]: ...

    def find(self, slot: str) -> "Effect | None":
        """The effect in a slot, or None."""


class Effect:
    """An effect of a scene; it imports no physics, its stages name it by target strings.

    `kind` is its name in a scene file. `slot` is its place in the order in which effects act; two effects in one slot
    are refused. `requires` names what must be in the scene beside it: a slot, ``contact``, ``sliding contact`` or
    ``resting contact``. `excludes` names kinds that contradict it, with the reason and the cure. `assumes` says what it
    takes for granted, in words.
    """

    kind: ClassVar[str]
    slot: ClassVar[str]
    requires: ClassVar[tuple[str, ...]] = ()
    excludes: ClassVar[Mapping[str, str]] = {}
    assumes: ClassVar[tuple[str, ...]] = ()

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        """What the effect needs and gives, and no more.

        What its stages compute, refuse or predict stands in their `size`, which is asked for if an output needs them.
        """
        raise NotImplementedError


class Surface:
    """What is touched: it brings the stages that hold without any effect.

    `order` names the slots of all effects in the order in which they act, `effects` their kinds. `given` names the
    quantities that each run is given. `cures` says for a quantity which effect brings it. `assumes` says, by slot, what
    holds as long as no effect fills the slot.
    """

    kind: ClassVar[str]
    order: ClassVar[tuple[str, ...]]
    effects: ClassVar[tuple[str, ...]]
    given: ClassVar[tuple[str, ...]]
    cures: ClassVar[Mapping[str, str]]
    assumes: ClassVar[Mapping[str, str]]

    def stages(self, scene: "Demand") -> tuple[Stage, ...]:
        raise NotImplementedError

    def stages_of(self, effect: Effect, scene: "Demand") -> tuple[Stage, ...]:
        """The stages of an effect on this surface: as it brings them, in its name."""
        return tuple(replace(stage, effect=effect.kind) for stage in effect.stages(scene))


@dataclass(frozen=True)
class Demand:
    """A scene as its stages see it: the effects that its outputs call for, and the error that each stage may add.

    Effects that no output needs are not in it, so that no size of a stage can depend on them.

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
