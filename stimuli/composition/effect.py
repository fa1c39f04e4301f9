"""Base classes of a scene: stages, effects, surfaces and the demand."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from math import inf
from typing import Any, ClassVar, Protocol, Self, TypeVar

from tactometry.arguments import require
from tactometry.contact import Contact
from tactometry.errors import InvalidParameter
from tactometry.loading import resolve

from .content import PlateContent, VoltageContent

Answer = TypeVar("Answer")

PLAYED = "signal", "contact"
"""Inputs of each run of a surface that plays a signal."""

Setting = float | int | str | tuple[float, ...] | tuple[str, ...]


def note(words: str, *names: str) -> dict[str, str]:
    """Return a dict that maps each name to the same words."""
    return dict.fromkeys(names, words)


@dataclass(frozen=True)
class Size:
    """Settings of a stage, its remaining error and its operations per run."""

    settings: Mapping[str, Setting] = field(default_factory=dict)
    error: float = 0.0
    n_operations: float = 0.0


@dataclass(frozen=True)
class Stage:
    """One step that computes a quantity from other quantities.

    Parameters
    ----------
    name : str
        Name of the step in `tactometry scene --explain`; a key of ``[settings]`` in a scene file.
    needs : tuple of str
        Names of the quantities that the stage reads. If `gives` is among them, the stage changes that quantity. If not,
        it replaces the earlier stage that computed it.
    gives : str
        Name of the quantity that the stage computes.
    target : str
        ``module:function``, which takes the needed quantities in their order and the settings by name, or
        ``module:Class``, whose instance takes the quantities. It is imported only when the plan is bound.
    settings : mapping
        Numbers and strings that are fixed when the plan is made.
    error : float
        Predicted relative error of the result; 0 for an exact stage.
    n_operations : float
        Predicted number of floating-point operations of one run.
    effect : str
        Kind of the effect that adds the stage; empty for a stage of the surface.
    size : callable, optional
        Computes the remaining settings, error and work. It is called only if an output needs the stage, so that an
        unneeded stage is neither computed nor rejected.
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
        """True if the stage changes a quantity instead of creating it."""
        return self.gives in self.needs

    def sized(self, demand: "Demand") -> "Stage":
        """Return the stage with all its settings."""
        if self.size is None:
            return self
        size = self.size(demand)
        settings = {**self.settings, **size.settings}
        return replace(self, settings=settings, error=size.error, n_operations=size.n_operations)

    def bind(self) -> Callable[..., Any]:
        """Import the target and return it as a callable with its settings."""
        called = resolve(self.target)
        return called(**self.settings) if isinstance(called, type) else partial(called, **self.settings)


@dataclass(frozen=True)
class FingerContact:
    """A finger on the surface.

    Parameters
    ----------
    force_n : float
        Normal force, above 0.
    speed_m_per_s : float
        Sliding speed, at least 0; 0 is a finger at rest.
    x_m : float or None
        Place of the finger along the length. Default: at the focus.
    y_m : float or None
        Place of the finger along the width. Default: at the focus.

    >>> FingerContact(1.0, speed_m_per_s=0.05).slides
    True
    """

    force_n: float
    speed_m_per_s: float = 0.0
    x_m: float | None = None
    y_m: float | None = None

    def __post_init__(self) -> None:
        pressed = "a finite number above 0; omit the contact if there is no finger"
        require.expect(0 < self.force_n < inf, "FingerContact.force_n", self.force_n, pressed)
        require.not_negative("FingerContact", speed_m_per_s=self.speed_m_per_s)

    @property
    def slides(self) -> bool:
        return self.speed_m_per_s > 0


class Surroundings(Protocol):
    """The part of a scene that an effect can access."""

    @property
    def surface(self) -> Any:
        """The `Surface` of the scene; an effect uses the fields of its own surface."""

    @property
    def effects(self) -> "tuple[Effect, ...]": ...

    @property
    def contacts(self) -> tuple[FingerContact, ...]: ...

    @property
    def outputs(self) -> tuple[str, ...]: ...

    def find(self, slot: str) -> "Effect | None":
        """Return the effect in a slot, or None."""


class Effect:
    """An effect of a scene, called to compute, with its fields as settings.

    ============ ==================================================================================
    `kind`       name in a scene file
    `slot`       place that one effect of a scene may fill; by default the kind
    `requires`   slots, ``contact``, ``sliding contact`` or ``resting contact`` that the scene must have
    `excludes`   kinds that contradict it, with the reason and the cure; `felt_excludes` replaces it
                 where a signal is played and no time course is computed
    `assumes`    its assumptions, in words
    `rests_on` the constant that sets the absolute size of its result
    `cures` for missing quantities: how to add this effect
    `in_signal`  whether a played signal already contains it, or the plate on which the signal was learnt
    ============ ==================================================================================

    The value is called with the quantities `reads` and returns `gives`, in a stage named after the kind or
    `stage_name`. Fields named in `positive` and `not_negative` are checked. A module of an effect imports the physics
    that only this effect needs when it runs. The place of its line in `tactometry.stimuli.scenes.effects` is where it
    acts.

    >>> from dataclasses import dataclass
    >>> @dataclass(frozen=True)
    ... class Halving(Effect):
    ...     kind, reads, gives = "halving", ("peak_m",), "peak_m"
    ...     share: float = 0.5
    ...
    ...     def __call__(self, peak_m: float) -> float:
    ...         return self.share * peak_m
    >>> Halving().stage().settings, Halving()(3.0)
    ({'share': 0.5}, 1.5)
    """

    kind: ClassVar[str]
    slot: ClassVar[str]
    requires: ClassVar[tuple[str, ...]] = ()
    excludes: ClassVar[Mapping[str, str]] = {}
    felt_excludes: ClassVar[Mapping[str, str] | None] = None
    assumes: ClassVar[tuple[str, ...]] = ()
    rests_on: ClassVar[str] = ""
    cures: ClassVar[Mapping[str, str]] = {}
    reads: ClassVar[tuple[str, ...]] = ()
    gives: ClassVar[str]
    stage_name: ClassVar[str] = ""
    positive: ClassVar[tuple[str, ...]] = ()
    not_negative: ClassVar[tuple[str, ...]] = ()
    in_signal: ClassVar[bool] = False

    def __init_subclass__(cls) -> None:
        if hasattr(cls, "kind") and not hasattr(cls, "slot"):
            cls.slot = cls.kind

    def __post_init__(self) -> None:
        require.positive(type(self).__name__, **{name: getattr(self, name) for name in self.positive})
        require.not_negative(type(self).__name__, **{name: getattr(self, name) for name in self.not_negative})

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        """Return the stages of the effect; by default the value itself.

        The `size` of a stage is called only if an output needs the stage; it may raise if the error is unreachable.
        """
        return (self.stage(),)

    def felt_stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        """Return the stages for a played signal whose sensation is the output.

        A linear effect acts on steady-state components, so that no time course is computed.
        """
        return self.stages(scene)

    def stage(self) -> Stage:
        """Return the stage that calls this effect."""
        target = f"{type(self).__module__}:{type(self).__qualname__}"
        return Stage(self.stage_name or self.kind, self.reads, self.gives, target, dict(vars(self)), size=self.size)

    def size(self, demand: "Demand") -> Size:
        """Return settings, error and work. Raises if the error is unreachable."""
        return Size()

    def in_voltage(self, scene: Surroundings) -> VoltageContent:
        """Return the content that the effect adds to voltage and force."""
        return VoltageContent()

    def in_plate(self, scene: Surroundings) -> PlateContent:
        """Return the content that the effect adds to the plate's motion."""
        return PlateContent()

    def in_setup(self) -> Mapping[str, Any]:
        """Return the `Setup` fields that the effect sets in played signals."""
        return {}

    def wavenumber_rad_per_m(self, plate: Any, frequency_hz: float) -> float | None:
        """Return the wavenumber if the effect changes it, else None."""
        return None


def is_changed(quantity: str, scene: Surroundings) -> bool:
    """Return True if an effect changes a quantity, so that shortcuts fail."""
    return any(quantity in effect.reads and effect.gives == quantity for effect in scene.effects)


class Quantity(Effect):
    """An effect that is itself the quantity it provides, such as a law."""

    def __call__(self) -> Self:
        return self


class Alteration(Effect):
    """An effect that copies its fields into the one quantity that it reads.

    `sets` maps the names of the fields to their names in the quantity where these differ.

    >>> from dataclasses import dataclass
    >>> @dataclass(frozen=True)
    ... class Gap(Alteration):
    ...     sets = {"gap_m": "force_n"}
    ...     gap_m: float
    >>> Gap(2.0)(FingerContact(1.0)).force_n
    2.0
    """

    sets: ClassVar[Mapping[str, str]] = {}

    def __call__(self, quantity: Any) -> Any:
        return replace(quantity, **{self.sets.get(name, name): value for name, value in vars(self).items()})


class Surface:
    """A touched surface, with the stages that need no effect.

    `effects` maps the supported kinds, in the order in which they act, to their classes. `given` names the inputs of
    each run. `touches` are representative fingers for surfaces whose runs receive a contact. If `is_played`, each run
    receives a signal and a contact, and effects contribute their `felt_stages`. `assumes` maps a slot to the assumption
    that applies while no effect fills it. `refuses` maps an unsupported kind to the reason and its replacement.
    """

    kind: ClassVar[str]
    effects: ClassVar[Mapping[str, str]]
    given: ClassVar[tuple[str, ...]]
    assumes: ClassVar[Mapping[str, str]]
    touches: ClassVar[tuple[FingerContact, ...]] = ()
    refuses: ClassVar[Mapping[str, str]] = {}
    is_played: ClassVar[bool] = False

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the fingers whose results are labelled; empty for one."""
        return ()

    def stages(self, scene: "Demand") -> tuple[Stage, ...]:
        raise NotImplementedError

    def played(self, scene: Surroundings) -> "Surface":
        """Return the variant of this surface that plays a given signal.

        Raises `InvalidParameter` if the surface cannot play a signal.
        """
        if self.is_played:
            return self
        raise InvalidParameter(
            f"surface.kind: found {self.kind!r}, which cannot play a signal, expected a surface that can"
        )

    def reaches(self, contact: Contact) -> bool:
        """Return True if the surface reaches the skin under a contact."""
        return contact.force_n > 0

    def excluded(self, effect: Effect | type[Effect]) -> Mapping[str, str]:
        """Return the kinds that contradict an effect on this surface, and why."""
        return effect.excludes if effect.felt_excludes is None or not self.is_played else effect.felt_excludes

    def stages_of(self, effect: Effect, scene: "Demand") -> tuple[Stage, ...]:
        """Return the stages of an effect on this surface, marked with its kind."""
        stages = effect.felt_stages(scene) if self.is_played else effect.stages(scene)
        return tuple(replace(stage, effect=effect.kind) for stage in stages)

    def cure(self, quantity: str) -> str:
        """Return advice on which effect to add for a quantity, or ""."""
        cures = (resolve(target).cures for target in self.effects.values())
        return next((of_effect[quantity] for of_effect in cures if quantity in of_effect), "")


@dataclass(frozen=True)
class Demand:
    """The effects that the outputs of a scene need and the error per stage.

    Effects that no output needs are left out, so that no stage's size depends on them.

    Parameters
    ----------
    surface : Surface
        Surface of the scene; an effect uses the fields of its own surface.
    effects : tuple of Effect
        The effects that an output needs, in order.
    outputs : tuple of str
    contacts : tuple of FingerContact
    error : float
        Relative error that a stage may add.
    """

    surface: Any
    effects: tuple[Effect, ...]
    outputs: tuple[str, ...]
    contacts: tuple[FingerContact, ...]
    error: float
    _known: dict[Callable[..., Any], Any] = field(default_factory=dict, init=False, repr=False, compare=False)

    def find(self, slot: str) -> Effect | None:
        """Return the effect in a slot, or None."""
        return next((effect for effect in self.effects if effect.slot == slot), None)

    def once(self, question: "Callable[[Demand], Answer]") -> Answer:
        """Return the result of a function that several stages share, cached.

        >>> from tactometry.stimuli.scenes.surfaces.electrovibration import Electrovibration
        >>> Demand(Electrovibration(240.0), (), ("voltage_v",), (), 0.01).once(lambda demand: demand.error / 2)
        0.005
        """
        if question not in self._known:
            self._known[question] = question(self)
        answer: Answer = self._known[question]
        return answer
