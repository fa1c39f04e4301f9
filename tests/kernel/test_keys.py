"""Tables of keys: from classes, on reference pages and for every file."""

import tomllib
from dataclasses import dataclass, field
from functools import cache

import pytest

from tactometry.arguments.require import positive
from tactometry.config.strict import build
from tactometry.config.toml import merge, read_table
from tactometry.errors import InvalidParameter
from tactometry.experiments.bench.bench_file import parse_bench
from tactometry.experiments.reference.keys import Key, block, keys_of, summary
from tactometry.experiments.reference.pages import path_of, text_of
from tactometry.experiments.reference.tables import PAGES, KeyTable, tables
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.study_file import parse, shipped

TABLES = tables()
per_table = pytest.mark.parametrize("name", TABLES)


@dataclass(frozen=True)
class Gadget:
    """A gadget.

    Parameters
    ----------
    speed_m_per_s : float
        How fast it is.
    n, inner
        What it has.
    """

    speed_m_per_s: float
    n: int = 3
    inner: tuple[float, ...] = ()
    names: dict[str, str] = field(default_factory=dict)

    def __post_init__(self):
        positive("Gadget", speed_m_per_s=self.speed_m_per_s)
        if self.n > 5:
            raise InvalidParameter(f"Gadget.n: found {self.n}, expected at most 5 (a hand); take fewer")


@cache
def keys(name):
    return keys_of(TABLES[name])


def names_of(name):
    return {key.name for key in keys(name)}


@pytest.fixture
def example_files(tmp_path, monkeypatch):
    """Create the files that the examples name in a temporary folder."""
    (tmp_path / "grey.csv").write_bytes(b"0.0,1.0,0.2\n")
    monkeypatch.chdir(tmp_path)


def gadget(**said):
    return KeyTable("gadget", "[gadget]", f"{__name__}:Gadget", example={"speed_m_per_s": 1.0}, **said)


def test_keys_are_read_from_their_class():
    assert keys_of(gadget(samples={"inner": [1.0], "names": {"a": "b"}})) == (
        Key("speed_m_per_s", "a number", "m/s", "above 0", "", "How fast it is.", "1.0"),
        Key("n", "a whole number", "", "at most 5", "3", "What it has.", "3"),
        Key("inner", "a list of numbers", "", "", "none", "What it has.", "[1.0]"),
        Key("names", "a table", "", "", "none", "", '{ a = "b" }'),
    )


def test_kind_is_the_first_key_of_its_table():
    assert keys_of(gadget(kind="round"))[0] == Key("kind", "a text", "", '`"round"`', "", "A gadget.", '"round"')
    assert keys_of(gadget(kind="round", usual=True))[0].otherwise == '"round"'


def test_block_states_required_keys_and_comments_the_rest():
    assert block(gadget(kind="round")) == '[gadget]\nkind = "round"\nspeed_m_per_s = 1.0\n# n = 3\n'


@pytest.mark.parametrize("page", PAGES)
def test_reference_pages_are_up_to_date(page):
    assert path_of(page).read_text(encoding="utf-8") == text_of(page), "run make keys"


@per_table
def test_every_key_has_a_meaning_and_an_example(name):
    for key in keys(name):
        assert key.means, key.name
        assert not key.means.startswith("As in"), key.name
        assert key.example or key.see, key.name
        assert not key.see or any(f"{each}.".startswith(f"{key.see}.") for each in TABLES), key.see


@per_table
def test_keys_of_a_table_have_distinct_meanings(name):
    texts = {key.name: key.means for key in keys(name) if key.name != "kind"}
    generic = [each for each, means in texts.items() if means == summary(TABLES[name].reader) or len(means.split()) < 3]
    assert not generic
    assert len(set(texts.values())) == len(texts), sorted(texts.values())


@per_table
def test_examples_read_and_missing_required_keys_are_named(name):
    table = TABLES[name]
    required = {key.name for key in keys(name) if key.required} - {"kind"}
    assert required <= set(table.shown)
    table.read(table.shown, "t")
    for key in required:
        without = {other: value for other, value in table.shown.items() if other != key}
        missing = rf"^t\.{key}\.kind: found no such key" if key in table.kinds else rf"^t\.{key}: found no such key"
        with pytest.raises(InvalidParameter, match=missing):
            table.read(without, "t")


@per_table
def test_commented_lines_of_a_block_are_valid(name, example_files):
    """A key that the example excludes is tried in that of `instead`."""
    table = TABLES[name]
    for key in keys(name):
        if key.example and key.name != "kind":
            value = tomllib.loads(f"{key.name} = {key.example}")
            table.read({**table.instead.get(key.name, table.shown), **value}, "t")


BENCH = {
    "output": {"gain": {"volts_per_unit": 2.0, "amplifier_gain": 100.0}},
    "sensors": {"hand": {"kind": "touch", "path": "/dev/input/event5"}, "NAME": {"kind": "touch", "path": "x"}},
    "force": {"sensor": "hand", "newtons_per_count": 0.01},
}


@pytest.mark.parametrize("name", [name for name in TABLES if name.startswith("bench.")])
def test_blocks_read_within_a_bench_file(name):
    stated = merge({"sensors": {"NAME": {}}}, tomllib.loads(block(TABLES[name])))
    has_kind = "kind" in stated["sensors"]["NAME"]
    base = merge(BENCH, {"sensors": {"NAME": None}}) if has_kind else BENCH
    parse_bench(merge(base, stated))


def test_block_of_a_study_is_a_study():
    wire(parse(block(TABLES["study"]).encode(), "s.toml"), "s.toml")


@per_table
def test_unknown_keys_are_refused(name):
    table = TABLES[name]
    with pytest.raises(InvalidParameter, match=r"t\.no_such: found an unknown key"):
        build(table.reader, {"no_such": 1}, "t", **table.given())


def test_samples_belong_to_existing_keys():
    """Each key of shared samples belongs to one of their tables."""
    for name, table in TABLES.items():
        group = [other for other in TABLES if other.partition(".")[0] == name.partition(".")[0]]
        assert set(table.shown) <= names_of(name), name
        assert set(table.samples) <= set().union(*map(names_of, group)), name


@pytest.mark.parametrize("study", shipped())
def test_tables_contain_every_key_of_shipped_studies(study):
    table = read_table(shipped()[study], "a study file")
    assert set(table) <= names_of("study")
    varied = [change for levels in table.get("variants", {}).values() for change in levels.values()]
    for where in ("stimulus", "touch", "task", "procedure", "observer", "finger", "practice", "limits", "plan"):
        held = [table.get(where, {}), *(change.get(where, {}) for change in varied)]
        kinds = {each["kind"] for each in held if "kind" in each} or {"signal_detection"}
        known = [name for name in (where, *(f"{where}.{kind}" for kind in kinds)) if name in TABLES]
        below = {name.split(".")[1] for name in TABLES if name.startswith(f"{where}.")}
        assert set().union(*held) <= set().union(below, {"kind"}, *map(names_of, known)), where


def test_plan_refuses_negative_session_length():
    with pytest.raises(InvalidParameter, match=r"^plan\.longest_s: found -5\.0, expected a finite number above 0"):
        build(TABLES["plan"].reader, {"longest_s": -5.0}, "plan")


def test_ratio_unit_refuses_another_dimension():
    from tactometry.config.quantity import as_si

    assert as_si({"rate_per_s": "3 s", "moment_n_per_v": "1 V"}, "") == {"rate_per_s": "3 s", "moment_n_per_v": "1 V"}
    with pytest.raises(InvalidParameter, match=r"^setup\.moment_n_per_v: found '1 V', expected a number"):
        build(TABLES["stimulus.setup"].reader, as_si({"moment_n_per_v": "1 V"}, "setup"), "setup")
