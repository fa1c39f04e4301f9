"""Task of a study, with the options of its blocks."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from tactometry.arguments.require import expect, one_of
from tactometry.config.strict import build, check_keys, fields_of, kind_of
from tactometry.loading import resolve
from tactometry.observers.decisions import Decision
from tactometry.protocols.block_state import BlockOptions
from tactometry.protocols.tasks.task import Over, Task, TaskKind
from tactometry.questionnaire import (
    KIND,
    ChoiceForm,
    Questionnaire,
    choice_forms_of,
    is_choices,
    load,
    load_choices,
    questionnaires_of,
    shipped_choices,
    shipped_names,
)
from tactometry.trials.tasks import TASKS as TASK_ROWS

from .study import Prompt, PromptTable, Study, no_such, prompted

TASKS: Mapping[str, TaskKind] = {name: resolve(f"tactometry.protocols.tasks.{name}:TASK") for name in TASK_ROWS}
"""Tasks by name, which is that of their file."""
DECISIONS: Mapping[str, Decision] = {
    question: decision for kind in TASKS.values() for question, decision in kind.questions.items()
}
"""Decisions of simulated participants by question."""


def form_of(study: Study, name: str, path: str) -> Questionnaire:
    """Return a custom or shipped questionnaire.

    Raises `InvalidParameter` if no form has this name, or it has no rating scale.
    """
    is_scale = not is_choices(study.forms.get(name)) and (name in study.forms or name not in shipped_choices())
    expect(is_scale, path, f"{name!r}, a form of choices", "a form with a rating scale; put choices in an inquiry")
    if name in study.forms:
        return questionnaires_of({name: study.forms[name]})[name]
    one_of(path, name, (*study.forms, *shipped_names()))
    return load(name)


def choices_named(study: Study, name: str) -> ChoiceForm | None:
    """Return a custom or built-in form of choices, or None for other names.

    Raises `InvalidParameter` if the custom form is invalid.
    """
    if name in study.forms:
        return choice_forms_of({name: study.forms[name]}).get(name)
    return load_choices(name) if name in shipped_choices() else None


def asked_form(study: Study, inquiry: str) -> Questionnaire | ChoiceForm:
    """Return the form of an inquiry.

    Raises `InvalidParameter` if the form is unknown, or a form of choices has a key for rating scales only.
    """
    table, path = study.inquiries[inquiry], f"inquiries.{inquiry}"
    one_of(f"{path}.form", table.form, (*study.forms, *shipped_names(), *shipped_choices()))
    form = choices_named(study, table.form)
    if form is None:
        expect(not table.identifies, f"{path}.identifies", f"true with {table.form!r}, a scale", f"a form of {KIND}")
        return prompted(form_of(study, table.form, f"{path}.form"), table.prompt)
    once = "'start', as questions about participants are asked once, before the stimuli"
    expect(table.after == "start", f"{path}.after", f"{table.after!r} with a form of {KIND}", once)
    for key, value in {"prompt": table.prompt, "shuffled": table.shuffled}.items():
        alone = f"no value, as a form of {KIND} states its own texts and order"
        expect(not value, f"{path}.{key}", repr(value), alone)
    numbers = ", ".join(form.numbers) or "no number"
    expected = "true only for numbers, which could identify a participant; or use bands"
    found = f"{str(table.identifies).lower()} with {numbers} in {form.name!r}"
    expect(table.identifies == bool(form.numbers), f"{path}.identifies", found, expected)
    return form


@dataclass(frozen=True)
class TaskTable:
    """Built table `task`, with block options and a custom prompt."""

    kind: str
    task: Task
    options: BlockOptions
    over: str | None = None
    prompt: Prompt = ""

    @property
    def task_kind(self) -> TaskKind:
        return TASKS[self.kind]


def task_of(study: Study) -> TaskTable:
    """Build the table `task`. Raises `InvalidParameter`."""
    task_kind: TaskKind = kind_of(study.task, "task", TASKS)
    of_kind = fields_of(task_kind.table)
    names = ("kind", *of_kind, *fields_of(BlockOptions), *fields_of(PromptTable))
    check_keys(study.task, names, "task", read_by=task_kind.table if of_kind else BlockOptions)

    def keys_of(kind: type) -> dict[str, Any]:
        return {key: study.task[key] for key in fields_of(kind) if key in study.task}

    prompt = build(PromptTable, keys_of(PromptTable), "task").prompt
    options = build(BlockOptions, keys_of(BlockOptions), "task")
    keys: Any = build(task_kind.table, keys_of(task_kind.table), "task")
    task = task_kind.made(keys, lambda name: prompted(form_of(study, name, "task.form"), prompt))
    table = TaskTable(study.task["kind"], task, options, keys.over if isinstance(keys, Over) else None, prompt)
    _check(study, table)
    return table


def _check(study: Study, table: TaskTable) -> None:
    rate, task = table.options.catch_rate, table.kind.replace("_", " ")
    without = f"0, as every trial of a {task} contains a stimulus; remove the key"
    expect(rate == 0 or table.task.takes_catch_trials, "task.catch_rate", f"{rate:g} with {table.kind}", without)
    if table.over is not None and len(study.factors.get(table.over, ())) < 2:
        raise no_such("task.over", table.over, "a factor with at least two levels", study.factors)


def dimensions_of(forms: Iterable[Questionnaire]) -> dict[str, dict[str, str]]:
    """Return the dimension of each item by questionnaire."""
    return {form.name: {item.id: item.dimension for item in form.items} for form in forms}
