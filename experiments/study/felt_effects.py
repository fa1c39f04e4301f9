"""Predict felt effects, omitted effects and loss of contact."""

import math
import textwrap
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, replace
from math import inf
from typing import Any, Final, Protocol, runtime_checkable

import numpy as np

from tactometry.config.strict import fields_of, is_required
from tactometry.contact import Contact
from tactometry.errors import InvalidParameter, LimitExceeded
from tactometry.loading import resolve
from tactometry.signal import Signal
from tactometry.stimuli.arrays import FloatArray
from tactometry.stimuli.composition.effect import Effect, Surface
from tactometry.stimuli.scenes.effects import EFFECTS
from tactometry.stimuli.scenes.explain import error_in_words
from tactometry.stimuli.scenes.scene import Scene

from .cells import WiredCell
from .checks import Strongest
from .experiment import Experiment
from .felt_scene import FeltScene
from .predictions import PredictedJnd, Unfelt, contact_of, played, predicted_jnds, unfelt

WIDTH = 100
SLIDING_M_PER_S = 0.05
"""Speed used to predict whether a sliding finger would feel more than a resting one."""
LONGEST_S = 1.0
"""Longest predicted computing time (s) of an omitted effect. Slower effects are not computed."""
STEPS: Final = 4
CLOSE: Final = 1e-3
"""Accepted relative difference between pull and pressing force. Voltages need one step, burst lengths a few."""


@dataclass(frozen=True)
class LeftOut:
    """Effect that a scene omits.

    - `instead_of`: Effects of the scene that the effect would replace.
    - `change_db`: Change in sensation level if the effect is added with its defaults. None if unknown.
    - `why`: Reason why the change is unknown.
    """

    effect: str
    instead_of: tuple[str, ...] = ()
    change_db: float | None = None
    why: str = ""

    @property
    def words(self) -> str:
        """Effect and change in words.

        >>> LeftOut("receptors", ("sensitivity",), 12.6).words
        'receptors (instead of sensitivity) +12.6 dB'
        >>> LeftOut("weber_fraction", change_db=-1e-15).words
        'weber_fraction +0 dB'
        """
        place = f" (instead of {', '.join(self.instead_of)})" if self.instead_of else ""
        change = f" ({self.why})" if self.change_db is None else f" {round(self.change_db, 6) + 0.0:+.3g} dB"
        return f"{self.effect}{place}{change}"


@dataclass(frozen=True)
class FeltEffects:
    """Predicted sensation of a stimulus at its highest level and touch.

    `finger_rests` is True if only a sliding finger would feel the stimulus.
    """

    stimulus: str
    level: str
    felt: tuple[str, ...]
    left_out: tuple[LeftOut, ...]
    assumed: tuple[str, ...]
    predicted_error: str
    sensation_db: float
    rests_on: tuple[str, ...] = ()
    finger_rests: bool = False

    @property
    def lines(self) -> list[str]:
        """Lines of the prediction, at most 100 columns wide."""
        paragraphs = (
            f"predicted for {self.stimulus} at {self.level}: {self._sensation_words}, computed with the effects "
            f"{', '.join(self.felt)} (predicted error {self.predicted_error})",
            f"effects left out, with their changes: {'; '.join(each.words for each in self.left_out) or 'none'}",
            f"assumptions: {'; '.join(self.assumed) or 'none'}",
            f"the prediction depends on {'; '.join(self.rests_on) or 'no parameter of the scene'}",
        )
        return [line for text in paragraphs for line in textwrap.wrap(text, WIDTH, subsequent_indent="    ")]

    @property
    def _sensation_words(self) -> str:
        if self.sensation_db == -inf:
            return f"not felt{' by a resting finger' if self.finger_rests else ''}"
        rounded_db = round(self.sensation_db, 1)
        return f"{abs(rounded_db):.1f} dB {'below' if rounded_db < 0 else 'above'} threshold"


def felt_effects(experiment: Experiment) -> list[FeltEffects]:
    """Predict the sensation for each set of effects in the study's scenes."""
    firsts: dict[object, tuple[WiredCell, Scene]] = {}
    for cell in experiment.cells.values():
        if isinstance(cell.sensation, FeltScene):
            scene = cell.sensation.scene
            firsts.setdefault(repr((scene.effects, scene.accuracy)), (cell, scene))
    strongest = {one.name: one for one in experiment.strongest()} if firsts else {}
    return [_explanation(cell, scene, strongest[cell.condition.stimulus].level) for cell, scene in firsts.values()]


def _explanation(cell: WiredCell, scene: Scene, level: float) -> FeltEffects:
    contact = contact_of(cell)
    signal = played(cell, level, contact.speed_m_per_s)
    felt_db, felt = scene.sensation(signal, contact), scene.felt()
    off = felt.off()
    idle = (LeftOut(effect.kind, why="no output needs it") for effect in off)
    speed = f"{1e3 * contact.speed_m_per_s:g} mm/s" if contact.speed_m_per_s else "at rest"
    return FeltEffects(
        cell.condition.stimulus,
        f"{level:g} {cell.stimulus.level_unit}, {contact.force_n:g} N, {speed}",
        tuple(effect.kind for effect in scene.effects if effect not in off),
        (*idle, *_left_out(scene, signal, contact, felt_db)),
        felt.assumed(),
        error_in_words(felt.resolve()),
        felt_db,
        felt.rests_on(),
        finger_rests=felt_db == -inf and _is_felt_in_motion(cell, scene, level, contact),
    )


def _is_felt_in_motion(cell: WiredCell, scene: Scene, level: float, contact: Contact) -> bool:
    """Return True if the stimulus is felt only by a sliding finger."""
    if contact.speed_m_per_s:
        return False
    sliding = replace(contact, speed_m_per_s=SLIDING_M_PER_S)
    return scene.sensation(played(cell, level, SLIDING_M_PER_S), sliding) > -inf


def _left_out(scene: Scene, signal: Signal, contact: Contact, felt_db: float) -> Iterator[LeftOut]:
    named = {effect.kind for effect in scene.effects}
    for kind in scene.surface.effects:
        effect_class = resolve(EFFECTS[kind])
        if kind not in named and not effect_class.in_signal:
            yield _change(scene, effect_class, signal, contact, felt_db)


def _change(scene: Scene, effect_class: type[Effect], signal: Signal, contact: Contact, felt_db: float) -> LeftOut:
    """Return the change in sensation level if one effect is added."""
    kind = effect_class.kind
    needed = [name for name, field in fields_of(effect_class).items() if is_required(field)]
    if needed:
        return LeftOut(kind, why=f"requires {', '.join(needed)}")
    others = tuple(effect for effect in scene.effects if not _exclude(scene.surface, effect, effect_class))
    instead_of = tuple(effect.kind for effect in scene.effects if effect not in others)
    try:
        added = effect_class()
        with_it = replace(scene, effects=(*others, added))
        if added in with_it.felt().off():
            return LeftOut(kind, instead_of, why="no felt output needs it")
        if with_it.felt().resolve().predicted_s > LONGEST_S:
            return LeftOut(kind, instead_of, why="not computed")
        with_it_db = with_it.sensation(signal, contact)
    except InvalidParameter:
        return LeftOut(kind, instead_of, why="excluded by the other effects")
    if -inf in (felt_db, with_it_db):  # the difference is not finite
        felt_with_it = "not felt with it" if with_it_db == -inf else "felt with it"
        return LeftOut(kind, instead_of, why=f"{felt_with_it} either" if felt_db == with_it_db else felt_with_it)
    return LeftOut(kind, instead_of, with_it_db - felt_db)


def _exclude(surface: Surface, effect: Effect, other: type[Effect]) -> bool:
    return effect.slot == other.slot or effect.kind in surface.excluded(other) or other.kind in surface.excluded(effect)


@runtime_checkable
class Pressed(Protocol):
    """Sensation model that computes the force between plate and fingers."""

    @property
    def pressers(self) -> tuple[str, ...]:
        """Names of the fingers that share the force of a touch."""

    def contact_force_n(self, signal: Signal, contact: Contact) -> FloatArray:
        """Return contact minus pressing force, ([n_fingers,] n_samples)."""


@dataclass(frozen=True)
class FingerOfStudy:
    """Strongest pull of the plate on a finger or tip, at a pressing force.

    - `level`, `pull_n`: Highest level of the study, and the largest pull of the plate there.
    - `first_level`: Level at which the pull equals the pressing force, so that contact is lost above it.
    - `presser`: Name of the finger or tip.
    """

    stimulus: str
    level_unit: str
    force_n: float
    level: float
    pull_n: float
    first_level: float
    presser: str

    @property
    def lifts_off(self) -> bool:
        """True if contact is lost at the highest level of the study."""
        return self.pull_n > self.force_n

    @property
    def line(self) -> str:
        """Prediction in one sentence."""
        at = f"at {self.level:g} {self.level_unit} ({self.stimulus})"
        pulled = f"the plate pulls the {self.presser} (pressed with {self.force_n:g} N) with {self.pull_n:.2g} N"
        if not self.lifts_off:
            return f"contact holds: {at} {pulled} at most"
        first = f"{self.first_level:.3g} {self.level_unit}"
        return f"contact is lost from {first} on: {at} {pulled}"


def pulled_fingers(experiment: Experiment) -> list[FingerOfStudy]:
    """Return the strongest pull for each finger (or tip) and force."""
    nearest: dict[tuple[float, str], tuple[float, Strongest, Callable[[Signal], float]]] = {}
    strongest = {one.name: one for one in experiment.strongest()}
    for name, sensation, contact in _touches(experiment):
        share_n = contact.force_n / len(sensation.pressers)
        pulls_n = _pulls_n(sensation, contact, strongest[name].signal)
        for number, presser in enumerate(sensation.pressers):
            if pulls_n[number] > nearest.get((share_n, presser), (0.0,))[0]:
                pull_of = _pull_of(sensation, contact, number)
                nearest[share_n, presser] = pulls_n[number], strongest[name], pull_of
    return [_pulled(force_n, presser, *nearest[force_n, presser]) for force_n, presser in sorted(nearest)]


def _touches(experiment: Experiment) -> Iterator[tuple[str, Pressed, Contact]]:
    """Yield each stimulus once for each plate model and force."""
    touches = {}
    for cell in experiment.cells.values():
        force_n = getattr(cell.condition.touch, "force_n", 0.0)
        if isinstance(cell.sensation, Pressed) and force_n > 0:
            touches[cell.condition.stimulus, repr(cell.sensation), force_n] = cell.sensation
    for (name, _, force_n), sensation in touches.items():
        yield name, sensation, Contact(force_n)


def _pulls_n(sensation: Pressed, contact: Contact, signal: Signal) -> list[float]:
    """Return the largest pull (N) of the plate on each finger."""
    lowest_n = np.atleast_2d(sensation.contact_force_n(signal, contact)).min(axis=1, initial=0.0)
    return [max(-force_n, 0.0) for force_n in lowest_n.tolist()]


def _pull_of(sensation: Pressed, contact: Contact, number: int) -> Callable[[Signal], float]:
    return lambda signal: _pulls_n(sensation, contact, signal)[number]


def _pulled(
    force_n: float, presser: str, pull_n: float, strongest: Strongest, pull_of: Callable[[Signal], float]
) -> FingerOfStudy:
    """Find the level at which pull and pressing force are equal.

    Each step is exact if the pull is proportional to the amplitude.
    """
    stimulus, level, pulled_n = strongest.stimulus, strongest.level, pull_n
    in_db = stimulus.level_unit.startswith("dB")
    for _ in range(STEPS):
        level = level - 20 * math.log10(pulled_n / force_n) if in_db else level * force_n / pulled_n
        try:
            pulled_n = pull_of(stimulus.at(level))
        except LimitExceeded:
            break
        if abs(pulled_n / force_n - 1) < CLOSE:
            break
    return FingerOfStudy(
        strongest.name, stimulus.level_unit, force_n, strongest.level, pull_n, first_level=level, presser=presser
    )


@dataclass(frozen=True)
class StudyPrediction:
    """Predictions for a study. `models` are the names of its sensation models."""

    effects: tuple[FeltEffects, ...]
    fingers: tuple[FingerOfStudy, ...]
    models: tuple[str, ...]
    unfelt: tuple[Unfelt, ...] = ()
    jnds: tuple[PredictedJnd, ...] = ()

    @property
    def warnings(self) -> list[str]:
        """Warning lines, one for each condition predicted to be too weak."""
        return [one.line for one in self.unfelt]

    @property
    def lines(self) -> list[str]:
        """Lines printed by a dry run."""
        felt = [line for effects in self.effects for line in effects.lines]
        through = felt or [f"felt by {', '.join(self.models)}, no scene"]
        return [*self.warnings, *(one.line for one in self.jnds), *through, *(finger.line for finger in self.fingers)]

    @property
    def record(self) -> dict[str, list[dict[str, Any]]]:
        """Prediction for JSON. Empty lists of contact, unfelt and jnd are omitted."""
        further = {"contact": self.fingers, "unfelt": self.unfelt, "jnd": self.jnds}
        parts: dict[str, tuple[Any, ...]] = {
            "felt": self.effects,
            **{name: result for name, result in further.items() if result},
        }
        return {name: [asdict(one) for one in result] for name, result in parts.items()}


def predict(experiment: Experiment) -> StudyPrediction:
    """Predict sensation and contact at a study's strongest levels.

    >>> from .experiment import wire
    >>> from .study_file import load
    >>> predict(wire(load("tutorial")[0], "tutorial")).lines[0][:15]
    'predicted for a'
    """
    models = {type(cell.sensation).__name__ for cell in experiment.cells.values()}
    return StudyPrediction(
        tuple(felt_effects(experiment)),
        tuple(pulled_fingers(experiment)),
        tuple(sorted(models)),
        tuple(unfelt(experiment)),
        tuple(predicted_jnds(experiment)),
    )
