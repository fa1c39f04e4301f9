"""Every reader of user files has a reference table of its keys."""

import ast
import typing
from collections.abc import Mapping
from dataclasses import is_dataclass
from importlib import import_module

import pytest
from places import ROOT
from source_tree import FOLDERS, name_of as path_of, parsed, sources

from tactometry.config.strict import fields_of
from tactometry.devices.kinds import OUTPUTS, SENSORS
from tactometry.experiments.reference.tables import name_of, tables
from tactometry.experiments.study.kinds import PROCEDURES, STIMULI, TOUCHES
from tactometry.loading import resolve
from tactometry.observers.changes import CHANGES
from tactometry.observers.kinds import OBSERVERS
from tactometry.stimuli.electrovibration.textures.kinds import TEXTURES
from tactometry.stimuli.scenes.effects import EFFECTS
from tactometry.stimuli.scenes.surfaces import SURFACES
from tactometry.trials.tasks import TASKS

POSITION = {"build": 0, "read_toml": 0, "build_kind": 2}
"""Position of the class, or of the classes by kind, among a reader's arguments."""
NAMED = {
    "observers/kinds.py": {
        "own_class(kind, code_from, path)": "code of one's own",
        "resolve(CHANGES[kind])": "CHANGES",
    },
    "bench/bench_file.py": {"kind": "parts of the bench"},
    "study/cells.py": {
        "touch_class": "TOUCHES",
        "stimulus_class": "STIMULI, or code of one's own",
        "kinds": "parts of STIMULI",
        "kind": "code of one's own",
        "resolve(kind.sensation)": "STIMULI",
    },
    "study/procedure_table.py": {"reader": "PROCEDURES"},
    "tactometry/questionnaire.py": {"kind": "a scale or a form of choices"},
    "study/felt_scene.py": {"played": "the surface of what is played"},
    "study/task_table.py": {"task_kind.table": "TASKS"},
    "config/strict.py": dict.fromkeys(("resolve(target)", "kind", "table_class"), "the reader itself"),
    "study/influence.py": {"Parameter": "a table of this package, which no user writes"},
    "reference/tables.py": dict.fromkeys(("self.reader", "kinds"), "the tables themselves"),
}
"""By the end of a file's name, what it calls a class that only a run knows, and where such classes are listed."""
LISTED = {
    "stimulus": STIMULI, "touch": TOUCHES, "task": TASKS, "procedure": PROCEDURES, "observer": OBSERVERS,
    "observer.changes": CHANGES, "bench.output": OUTPUTS, "bench.sensors": SENSORS, "scene.effects": EFFECTS,
    "scene.surface": SURFACES, "texture": TEXTURES,
}  # fmt: skip
TARGETS = {table.reads for table in tables().values()}


def reads_of(tree):
    """Yield the type argument of each reader call, also in `partial`."""
    for call in (node for node in ast.walk(tree) if isinstance(node, ast.Call)):
        prepared = isinstance(call.func, ast.Name) and call.func.id == "partial" and call.args
        reader = call.args[0] if prepared else call.func
        if isinstance(reader, ast.Name) and reader.id in POSITION:
            yield ast.unparse(call.args[POSITION[reader.id] + bool(prepared)])


def readers():
    for path in sources():
        if not any(name in path.read_text(encoding="utf-8") for name in POSITION):
            continue  # each test process runs this, and reading is faster than parsing
        for written in reads_of(parsed(path)):
            yield pytest.param(path, written, id=f"{path_of(path)}-{written}")


def known_in(path):
    """Return the names of a module and those its functions import."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    module = import_module(".".join(parts if parts[0] == FOLDERS[0] else (FOLDERS[0], *parts)))
    lines = [line for line in ast.walk(parsed(path)) if isinstance(line, ast.ImportFrom)]
    imported = {alias.name: "." * line.level + (line.module or "") for line in lines for alias in line.names}
    return imported, module


def read_in(path, written):
    imported, module = known_in(path)
    if written in vars(module):
        return vars(module)[written]
    assert written in imported, f"{path_of(path)}: found {written!r}, expected a name of the module, or one of NAMED"
    return getattr(import_module(imported[written], module.__package__), written)


@pytest.mark.parametrize(("path", "written"), list(readers()))
def test_each_reader_has_a_reference_table(path, written):
    if written in next((names for end, names in NAMED.items() if path_of(path).endswith(end)), {}):
        return
    read = read_in(path, written)
    targets = read.values() if isinstance(read, Mapping) else [f"{read.__module__}:{read.__qualname__}"]
    assert set(targets) <= TARGETS


@pytest.mark.parametrize("group", LISTED)
def test_every_kind_has_its_table(group):
    assert {f"{group}.{kind}" for kind in LISTED[group]} <= set(tables())


def test_every_table_within_a_table_has_its_own():
    found = set()
    for table in tables().values():
        hints, given = typing.get_type_hints(table.reader), table.given()
        for name in fields_of(table.reader).keys() - given.keys():
            inner = [
                part for each in (hints[name], *typing.get_args(hints[name])) for part in (each, *typing.get_args(each))
            ]
            found |= {(table.name, name, each) for each in inner if isinstance(each, type) and is_dataclass(each)}
    assert {(name, key) for name, key, each in found if not name_of(each) and key not in PYTHON_ONLY} == set()


PYTHON_ONLY = {"calibration", "settings"}
"""Fields of a bench's parts that are read from neighbouring keys."""


def test_table_target_is_the_module_of_its_class():
    """Error messages find the table by the class."""
    for table in tables().values():
        kind = resolve(table.reads)
        assert table.reads in (f"{kind.__module__}:{kind.__qualname__}", f"{table.reads.partition(':')[0]}:TASK.table")
