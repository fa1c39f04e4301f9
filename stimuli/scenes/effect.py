"""What an effect and a surface are: frozen values that say which stages they bring."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Protocol

from tactometry.errors import InvalidParameter

from .stage import Stage

if TYPE_CHECKING:
    from .demand import Demand


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


class Effect(Protocol):
    """An effect of a scene; it imports no physics, its stages name it by target strings.

    `kind` is its name in a scene file. `slot` is its place in the order in which effects act; two effects in one slot
    are refused. `requires` names what must be in the scene beside it: a slot, ``contact``, ``sliding contact`` or
    ``resting contact``. `excludes` names kinds that contradict it, with the reason and the cure. `assumes` says what it
    takes for granted, in words.

    `stages` says what the effect needs and gives, and no more: what its stages compute, refuse or predict stands in
    their `size`, which is asked for if an output needs them.
    """

    kind: ClassVar[str]
    slot: ClassVar[str]
    requires: ClassVar[tuple[str, ...]]
    excludes: ClassVar[Mapping[str, str]]
    assumes: ClassVar[tuple[str, ...]]

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]: ...


class Surface(Protocol):
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

    def stages(self, scene: "Demand") -> tuple[Stage, ...]: ...

    def stages_of(self, effect: Effect, scene: "Demand") -> tuple[Stage, ...]:
        """The stages of an effect on this surface."""
