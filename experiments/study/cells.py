"""Wire the cells of a design: named stimuli and touch conditions."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tactometry.arguments.require import expect
from tactometry.config.strict import as_table, build, build_kind, kind_of
from tactometry.config.toml import merge
from tactometry.errors import Gathered, InvalidParameter, nearest, rewording
from tactometry.loading import resolve
from tactometry.protocols.block_state import Condition
from tactometry.protocols.tasks.touch import Sliding, Touch
from tactometry.rigs.simulated import Sensation
from tactometry.signal import Stimulus
from tactometry.trials.cells import cell as cell_text
from tactometry.user_code import is_own

from .felt_scene import felt, felt_scene
from .kinds import DEFAULT_SCENE, OWN, STIMULI, TOUCHES, StimulusKind
from .own_parts import OwnStimulus, sensation_class, stimulus_class as own_stimulus_class
from .procedure_table import ReadyProcedure, rule_of, without
from .study import VARIED, Study

Factors = Mapping[str, float | str]


@dataclass(frozen=True)
class WiredCell:
    """Cell of a design: condition, stimulus, procedure, sensation and surface."""

    condition: Condition
    stimulus: Stimulus
    procedure: ReadyProcedure
    sensation: Sensation
    modality: str = ""


def tables(study: Study, factors: Factors) -> dict[str, dict[str, Any]]:
    """Return the study's tables, changed by the variants of a cell's levels."""
    of_cell = {name: dict(getattr(study, name)) for name in VARIED}
    for factor, level in factors.items():
        for name, change in study.variants.get(factor, {}).get(cell_text(level), {}).items():
            of_cell[name] = merge(of_cell[name], change)
    return of_cell


class Wiring:
    """Builder of a study's cells. Parts that cells share are built once.

    Custom code is imported from the folder `code_from`, and rejected without that folder. If `plays` is False, custom
    code and files are not used.
    """

    def __init__(self, study: Study, code_from: Path | None = None, *, plays: bool = True) -> None:
        self.study, self._code_from, self._plays = study, code_from, plays
        self._sensations: dict[str, Sensation] = {}
        self._procedures: dict[str, ReadyProcedure] = {}

    def cell(self, factors: Factors) -> WiredCell:
        """Wire a cell of the design.

        Raises `InvalidParameter` if a table has an unknown key or invalid value, or a factor changes nothing.
        """
        of = tables(self.study, factors)
        mistakes = Gathered()
        with mistakes.part():
            procedure = self.procedure(of["procedure"])
        with mistakes.part():
            condition, stimulus, kind, sensation = self._played(of, factors)
        mistakes.end()
        return WiredCell(condition, stimulus, procedure, sensation, kind.surface)

    def _played(
        self, of: Mapping[str, Mapping[str, Any]], factors: Factors
    ) -> tuple[Condition, Stimulus, StimulusKind, Sensation]:
        touch_class = resolve(kind_of(of["touch"], "touch", TOUCHES))
        kind, stimulus_class = self._kind(of["stimulus"], factors, touch_class)
        slides, found = touch_class is Sliding, f"'slide' with the stimulus {of['stimulus']['kind']!r}"
        pressed = "'press', as a sliding finger leaves the focus; use 'hybrid' for focus and friction together"
        expect(not (kind.stands and slides), "touch.kind", found, pressed)
        resting = "'slide', as a resting finger feels no texture"
        expect(not kind.follows or slides, "touch.kind", "'press' with a texture", resting)
        self._check_effect(factors, of, stimulus_class, touch_class)
        stimulus = self._stimulus(kind, of["stimulus"], factors, stimulus_class)
        stated = _keys(of["touch"], factors, touch_class)
        touch: Touch = build(touch_class, stated, "touch", duration_s=stimulus.duration_s)
        if kind.follows and isinstance(touch, Sliding):
            with rewording(lambda words: words.replace(stimulus_class.__name__, "stimulus", 1)):
                stimulus.check_motion(touch.speed_m_per_s)
        condition = Condition(
            dict(factors),
            self._name(of["stimulus"]["kind"], factors, stimulus_class),
            stimulus.level_unit,
            touch,
            touch.speed_m_per_s if isinstance(touch, Sliding) else None,
        )
        return condition, stimulus, kind, self._felt(kind, of, stimulus, touch)

    def _kind(self, table: Mapping[str, Any], factors: Factors, touch_class: type) -> tuple[StimulusKind, Any]:
        if not is_own(table.get("kind")):
            kind: StimulusKind = kind_of(table, "stimulus", STIMULI)
            return kind, resolve(kind.stimulus)
        of_touch = touch_class.__dataclass_fields__  # type: ignore[attr-defined]
        of_stimulus = [name for name in factors if name not in of_touch and name not in self.study.variants]
        return OWN, own_stimulus_class(table, of_stimulus, of_touch, self._code_from, plays=self._plays)

    def _stimulus(self, kind: StimulusKind, stated: Mapping[str, Any], factors: Factors, stimulus_class: Any) -> Any:
        table = self._located(_keys(stated, factors, stimulus_class))
        parts = {
            key: build_kind(self._located(as_table(table.get(key, {}), f"stimulus.{key}")), f"stimulus.{key}", kinds)
            for key, kinds in kind.parts.items()
        }
        given = parts | ({"read": self._plays} if kind.reads else {})
        rest = {key: value for key, value in table.items() if key not in parts}
        stimulus = build(stimulus_class, rest, "stimulus", **given)
        return OwnStimulus(stimulus, stated["kind"]) if kind is OWN else stimulus

    def _located(self, table: Mapping[str, Any]) -> Mapping[str, Any]:
        """Return a table with its `path` relative to the current folder."""
        path = table.get("path")
        return {**table, "path": self.study.beside(path)} if self._plays and isinstance(path, str) else table

    def _name(self, kind: str, factors: Factors, stimulus_class: Any) -> str:
        """Return a stimulus name for journals, with all factors that change it."""
        of_variants = {name: level for name, level in factors.items() if name in self.study.variants}
        named = _fields(factors, stimulus_class) | of_variants
        return ", ".join([kind, *(f"{key}={cell_text(level)}" for key, level in named.items())])

    def procedure(self, table: Mapping[str, Any]) -> ReadyProcedure:
        """Build a procedure, or return the cached one, as QUEST+ is slow to build."""
        key = repr(table)  # lists in a table are not hashable
        if key not in self._procedures:
            self._procedures[key] = rule_of(table)
        return self._procedures[key]

    def _felt(self, kind: StimulusKind, of: Mapping[str, Mapping[str, Any]], stimulus: Any, touch: Touch) -> Sensation:
        """Return the sensation model of the study's scene or of the stimulus."""
        if is_own(of["sensation"].get("kind")):
            both = "a table next to a custom [sensation]"
            expect(not of["scene"], "scene", both, "only one of them; remove one")
            return self._own_sensation(of["sensation"])
        if not of["scene"]:
            return self._by_default(kind, of["sensation"], stimulus)
        one = "only one of them, as the scene's effects have such keys; remove one"
        expect(not of["sensation"], "sensation", "a table next to [scene]", one)
        scene = felt_scene(of["scene"], kind.surface, stimulus, touch)
        return self._sensations.setdefault(repr(scene), scene)

    def _own_sensation(self, table: Mapping[str, Any]) -> Sensation:
        key = repr(table)
        if key not in self._sensations:
            kind = sensation_class(table, self._code_from)
            self._sensations[key] = build(kind, without(table, "kind"), "sensation")
        return self._sensations[key]

    def _by_default(self, kind: StimulusKind, table: Mapping[str, Any], stimulus: Any) -> Sensation:
        shared = {name: getattr(stimulus, name) for name in kind.shared}
        key = repr((kind.sensation, table, shared, stimulus.duration_s))
        if key not in self._sensations:
            model = build(resolve(kind.sensation), table, "sensation", **shared)
            if kind.surface:
                with rewording(lambda words: f"sensation: {words}"):
                    scene = resolve(DEFAULT_SCENE)(model, stimulus.duration_s)
                    scene.felt().resolve()
                model = felt(scene)
            self._sensations[key] = model
        return self._sensations[key]

    def _check_effect(
        self, factors: Factors, of: Mapping[str, Mapping[str, Any]], stimulus_class: Any, touch_class: Any
    ) -> None:
        known = [*stimulus_class.__dataclass_fields__, *touch_class.__dataclass_fields__, *self.study.variants]
        for name in factors:
            if name not in known:
                raise InvalidParameter(
                    f"factors.{name}: found a factor that changes nothing, expected a key of the stimulus or the touch "
                    f"({', '.join(dict.fromkeys(known))}){nearest(name, known)}"
                )
            for where in ("stimulus", "touch"):
                one = "only one of them; remove it here or in factors"
                expect(name not in of[where], f"{where}.{name}", "a value that is also a factor", one)


def _keys(table: Mapping[str, Any], factors: Factors, kind: type) -> dict[str, Any]:
    """Add those factors to a table that are fields of its class."""
    return {**without(table, "kind"), **_fields(factors, kind)}


def _fields(factors: Factors, kind: Any) -> dict[str, float | str]:
    return {name: level for name, level in factors.items() if name in kind.__dataclass_fields__}
