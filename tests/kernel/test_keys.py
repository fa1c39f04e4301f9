"""Tables of keys: as the classes have them, on the pages as they are, and of every table that a study may hold."""

from dataclasses import dataclass, field, fields

import pytest

from tactometry.arguments.require import positive
from tactometry.config.strict import build
from tactometry.config.toml import read_table
from tactometry.errors import InvalidParameter
from tactometry.experiments.study.cells import STIMULI, TOUCHES, merge
from tactometry.experiments.study.key_tables import pages, procedure_tables, study_tables
from tactometry.experiments.study.keys import Key, KeyTable, keys_of
from tactometry.experiments.study.procedure_table import PROCEDURES
from tactometry.experiments.study.study_file import builtin
from tactometry.experiments.study.task_table import TASKS

TABLES = {**dict(study_tables()), **dict(procedure_tables())}


@dataclass(frozen=True)
class Gadget:
    speed_m_per_s: float
    n: int = 3
    inner: tuple[float, ...] = ()
    names: dict[str, str] = field(default_factory=dict)

    def __post_init__(self):
        positive("Gadget", speed_m_per_s=self.speed_m_per_s)
        if self.n > 5:
            raise InvalidParameter(f"Gadget.n: found {self.n}, expected at most 5 (a hand); take fewer")


def test_a_key_is_what_its_class_says():
    assert keys_of(KeyTable(Gadget, {"speed_m_per_s": 1.0})) == (
        Key("speed_m_per_s", "a number", "m/s", "above 0", ""),
        Key("n", "a whole number", "", "at most 5", "3"),
        Key("inner", "a list of numbers", "", "", "none"),
        Key("names", "a table", "", "", "none"),
    )


@pytest.mark.parametrize("path", pages(), ids=lambda path: path.name)
def test_the_pages_hold_the_keys_as_they_are(path):
    assert path.read_text(encoding="utf-8") == pages()[path], "run make keys"


@pytest.mark.parametrize("heading", TABLES)
def test_every_required_key_is_required_and_every_other_is_not(heading):
    table = TABLES[heading]
    required = {key.name for key in keys_of(table) if key.required} - set(table.kinds)
    least = {name: value for name, value in table.example.items() if name in required}
    assert set(least) == required
    table.made(build(table.reads, table.example, "t", **table.given))
    for name in required:
        without = {other: value for other, value in table.example.items() if other != name}
        with pytest.raises(InvalidParameter, match=rf"^t\.{name}: found no such key"):
            build(table.reads, without, "t", **table.given)


def test_every_kind_has_its_keys():
    headings = " ".join(TABLES)
    own = [kind for kind, read in TASKS.items() if fields(read.table)]
    for kind in (*STIMULI, *TOUCHES, *PROCEDURES, *own):
        assert f'"{kind}"' in headings, kind


TABLE_OF = {"limits": "`[limits]`", "observer": "`[observer]`", "finger": "`[finger]`", "practice": "`[practice]`"}


@pytest.mark.parametrize("study", builtin())
def test_every_key_of_a_built_in_study_is_in_a_table(study):
    table = read_table(builtin()[study], "a study file")
    assert set(table) <= {key.name for key in keys_of(TABLES["The file itself"])}
    known = {where: {"kind"} for where in ("stimulus", "touch", "task", "procedure")}
    for heading, each in TABLES.items():
        names = {key.name for key in keys_of(each)}
        if heading.startswith("`kind"):
            known["procedure"] |= names
        elif heading.startswith(("`[stimulus]`", "`[touch]`", "`[task]`")):
            known[heading[2:].partition("]")[0]] |= names
    varied = [change for levels in table.get("variants", {}).values() for change in levels.values()]
    for where, names in known.items():
        held = table.get(where, {})
        for change in varied:
            held = merge(held, change.get(where, {}))
        assert set(held) <= names, where
    for where, heading in TABLE_OF.items():
        held = {key for key in table.get(where, {}) if f"`[{where}.{key}]`" not in TABLES}
        assert held <= {key.name for key in keys_of(TABLES[heading])}
    people = table.get("observer", {}).get("people", {})
    assert set(people) <= {key.name for key in keys_of(TABLES["`[observer.people]`"])}


def test_a_session_that_may_last_no_time_is_refused():
    with pytest.raises(InvalidParameter, match=r"^plan\.longest_s: found -5\.0, expected a finite number above 0"):
        build(TABLES["`[plan]`"].reads, {"longest_s": -5.0}, "plan")


def test_a_unit_of_another_dimension_is_refused_where_the_unit_is_a_ratio():
    from tactometry.config.quantity import as_si

    assert as_si({"rate_per_s": "3 s", "moment_n_per_v": "1 V"}, "") == {"rate_per_s": "3 s", "moment_n_per_v": "1 V"}
    with pytest.raises(InvalidParameter, match=r"^setup\.moment_n_per_v: found '1 V', expected a number"):
        build(TABLES["`[stimulus.setup]`"].reads, as_si({"moment_n_per_v": "1 V"}, "setup"), "setup")
