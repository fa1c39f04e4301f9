"""Scenes: a surface, its effects, outputs and accuracy."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import Final

import numpy as np

from tactometry.arguments.constraints import is_number
from tactometry.arguments.require import expect, of_kind
from tactometry.contact import Contact
from tactometry.errors import InvalidParameter, nearest
from tactometry.signal import Signal

from ..composition.effect import Demand, Effect, FingerContact, Setting, Stage, Surface
from ..defaults import ACCURACY
from .plan import Plan, parted, unit_of
from .requirements import check_effects, required_stages

TOUCHES: Final = (Contact, FingerContact)
ROUNDING = 1e-9
SENSATION = "sensation_db"
N_SIGNALS = 128
"""Number of signals whose contact-independent results are cached; each may contain courses of the whole record."""
N_CONTACTS = 256
OfContact = Callable[[Contact], tuple[float, ...]]
OfSignal = Callable[[Signal], OfContact]


@dataclass(frozen=True)
class Scene:
    """A surface, its effects and the quantities to compute.

    Raises `InvalidParameter` if the accuracy is out of range or there is no output, or if effects fill the same slot,
    contradict each other, do not belong to the surface or lack a requirement.

    Parameters
    ----------
    surface : Surface
    effects : tuple of Effect
        Effects in any order. Other effects are neither computed nor imported.
    outputs : tuple of str
        Names of the quantities to compute.
    accuracy : float
        Tolerated relative error of the outputs, above 0 and at most 1.
    contacts : tuple of FingerContact
        Fingers on the surface.
    settings : mapping
        Settings by name of the stage, which replace the chosen settings.

    >>> from tactometry.stimuli.scenes.effects.force_law import ForceLaw
    >>> from tactometry.stimuli.scenes.surfaces.electrovibration import Electrovibration
    >>> scene = Scene(Electrovibration(240.0, duration_s=0.2), (ForceLaw("sc_layer"),), outputs=("peak_force_n",))
    >>> round(scene.resolve().run({"level_db_re_1v": 40.0})["peak_force_n"], 4)
    0.0213
    """

    surface: Surface
    effects: tuple[Effect, ...]
    outputs: tuple[str, ...]
    accuracy: float = ACCURACY
    contacts: tuple[FingerContact, ...] = ()
    settings: Mapping[str, Mapping[str, Setting]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        of_kind("Scene", Surface, surface=self.surface)
        for name, kind in (("effects", Effect), ("outputs", str), ("contacts", FingerContact)):
            of_kind("Scene", (tuple, list), **{name: getattr(self, name)})
            for n, one in enumerate(getattr(self, name)):
                of_kind("Scene", kind, **{f"{name}[{n}]": one})

        is_share = is_number(self.accuracy) and 0 < self.accuracy <= 1
        expect(is_share, "Scene.accuracy", self.accuracy, "a number above 0 and at most 1")
        if not self.outputs:
            raise InvalidParameter("Scene.outputs: found none, expected at least one quantity")
        check_effects(self.effects, self)

    def find(self, slot: str) -> Effect | None:
        """Return the effect in a slot, or None."""
        return next((effect for effect in self.effects if effect.slot == slot), None)

    def resolve(self) -> Plan:
        """Return the plan of stages, with settings chosen for the accuracy.

        The tolerated error is divided evenly among the stages that are not exact.

        Raises `InvalidParameter` if an output cannot be computed or not with this accuracy, or the settings name an
        unknown stage.
        """
        unsized = self._unsized()
        self._check_outputs()
        called_for = self._called_for(unsized)
        rough = _size_all(unsized, self._demand(called_for, self.accuracy))
        share = self.accuracy / max(1, sum(stage.error > 0 for stage in rough))
        stages = rough if share == self.accuracy else _size_all(unsized, self._demand(called_for, share))
        for stage in stages:
            _check_kept(stage, share)
        given = tuple(name for name in self.surface.given if any(name in stage.needs for stage in stages))
        return Plan(tuple(self._overridden(stages)), given, self.outputs)

    def sensation(self, signal: Signal, contact: Contact) -> float:
        """Return a signal's level (dB) above the detection threshold.

        `contact` replaces the contacts of the scene. The level is ``-inf`` in silence, without contact, and at rest if
        only a sliding finger feels the stimulus. Stages that depend only on the signal run once for each signal.

        Raises `InvalidParameter` if the scene has no sensation level, or its surface cannot play the signal.

        >>> from tactometry.stimuli.electrovibration import CoulombFriction, Sine
        >>> from tactometry.stimuli.scenes.effects.force_law import ForceLaw
        >>> from tactometry.stimuli.scenes.effects.sensitivity import Sensitivity
        >>> from tactometry.stimuli.scenes.surfaces.electrovibration import Electrovibration
        >>> effects = ForceLaw("sc_layer"), CoulombFriction(), Sensitivity()
        >>> touch = FingerContact(1.5, speed_m_per_s=0.05)
        >>> scene = Scene(Electrovibration(60.0), effects, ("sensation_db",), contacts=(touch,))
        >>> loud, soft = (scene.sensation(Sine(60.0).at(level), Contact(1.5, 0.05)) for level in (40.0, 30.0))
        >>> round(loud - soft, 6), scene.sensation(Sine(60.0).at(40.0), Contact(1.5))
        (20.0, -inf)
        """
        return max(self.fingers_db(signal, contact))

    def fingers_db(self, signal: Signal, contact: Contact) -> tuple[float, ...]:
        """Return the level at each finger; `sensation` is the highest."""
        _check_felt(signal, contact)
        return self._of_signal(signal)(contact)

    @cached_property
    def _of_signal(self) -> OfSignal:
        """Return a function from signals and contacts to levels, cached by signal."""
        felt = self.felt()
        early, rest = parted(felt.resolve(), "contact")

        def of_signal(signal: Signal) -> OfContact:
            handed, sounds = early.run({"signal": signal}), bool(signal.samples.any())

            def under(contact: Contact) -> tuple[float, ...]:
                if not (sounds and felt.surface.reaches(contact)):
                    return (-math.inf,) * max(len(felt.surface.names), 1)
                levels_db = rest.run({**handed, "contact": contact})[SENSATION]
                return tuple(np.atleast_1d(levels_db).tolist())

            return lru_cache(maxsize=N_CONTACTS)(under)

        return lru_cache(maxsize=N_SIGNALS)(of_signal)

    def felt(self, output: str = SENSATION) -> "Scene":
        """Return the variant of the scene that plays a given signal.

        Its runs receive a signal and a contact, and return the sensation level or another quantity.

        Effects that a played signal already contains are left out, with all effects on them. The plate keeps the
        effects that define it.

        Raises `InvalidParameter` if the surface cannot play a signal.
        """
        surface = self.surface.played(self)
        held = {effect.slot for effect in self.effects if effect.in_signal}
        effects = tuple(effect for effect in self.effects if held.isdisjoint((effect.slot, *effect.requires)))
        return replace(self, surface=surface, effects=effects, outputs=(output,), contacts=surface.touches)

    def off(self) -> tuple[Effect, ...]:
        """Return the effects that no output needs."""
        on = self._called_for(self._unsized())
        return tuple(effect for effect in self.effects if effect not in on)

    def assumed(self) -> tuple[str, ...]:
        """Describe the assumptions of surface and effects for these outputs."""
        called_for = self._called_for(self._unsized())
        slots = {effect.slot for effect in called_for}
        of_surface = (words for slot, words in self.surface.assumes.items() if slot not in slots)
        return (*of_surface, *(words for effect in called_for for words in effect.assumes))

    def rests_on(self) -> tuple[str, ...]:
        """Describe the constants that set the absolute size of these outputs."""
        return tuple(effect.rests_on for effect in self._called_for(self._unsized()) if effect.rests_on)

    def _check_outputs(self) -> None:
        for n, output in enumerate(self.outputs):
            expected = "a computed quantity; remove it"
            expect(output not in self.surface.given, f"outputs[{n}]", f"{output!r}, an input of each run", expected)
            if not unit_of(output):
                raise InvalidParameter(
                    f"outputs[{n}]: found {output!r}, an internal quantity, expected one with a unit in its name; "
                    "remove it"
                )

    def _unsized(self) -> tuple[Stage, ...]:
        demand = self._demand(self._ordered, self.accuracy)
        stages = [*self.surface.stages(demand)]
        for effect in self._ordered:
            stages += self.surface.stages_of(effect, demand)
        return required_stages(self.outputs, stages, self.surface.given, self.surface.cure)

    @property
    def _ordered(self) -> tuple[Effect, ...]:
        places = list(self.surface.effects)
        return tuple(sorted(self.effects, key=lambda effect: places.index(effect.kind)))

    def _called_for(self, stages: Sequence[Stage]) -> tuple[Effect, ...]:
        on = {stage.effect for stage in stages}
        return tuple(effect for effect in self._ordered if effect.kind in on)

    def _demand(self, effects: tuple[Effect, ...], error: float) -> Demand:
        return Demand(self.surface, effects, self.outputs, self.contacts, error)

    def _overridden(self, stages: Sequence[Stage]) -> Sequence[Stage]:
        by_name = {stage.name: stage for stage in stages}
        for name, settings in self.settings.items():
            _check_known(f"settings.{name}", name, list(by_name), "stage of the plan")
            for key in settings:
                where, chosen = f"settings.{name}.{key}", by_name[name].settings
                _check_known(where, key, list(chosen), f"setting of {name}")
                _check_like(where, settings[key], chosen[key])
        return [_with(stage, self.settings.get(stage.name, {})) for stage in stages]


def _check_felt(signal: object, contact: object) -> None:
    if not (isinstance(signal, Signal) and isinstance(contact, TOUCHES)):  # called often during a session
        of_kind("Scene.sensation", Signal, signal=signal)
        of_kind("Scene.sensation", TOUCHES, contact=contact)


def _size_all(stages: Sequence[Stage], demand: Demand) -> Sequence[Stage]:
    return [stage.sized(demand) for stage in stages]


def _check_kept(stage: Stage, error: float) -> None:
    if stage.error > error * (1 + ROUNDING):
        finest = ", ".join(f"{key} = {value}" for key, value in stage.settings.items())
        raise InvalidParameter(
            f"accuracy: found an error budget of {error:.2g} for {stage.name!r}, expected at least "
            f"{stage.error:.2g}, the error of its finest setting ({finest}); loosen the accuracy"
        )


def _check_known(where: str, name: str, known: Sequence[str], what: str) -> None:
    expect(name in known, where, f"no such {what}", f"one of {', '.join(known) or 'none'}{nearest(name, known)}")


def _check_like(where: str, value: Setting, chosen: Setting) -> None:
    """Raise an error if a setting is not of the kind of the chosen one."""
    whole = isinstance(chosen, int)
    if not isinstance(chosen, (int, float)):
        fits, expected = isinstance(value, type(chosen)), "a text" if isinstance(chosen, str) else "as many numbers"
    else:
        fits = isinstance(value, int if whole else (int, float)) and not isinstance(value, bool)
        fits = fits and math.isfinite(float(value)) and (float(value) > 0 or chosen <= 0)  # type: ignore[arg-type]
        expected = f"a {'whole' if whole else 'finite'} number{' above 0' if chosen > 0 else ''}"
    expect(fits, where, repr(value), f"{expected}, such as {chosen!r}")


def _with(stage: Stage, settings: Mapping[str, Setting]) -> Stage:
    """Return a stage with a user's settings, whose error is unknown."""
    return replace(stage, settings={**stage.settings, **settings}, error=math.inf) if settings else stage
