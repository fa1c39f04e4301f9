"""The task of a study, and how its blocks present it."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

from tactometry.config.strict import build
from tactometry.errors import InvalidParameter, nearest
from tactometry.observers.decisions import Decision
from tactometry.protocols.block import Interleaving, check_presenting
from tactometry.protocols.tasks.task import Over, Task, TaskKind
from tactometry.questionnaire import Questionnaire, load, own, shipped
from tactometry.target import resolve
from tactometry.trials.tasks import TASKS as TASK_ROWS

from .study_file import Study


@dataclass(frozen=True)
class Presenting:
    """The keys of the table `task` that hold for every kind; see `tactometry.protocols.Block`."""

    catch_rate: float = 0.0
    n_attempts: int = 5
    interleaving: Interleaving = "random"
    feedback: bool = False
    rest_after: int | None = None
    rest_s: float | None = None
    longest_s: float | None = None

    def __post_init__(self) -> None:
        check_presenting(self)


TASKS: Mapping[str, TaskKind] = {name: resolve(f"tactometry.protocols.tasks.{name}:TASK") for name in TASK_ROWS}
"""Every task by its name, which is that of its file."""
DECISIONS: Mapping[str, Decision] = {
    question: decision for kind in TASKS.values() for question, decision in kind.questions.items()
}
"""How a simulated participant answers each question of any task."""


def form_of(study: Study, name: str, path: str) -> Questionnaire:
    """A questionnaire of the study's own, or a shipped one.

    Raises
    ------
    InvalidParameter
        If there is none of that name.
    """
    if name in study.forms:
        return own({name: study.forms[name]})[name]
    known = (*study.forms, *shipped())
    if name not in known:
        raise InvalidParameter(f"{path}: found {name!r}, expected one of {', '.join(known)}{nearest(name, known)}")
    return load(name)


@dataclass(frozen=True)
class Asking:
    """A task, how it is presented, and the factor that it chooses or pairs over."""

    kind: str
    task: Task
    presenting: Presenting
    over: str | None = None

    @property
    def task_kind(self) -> TaskKind:
        return TASKS[self.kind]


def asking(study: Study) -> Asking:
    """The table `task`, built.

    Raises
    ------
    InvalidParameter
        If it holds what its kind does not know.
    """
    kind = study.task.get("kind")
    if not isinstance(kind, str) or kind not in TASKS:
        found = "no such key" if kind is None else repr(kind)
        raise InvalidParameter(
            f"task.kind: found {found}, expected one of {', '.join(TASKS)}{nearest(str(kind), TASKS)}"
        )
    task_kind = TASKS[kind]
    common, own = _names(Presenting), _names(task_kind.table)
    for key in study.task:
        if key not in ("kind", *own, *common):
            raise InvalidParameter(
                f"task.{key}: found an unknown key, expected one of kind, {', '.join((*own, *common))}"
                f"{nearest(key, (*own, *common))}"
            )
    presenting = build(Presenting, {key: study.task[key] for key in common if key in study.task}, "task")
    table: Any = build(task_kind.table, {key: study.task[key] for key in own if key in study.task}, "task")
    task = task_kind.made(table, lambda name: form_of(study, name, "task.form"))
    made = Asking(kind, task, presenting, table.over if isinstance(table, Over) else None)
    _check(study, made)
    return made


def _names(kind: type) -> tuple[str, ...]:
    return tuple(each.name for each in fields(kind))


def _check(study: Study, made: Asking) -> None:
    rate = made.presenting.catch_rate
    if rate > 0 and not made.task.takes_catch_trials:
        raise InvalidParameter(
            f"task.catch_rate: found {rate:g} with {made.kind}, expected 0: every trial of a "
            f"{made.kind.replace('_', ' ')} holds a stimulus; remove the key"
        )
    if made.over is not None and len(study.factors.get(made.over, ())) < 2:
        raise InvalidParameter(
            f"task.over: found {made.over!r}, expected a factor of at least two levels ({', '.join(study.factors)})"
            f"{nearest(made.over, study.factors)}"
        )
