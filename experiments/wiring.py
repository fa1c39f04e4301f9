"""From the numbers of a study to stimuli, blocks and simulated participants."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from tactometry.columns import Column, table_columns
from tactometry.dataset import Design
from tactometry.dataset import cell as cell_text
from tactometry.errors import InvalidParameter, TactometryError, nearest
from tactometry.experiments.study import Study
from tactometry.observers.signal_detection import SignalDetectionObserver
from tactometry.protocols.block import Block, Condition, Track
from tactometry.protocols.constant_stimuli import ConstantStimuli
from tactometry.protocols.forced_choice import ForcedChoice
from tactometry.protocols.order import counterbalanced
from tactometry.protocols.procedure import Procedure
from tactometry.protocols.session import session
from tactometry.protocols.staircase import Staircase
from tactometry.protocols.task import Task
from tactometry.protocols.touch import Pressing, Sliding, Touch
from tactometry.protocols.weighted_staircase import WeightedStaircase
from tactometry.protocols.yes_no import YesNo
from tactometry.quantity import unit_suffix, units
from tactometry.rigs.simulated import Sensation, SimulatedRig
from tactometry.run import Course
from tactometry.signal import Stimulus
from tactometry.streams import stream
from tactometry.strict import build
from tactometry.target import resolve


@dataclass(frozen=True)
class StimulusKind:
    """Target strings of a stimulus and of the model of what is felt of it."""

    stimulus: str
    sensation: str


ELECTROVIBRATION = "tactometry.stimuli.electrovibration.sensation:ElectrovibrationSensation"
STIMULI = {
    kind: StimulusKind(f"tactometry.stimuli.electrovibration.{kind}:{name}", ELECTROVIBRATION)
    for kind, name in (
        ("amplitude_modulated", "AmplitudeModulated"),
        ("sine", "Sine"),
        ("square", "Square"),
        ("triangle", "Triangle"),
        ("trapezoid", "Trapezoid"),
        ("pulse_train", "PulseTrain"),
        ("step", "Step"),
    )
}
TOUCHES: Mapping[str, type[Pressing] | type[Sliding]] = {"press": Pressing, "slide": Sliding}
Rule = Staircase | WeightedStaircase | ConstantStimuli


@dataclass(frozen=True)
class ProcedureKind:
    """A procedure, and the fields that hold its state, which no study file sets."""

    rule: type[Rule]
    state: tuple[str, ...]


PROCEDURES = {
    "staircase": ProcedureKind(Staircase, ("levels", "responses", "reversals")),
    "weighted_staircase": ProcedureKind(WeightedStaircase, ("state",)),
    "constant_stimuli": ProcedureKind(ConstantStimuli, ("order", "n_done")),
}


def _kind(table: Mapping[str, Any], path: str, known: Mapping[str, Any]) -> Any:
    kind = table.get("kind")
    if not isinstance(kind, str) or kind not in known:
        found = "no such key" if kind is None else repr(kind)
        raise InvalidParameter(
            f"{path}.kind: found {found}, expected one of {', '.join(known)}{nearest(str(kind), known)}"
        )
    return known[kind]


def _without(table: Mapping[str, Any], *keys: str) -> dict[str, Any]:
    return {key: value for key, value in table.items() if key not in keys}


@dataclass(frozen=True)
class Experiment:
    """A study that is wired: every table built, every cell's stimulus named, every level within the limits."""

    study: Study
    conditions: tuple[Condition, ...]
    bank: Mapping[str, Stimulus]
    task: Task
    procedure: Rule

    def blocks(self, number: int, rng: np.random.Generator) -> tuple[Block, ...]:
        """The blocks of the participant with this number, in order."""
        order = counterbalanced(self.study.factors, self.study.counterbalance, number)
        return tuple(self._block(cell, rng) for cell in order)

    def _block(self, cell: Mapping[str, float | str], rng: np.random.Generator) -> Block:
        condition = next(condition for condition in self.conditions if condition.factors == cell)
        return Block(
            (Track(condition, _shuffled(self.procedure, rng)),),
            self.task,
            self.study.task.catch_rate,
            self.study.task.n_attempts,
        )

    def course(self, participant: str, n_session: int, number: int, seed: int) -> Course[tuple[Track, ...]]:
        """The protocol of one session: a pure function of its arguments."""
        rng = stream(seed, participant, n_session, "protocol")
        return session(self.blocks(number, rng), rng)

    def sensation(self) -> Sensation:
        """The model of what is felt; its physics is imported here and not before."""
        kind = _kind(self.study.stimulus, "stimulus", STIMULI)
        model: Sensation = build(resolve(kind.sensation), self.study.sensation, "sensation")
        return model

    def simulated_participant(self, participant: str, seed: int) -> SignalDetectionObserver:
        return self.study.observer.participant(stream(seed, participant, "traits"))

    def simulated_rig(self, participant: str, n_session: int, seed: int) -> SimulatedRig:
        return SimulatedRig(
            self.bank,
            self.study.limits,
            self.sensation(),
            self.simulated_participant(participant, seed),
            self.study.finger,
            lambda n_trials: stream(seed, participant, n_session, "observer", n_trials),
        )

    def design(self, study_toml: bytes) -> Design:
        """What the files of a data set say of this study."""
        factors = [_factor_column(name) for name in self.study.factors]
        optional = ["attempt", "level_delivered", "speed_mean_m_per_s"]
        optional += ["catch"] if self.task.takes_catch_trials else ["target"]
        if any(condition.speed_m_per_s is not None for condition in self.conditions):
            optional.append("speed_target_m_per_s")
        study = self.study
        return Design(study.name, study.title, study.description, table_columns(factors, optional), study_toml)


def _factor_column(name: str) -> Column:
    suffix = unit_suffix(name)
    return Column(name, "Factor of the study", "" if suffix is None else units(suffix)[0])


def _shuffled(procedure: Rule, rng: np.random.Generator) -> Procedure:
    return procedure.shuffled(rng) if isinstance(procedure, ConstantStimuli) else procedure


def _task(study: Study) -> Task:
    return YesNo() if study.task.kind == "yes_no" else ForcedChoice(study.task.n_intervals)


def _procedure(study: Study) -> Rule:
    kind = _kind(study.procedure, "procedure", PROCEDURES)
    procedure: Rule = build(kind.rule, _without(study.procedure, "kind"), "procedure", hidden=kind.state)
    return procedure


def _cells(study: Study) -> Iterator[dict[str, float | str]]:
    yield from counterbalanced(study.factors, (), 1)


def _condition(study: Study, cell: Mapping[str, float | str]) -> tuple[Condition, Stimulus]:
    stimulus_class = resolve(_kind(study.stimulus, "stimulus", STIMULI).stimulus)
    touch_class = _kind(study.touch, "touch", TOUCHES)
    of_stimulus = {name: level for name, level in cell.items() if name in stimulus_class.__dataclass_fields__}
    of_touch = {name: level for name, level in cell.items() if name in touch_class.__dataclass_fields__}
    _check_effect(study, cell, stimulus_class, touch_class)
    stimulus = build(stimulus_class, {**_without(study.stimulus, "kind"), **of_stimulus}, "stimulus")
    touch: Touch = build(
        touch_class, {**_without(study.touch, "kind"), **of_touch}, "touch", duration_s=stimulus.duration_s
    )
    name = ", ".join([study.stimulus["kind"], *(f"{key}={cell_text(level)}" for key, level in of_stimulus.items())])
    speed_m_per_s = touch.speed_m_per_s if isinstance(touch, Sliding) else None
    return Condition(dict(cell), name, stimulus.level_unit, touch, speed_m_per_s), stimulus


def _check_effect(study: Study, cell: Mapping[str, object], stimulus_class: Any, touch_class: Any) -> None:
    known = [*stimulus_class.__dataclass_fields__, *touch_class.__dataclass_fields__]
    for name in cell:
        if name not in known:
            raise InvalidParameter(
                f"factors.{name}: found a factor that changes nothing, expected a key of the stimulus or the touch "
                f"({', '.join(dict.fromkeys(known))}){nearest(name, known)}"
            )
        if name in study.stimulus or name in study.touch:
            where = "stimulus" if name in study.stimulus else "touch"
            raise InvalidParameter(
                f"{where}.{name}: found a value that is a factor too, expected one of the two; remove it here or in "
                "factors"
            )


def wire(study: Study, where: str) -> Experiment:
    """Build every table of a study, and hold its strongest stimuli against the limits.

    Raises
    ------
    InvalidParameter
        If a table holds what its kind does not know, or a level would pass a limit; `where` opens the sentence.
    """
    try:
        pairs = [_condition(study, cell) for cell in _cells(study)]
        procedure = _procedure(study)
        experiment = Experiment(
            study,
            tuple(condition for condition, _ in pairs),
            {condition.stimulus: stimulus for condition, stimulus in pairs},
            _task(study),
            procedure,
        )
        _check_levels(experiment)
        experiment.sensation()
    except TactometryError as error:
        raise InvalidParameter(f"{where}, {error}") from None
    return experiment


def _check_levels(experiment: Experiment) -> None:
    procedure = experiment.procedure
    highest = max(procedure.levels) if isinstance(procedure, ConstantStimuli) else procedure.high
    for stimulus in experiment.bank.values():
        try:
            experiment.study.limits.check(stimulus.at(highest))
        except TactometryError as error:
            raise InvalidParameter(
                f"procedure: found the highest level {highest:g}, expected one within the limits ({error})"
            ) from None
