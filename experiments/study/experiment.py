"""Wired studies: stimuli, sessions and simulated participants."""

import itertools
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from math import comb
from operator import itemgetter
from pathlib import Path
from typing import TYPE_CHECKING

from tactometry.arguments.require import at_most
from tactometry.config.quantity import unit_suffix, units
from tactometry.errors import Gathered, rewording
from tactometry.observers.changes import Answer, Shift
from tactometry.observers.decisions import Observer
from tactometry.observers.kinds import Population, population_of
from tactometry.observers.people import Feeling, SimulatedPerson
from tactometry.position_dependent import FollowsFinger
from tactometry.protocols.block_state import Condition, Track
from tactometry.protocols.procedures.procedure import MOST_TRIALS
from tactometry.protocols.session import session, words_of
from tactometry.protocols.tasks.task import AsksForm, Task
from tactometry.questionnaire import ChoiceForm, Questionnaire, choice_forms_of, questionnaires_of
from tactometry.records.description import StudyDescription
from tactometry.rigs.simulated import Meeting, Rendering, Sensation, SimulatedRig, meeting, rendering
from tactometry.session.run import Course
from tactometry.signal import Stimulus
from tactometry.trials.columns import Column, table_columns
from tactometry.trials.tasks import TASKS
from tactometry.user_code import not_allowed

from .cells import WiredCell, Wiring, tables
from .checks import Strongest, check_forces, check_places, check_signal
from .felt_scene import FeltScene, scene_in_words
from .own_parts import Unseen
from .procedure_table import check_guess_rates, practice_of
from .session_plan import Factors, Key, SessionPlan, all_cells, crossing_of, key_of, places_of, stream
from .study import Study, messages_of, texts_of
from .task_table import DECISIONS, TaskTable, asked_form, dimensions_of, task_of

if TYPE_CHECKING:
    from tactometry.observers.raters import Rater


@dataclass(frozen=True)
class Experiment(SessionPlan):
    """Wired study with checked levels. `where` is its name or file."""

    people: Population
    where: str

    @property
    def task(self) -> Task:
        return self.table.task

    def words_in(self, language: str) -> dict[str, str]:
        """Return custom texts for participants, which replace built-in ones."""
        kind = self.table.kind
        messages = messages_of(kind, self.table.task_kind.questions)
        of_choices = {name: text for form in self.choices for name, text in words_of(form, language).items()}
        return of_choices | self.study.words_in(language) | texts_of(self.table.prompt, messages, language)

    @property
    def conditions(self) -> tuple[Condition, ...]:
        """Conditions of all cells, in the order of the file."""
        return tuple(cell.condition for cell in self.cells.values())

    @property
    def bank(self) -> dict[str, Stimulus]:
        """Stimuli by name."""
        return {cell.condition.stimulus: cell.stimulus for cell in self.cells.values()}

    @property
    def questionnaires(self) -> tuple[Questionnaire, ...]:
        """Questionnaires with rating scales in the sessions."""
        of_task = (self.task.form,) if isinstance(self.task, AsksForm) else ()
        return (*of_task, *(form for form in self.forms.values() if isinstance(form, Questionnaire)))

    @property
    def choices(self) -> tuple[ChoiceForm, ...]:
        """Choice forms in the sessions."""
        return tuple(form for form in self.forms.values() if isinstance(form, ChoiceForm))

    def strongest(self, bank: Mapping[str, Stimulus] | None = None) -> tuple[Strongest, ...]:
        """Return each stimulus at its highest level, from `bank` if given.

        Stimuli grow with the level. If their highest levels are within the limits, so are all stimuli of a session.
        """
        bank = self.bank if bank is None else bank
        return tuple(Strongest(name, where, level, bank[name]) for name, (where, level) in self._highest.items())

    @cached_property
    def _highest(self) -> dict[str, tuple[str, float]]:
        """Return the highest level of each stimulus, and the key that sets it."""
        highest: dict[str, tuple[str, float]] = {}
        for cell in self.cells.values():
            name = cell.condition.stimulus
            where, _, level = max(self._levels(cell), key=itemgetter(2))
            if name not in highest or level > highest[name][1]:
                highest[name] = where, level
        return highest

    def bounds(self, stimulus: str) -> tuple[float, float]:
        """Return the lowest and the highest level of a stimulus in a session."""
        cells = (cell for cell in self.cells.values() if cell.condition.stimulus == stimulus)
        _, lowest, highest = zip(*(levels for cell in cells for levels in self._levels(cell)), strict=True)
        return min(lowest), max(highest)

    def _levels(self, cell: WiredCell) -> Iterator[tuple[str, float, float]]:
        """Yield the keys that set a cell's levels, with lowest and highest level."""
        yield "procedure", *cell.procedure.rule.bounds
        if self.practice is not None:
            yield "practice", *self.practice.bounds
        for key in self.table.task_kind.own_levels:
            level = getattr(self.task, key)
            yield f"task.{key}", level, level

    def course(self, participant: str, n_session: int, number: int, seed: int) -> Course[tuple[Track, ...]]:
        """Return the protocol of one session. Depends only on the arguments."""
        rng = stream(seed, participant, n_session, "protocol")
        parts = self.parts(number, rng, n_session, seed)
        return session(parts, rng, self.study.plan.longest_s, consent=self.study.consent)

    def sensation(self) -> Sensation:
        """Return the sensation model of the first cell's stimulus."""
        return next(iter(self.cells.values())).sensation

    @cached_property
    def felt(self) -> str:
        """Effects of the scenes in words, by stimulus if they differ."""
        by_stimulus = {cell.condition.stimulus: cell.sensation for cell in self.cells.values()}
        scenes = {name: scene_in_words(skin.scene) for name, skin in by_stimulus.items() if isinstance(skin, FeltScene)}
        firsts = {words: name for name, words in reversed(scenes.items())}
        alike = len(firsts) == 1 and len(scenes) == len(by_stimulus)
        return " | ".join(words if alike else f"{name}: {words}" for words, name in reversed(firsts.items()))

    def check_allowed(self) -> None:
        """Raise `InvalidParameter` for custom code that is not allowed."""
        self.people.check_allowed()
        for cell in self.cells.values():
            if isinstance(cell.sensation, Unseen):
                raise not_allowed(cell.sensation.where, cell.sensation.target, "a sensation model")

    def simulated_participant(self, participant: str, seed: int) -> Observer:
        return self.simulated_person(participant, seed).observer

    def simulated_person(self, participant: str, seed: int) -> SimulatedPerson:
        return self.people.person(stream(seed, participant, "traits"))

    def feelings(self, participant: str, seed: int) -> dict[Meeting, Feeling]:
        """Return how a simulated participant feels each contact."""
        person, draws = self.simulated_person(participant, seed), partial(stream, seed, participant)
        return {
            met: self.people.feeling(person, cell.condition.factors, cell.modality, draws)
            for met, cell in self._met.items()
        }

    def simulated_rig(self, participant: str, n_session: int, seed: int) -> SimulatedRig:
        # Each trial has a separate stream, so that a resumed session continues unchanged.
        person, finger = self.simulated_person(participant, seed), self.study.finger
        return SimulatedRig(
            self.bank,
            self.study.limits,
            sensation=self.sensation(),
            observer=person.observer,
            finger=person.finger(finger),
            rng_of=lambda n_trials: stream(seed, participant, n_session, "observer", n_trials),
            decisions=DECISIONS,
            by_stimulus={cell.condition.stimulus: cell.sensation for cell in self.cells.values()},
            felt=self.felt,
            rendered=self._rendered,
            feelings=self.feelings(participant, seed),
            rater=self._rater(participant, seed),
            shift=self._shift(participant, n_session, seed) if self.people.changes else None,
        )

    def _rater(self, participant: str, seed: int) -> "Rater | None":
        if self.people.raters is None:
            return None
        from tactometry.observers.raters import Rater

        factors: dict[object, Factors] = {met: cell.condition.factors for met, cell in self._met.items()}
        draws = partial(stream, seed, participant)
        return Rater(self.people.raters, draws, dimensions_of(self.questionnaires), factors.__getitem__)

    @cached_property
    def _met(self) -> dict[Meeting, WiredCell]:
        """Return the first cell for each combination of stimulus and touch."""
        met: dict[Meeting, WiredCell] = {}
        for cell in self.cells.values():
            condition = cell.condition
            request = condition.touch.request(condition.stimulus, None, None)
            met.setdefault(meeting(condition.stimulus, request), cell)
        return met

    def _shift(self, participant: str, n_session: int, seed: int) -> Callable[[int, Sequence[Answer]], Shift]:
        """Return the shift of a simulated participant after some trials."""
        draws = partial(stream, seed, participant, n_session)
        return lambda n_trials, answers: self.people.shift(n_trials, answers, draws)

    @cached_property
    def _rendered(self) -> Rendering:
        """Return the rendered stimuli, which simulated sessions share."""
        return rendering(self.bank, self.study.limits)

    def design(self, study_toml: bytes) -> StudyDescription:
        """Return the description of the study for the files of a data set."""
        study = self.study
        columns = table_columns([_factor_column(name) for name in study.factors], self._optional())
        numbers = ", ".join(name for form in self.choices for name in form.numbers)
        note = f" Answers could tell who a participant is: {numbers}." if numbers else ""
        description = f"{study.description}{note}".strip() if note else study.description
        return StudyDescription(study.name, study.title, description, columns, study_toml)

    def _optional(self) -> list[str]:
        """Return the optional columns that apply to the study."""
        study, kind = self.study, self.table.task_kind
        are_placed = any(map(places_of, self.bank.values()))
        slides = any(condition.speed_m_per_s is not None for condition in self.conditions)
        follows = any(isinstance(stimulus, FollowsFinger) for stimulus in self.bank.values())
        applies = {
            "track": bool(study.plan.interleave) or kind.n_together is not None,
            "catch": self.task.takes_catch_trials,
            "item": bool(study.inquiries),
            "speed_target_m_per_s": slides,
            "practice": bool(study.practice),
            "speed_in_band": slides,
            **dict.fromkeys(("positions_digest", "positions_late"), follows),
            **dict.fromkeys(TASKS[self.table.kind].columns, True),
            **dict.fromkeys(TASKS[self.table.kind].of_places, are_placed),
        }
        always = ("attempt", "level_delivered", "speed_mean_m_per_s", "rig", "invalid_reason", "n_gaps")
        return [*always, *(name for name, yes in applies.items() if yes)]


def _factor_column(name: str) -> Column:
    suffix = unit_suffix(name)
    return Column(name, "Factor of the study", "" if suffix is None else units(suffix)[0])


def wire(
    study: Study,
    where: str,
    code_from: Path | None = None,
    *,
    simulated: bool = True,
    plays: bool = True,
    begun: bool = False,
) -> Experiment:
    """Build all tables of a study, and check its strongest stimuli.

    Custom code is imported from the folder `code_from`, and rejected without it.

    Raises `InvalidParameter` if a table has an unknown key or invalid value, or a level exceeds a limit. The message
    starts with `where`.

    - `simulated`: True if participants may be simulated. If False, custom observer code is not imported.
    - `plays`: True if stimuli may be played. If False, data are only read, without stimulus files or custom code.
    - `begun`: True if a session has begun. The procedure is then accepted even with an inconsistent guess rate.
    """
    with rewording(lambda words: f"{where}, {words}"):
        experiment = _build(study, where, code_from, simulated=simulated, plays=plays)
        check_forces(study.limits, experiment.conditions)
        check_places(experiment.table.over, experiment.cells)
        for strongest in experiment.strongest():
            if getattr(strongest.stimulus, "read", True):
                check_signal(study.limits, strongest)
        for cell in experiment.cells.values():
            experiment.table.task_kind.check_levels(experiment.task, *cell.procedure.rule.bounds)
        for cell in experiment.cells.values() if plays and not begun else ():
            check_guess_rates(tables(study, cell.condition.factors)["procedure"], study.task)
        return experiment


def _build(study: Study, where: str, code_from: Path | None, *, simulated: bool, plays: bool) -> Experiment:
    mistakes = Gathered()
    table = mistakes.made(lambda: task_of(study))
    practice = mistakes.made(lambda: practice_of(study.practice))
    people = mistakes.made(lambda: population_of(study.observer, "observer", code_from if simulated else None))
    n_tracks = 1 if mistakes.errors else _tracks_per_cell(study, table)
    cells = mistakes.made(lambda: dict(_cells(Wiring(study, code_from, plays=plays), n_tracks)))
    mistakes.end()
    crossing_of(study, table.over, study.factors)  # rejects impossible orders
    forms = {name: asked_form(study, name) for name in study.inquiries}
    questionnaires_of(study.forms)  # unused forms must be valid too
    choice_forms_of(study.forms)
    experiment = Experiment(study, table, cells, practice, forms, people, where)
    people.check(_levels_of(cells), "observer")
    if people.raters is not None:
        people.raters.check(_levels_of(cells), dimensions_of(experiment.questionnaires), "observer.raters")
    return experiment


def _levels_of(cells: Mapping[Key, WiredCell]) -> dict[str, list[float | str]]:
    levels: dict[str, list[float | str]] = defaultdict(list)
    for name, level in dict.fromkeys(itertools.chain.from_iterable(cells)):
        levels[name].append(level)
    return levels


def _cells(wiring: Wiring, n_tracks: float) -> Iterator[tuple[Key, WiredCell]]:
    """Wire the cells of the design. Rejects too many trials."""
    n_trials = 0.0
    for factors in all_cells(wiring.study):
        cell = wiring.cell(factors)
        n_trials += n_tracks * cell.procedure.rule.n_trials_at_most
        at_most("procedure: trials of all cells", n_trials, MOST_TRIALS)
        yield key_of(factors), cell


def _tracks_per_cell(study: Study, table: TaskTable) -> float:
    """Return the number of tracks per cell. Alternatives can share tracks."""
    if table.over is None:
        return 1
    n_levels = len(study.factors[table.over])
    return comb(n_levels, table.task_kind.n_together or n_levels) / n_levels
