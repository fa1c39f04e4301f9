"""Predictions for a study: effects felt and left out, conditions too weak to feel, fingers that lose contact."""

import textwrap
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from math import inf
from typing import Any

from tactometry.config.strict import fields_of, is_required
from tactometry.contact import Contact
from tactometry.errors import InvalidParameter
from tactometry.loading import resolve
from tactometry.signal import Signal
from tactometry.stimuli.composition.effect import Effect, Surface
from tactometry.stimuli.scenes.effects import EFFECTS
from tactometry.stimuli.scenes.explain import error_in_words
from tactometry.stimuli.scenes.scene import Scene

from .cells import WiredCell
from .contact_loss import FingerOfStudy, pulled_fingers
from .experiment import Experiment
from .felt_scene import FeltScene
from .predictions import PredictedJnd, Unfelt, contact_of, played, predicted_jnds, unfelt

WIDTH = 100
SLIDING_M_PER_S = 0.05
"""Of a finger that moves at all, where a study asks for one at rest."""
LONGEST_S = 1.0
"""An effect that is left out is computed if it takes no longer than this (predicted)."""


@dataclass(frozen=True)
class LeftOut:
    """Effect that a scene does not have.

    Parameters
    ----------
    effect : str
    instead_of : tuple of str
        Effects of the scene that it would take the place of.
    change_db : float or None
        By how much the sensation level would be higher with it, at its defaults; None where that is not known.
    why : str
        Why it is not.
    """

    effect: str
    instead_of: tuple[str, ...] = ()
    change_db: float | None = None
    why: str = ""

    @property
    def words(self) -> str:
        """The effect and its change in a few words.

        >>> LeftOut("receptors", ("sensitivity",), 12.6).words
        'receptors (instead of sensitivity) +12.6 dB'
        >>> LeftOut("weber_fraction", change_db=-1e-15).words
        'weber_fraction +0 dB'
        >>> LeftOut("receptors", change_db=4e-16).words
        'receptors +0 dB'
        """
        place = f" (instead of {', '.join(self.instead_of)})" if self.instead_of else ""
        change = f" ({self.why})" if self.change_db is None else f" {round(self.change_db, 6) + 0.0:+.3g} dB"
        return f"{self.effect}{place}{change}"


@dataclass(frozen=True)
class FeltEffects:
    """Predicted sensation of a stimulus at its highest level and touch."""

    stimulus: str
    level: str
    felt: tuple[str, ...]
    left_out: tuple[LeftOut, ...]
    assumed: tuple[str, ...]
    predicted_error: str
    sensation_db: float
    rests_on: tuple[str, ...] = ()
    finger_rests: bool = False
    """Whether that is why nothing is felt."""

    @property
    def lines(self) -> list[str]:
        """The prediction as lines of at most 100 columns."""
        paragraphs = (
            f"predicted for {self.stimulus} at {self.level}: {self._sensation_words}, computed with the effects "
            f"{', '.join(self.felt)} (predicted error {self.predicted_error})",
            f"effects left out, with their changes: {'; '.join(each.words for each in self.left_out) or 'none'}",
            f"assumptions: {'; '.join(self.assumed) or 'none'}",
            f"the prediction depends on {'; '.join(self.rests_on) or 'no number of the scene'}",
        )
        return [line for text in paragraphs for line in textwrap.wrap(text, WIDTH, subsequent_indent="    ")]

    @property
    def _sensation_words(self) -> str:
        if self.sensation_db == -inf:
            return f"not felt{' by a finger that rests' if self.finger_rests else ''}"
        rounded_db = round(self.sensation_db, 1)
        return f"{abs(rounded_db):.1f} dB {'below' if rounded_db < 0 else 'above'} threshold"


def felt_effects(experiment: Experiment) -> list[FeltEffects]:
    """Predict the first stimulus of each choice of effects.

    Empty for a study without a scene.
    """
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
    return FeltEffects(
        cell.condition.stimulus,
        f"{level:g} {cell.stimulus.level_unit}, {_in_words(contact)}",
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


def _in_words(contact: Contact) -> str:
    speed = f", {1e3 * contact.speed_m_per_s:g} mm/s" if contact.speed_m_per_s else ", at rest"
    return f"{contact.force_n:g} N{speed}"


def _left_out(scene: Scene, signal: Signal, contact: Contact, felt_db: float) -> Iterator[LeftOut]:
    """Return the surface's effects that the scene leaves out."""
    named = {effect.kind for effect in scene.effects}
    for kind in scene.surface.effects:
        effect_class = resolve(EFFECTS[kind])
        if kind not in named and not effect_class.in_signal:
            yield _change(scene, effect_class, signal, contact, felt_db)


def _change(scene: Scene, effect_class: type[Effect], signal: Signal, contact: Contact, felt_db: float) -> LeftOut:
    """Return the change in sensation level with one more default effect."""
    kind = effect_class.kind
    needed = [name for name, field in fields_of(effect_class).items() if is_required(field)]
    if needed:
        return LeftOut(kind, why=f"needs a value of {', '.join(needed)}")
    others = tuple(effect for effect in scene.effects if not _exclude(scene.surface, effect, effect_class))
    instead_of = tuple(effect.kind for effect in scene.effects if effect not in others)
    try:
        added = effect_class()
        with_it = replace(scene, effects=(*others, added))
        if added in with_it.felt().off():
            return LeftOut(kind, instead_of, why="nothing that is felt needs it")
        predicted_s = with_it.felt().resolve().predicted_s
        if predicted_s > LONGEST_S:
            return LeftOut(kind, instead_of, why="not computed")
        with_it_db = with_it.sensation(signal, contact)
    except InvalidParameter:
        return LeftOut(kind, instead_of, why="does not go with the others")
    if -inf in (felt_db, with_it_db):  # no difference that is a number
        felt_with_it = "not felt with it" if with_it_db == -inf else "felt with it"
        return LeftOut(kind, instead_of, why=f"{felt_with_it} either" if felt_db == with_it_db else felt_with_it)
    return LeftOut(kind, instead_of, with_it_db - felt_db)


def _exclude(surface: Surface, effect: Effect, other: type[Effect]) -> bool:
    return effect.slot == other.slot or effect.kind in surface.excluded(other) or other.kind in surface.excluded(effect)


@dataclass(frozen=True)
class StudyPrediction:
    """Predictions for a study.

    Effects felt per stimulus, fingers that are pulled, names of the models, conditions too weak to feel, and the just
    noticeable differences of a comparison.
    """

    effects: tuple[FeltEffects, ...]
    fingers: tuple[FingerOfStudy, ...]
    models: tuple[str, ...]
    unfelt: tuple[Unfelt, ...] = ()
    jnds: tuple[PredictedJnd, ...] = ()

    @property
    def warnings(self) -> list[str]:
        """A line for each condition that is predicted to be too weak."""
        return [one.line for one in self.unfelt]

    @property
    def lines(self) -> list[str]:
        """Lines of the dry run."""
        felt = [line for effects in self.effects for line in effects.lines]
        through = felt or [f"felt by {', '.join(self.models)}, no scene"]
        return [*self.warnings, *(one.line for one in self.jnds), *through, *(finger.line for finger in self.fingers)]

    @property
    def record(self) -> dict[str, list[dict[str, Any]]]:
        """Prediction for JSON; contact, unfelt and jnd only where there are any."""
        contact, unfelt = [asdict(finger) for finger in self.fingers], [asdict(one) for one in self.unfelt]
        jnds = [asdict(one) for one in self.jnds]
        further = {name: told for name, told in (("contact", contact), ("unfelt", unfelt), ("jnd", jnds)) if told}
        return {"felt": [asdict(effects) for effects in self.effects], **further}


def predict(experiment: Experiment) -> StudyPrediction:
    """Predict what participants feel of a study at its strongest levels, and which fingers lose contact.

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
