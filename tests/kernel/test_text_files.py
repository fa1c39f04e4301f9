"""TOML and JSON files: each refusal names the file and what was expected."""

import json
import re
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings, strategies as st
from page_blocks import texts_of
from places import ROOT
from study_texts import TUTORIAL

from tactometry.analysis.plan import read_plan
from tactometry.analysis.reading.column_map import read_column_map
from tactometry.config.toml import LARGEST_FILE
from tactometry.errors import InvalidFile, TactometryError
from tactometry.experiments.bench.bench_file import load_bench
from tactometry.experiments.study.study_file import parse
from tactometry.files.json_file import DEEPEST, LARGEST_OBJECT, json_items, json_object, json_value
from tactometry.questionnaire import parse as parse_questionnaire
from tactometry.stimuli.scenes.file import load_scene
from tactometry.stimuli.time_reversal.plate.glass import read_plate

READERS: dict[str, Callable[[Path], object]] = {
    "a bench file": load_bench,
    "a column map": read_column_map,
    "an analysis plan": read_plan,
    "a plate": read_plate,
    "a questionnaire": lambda path: parse_questionnaire(path.read_bytes(), str(path)),
    "a scene file": load_scene,
    "a study file": lambda path: parse(path.read_bytes(), str(path)),
}
DAMAGES = {
    "nested": (b"a = " + b"[" * 100_000, "found no valid TOML (maximum recursion depth exceeded"),
    "not UTF-8": (b"a = '\xe9'", "byte 5: found a byte that is not UTF-8"),
    "cut off": (b"a = ", "found no valid TOML (Invalid value (at end of document))"),
}


@pytest.mark.parametrize("what", READERS)
@pytest.mark.parametrize("damage", DAMAGES)
def test_damaged_file_is_refused_in_one_sentence(tmp_path: Path, what: str, damage: str) -> None:
    content, found = DAMAGES[damage]
    path = tmp_path / "file.toml"
    path.write_bytes(content)
    with pytest.raises(InvalidFile) as refused:
        READERS[what](path)
    said = str(refused.value)
    assert said.startswith(str(path))
    assert found in said
    assert f"expected {what}" in said


def test_duplicate_table_is_named_with_its_lines(tmp_path: Path) -> None:
    """The error of the TOML parser names only the second line."""
    path = tmp_path / "s.toml"
    path.write_text(SOUND["a study file"] + "\n[observer]\nexponent = 2.0\n", encoding="utf-8")
    lines = [
        number for number, line in enumerate(path.read_text("utf-8").splitlines(), 1) if line.startswith("[observer]")
    ]
    with pytest.raises(InvalidFile) as refused:
        READERS["a study file"](path)
    words = "expected one table; join their keys"
    assert str(refused.value) == f"{path}: found [observer] in lines {lines[0]} and {lines[1]}, {words}"


@pytest.mark.parametrize("what", sorted(set(READERS) - {"a questionnaire", "a study file"}))
def test_missing_file_is_reported(tmp_path: Path, what: str) -> None:
    with pytest.raises(InvalidFile, match=f"none.toml: cannot be read .No such file or directory., expected {what}"):
        READERS[what](tmp_path / "none.toml")


MAPS_AND_PLAN = texts_of("reference/analysis.md", "toml")
SOUND = {
    "a bench file": texts_of("reference/devices.md", "toml")[0],
    "a column map": MAPS_AND_PLAN[0],
    "an analysis plan": MAPS_AND_PLAN[-1],
    "a plate": 'glass = "Borofloat 33"\nlength_m = 0.3\nwidth_m = "210 mm"\nthickness_m = 1e-3\nboundary = "FFFF"\n',
    "a questionnaire": (ROOT / "tactometry" / "questionnaires" / "sus.toml").read_text("utf-8"),
    "a scene file": (ROOT / "experiments" / "scenes" / "a4-screen.toml").read_text("utf-8"),
    "a study file": TUTORIAL,
}
ODD = ["-1", "1e300", "nan", "-inf", "true", '""', "[]", "{}", "[[1]]", "1979-05-27", '"9 parsecs"', "9" * 20, "[1, 1]"]


@pytest.mark.parametrize("what", READERS)
def test_valid_files_are_read(tmp_path: Path, what: str) -> None:
    (tmp_path / "file.toml").write_text(SOUND[what], "utf-8")
    READERS[what](tmp_path / "file.toml")


def refusal(what: str, path: Path) -> str | None:
    """Return the error message for a file, or None if it is read."""
    try:
        READERS[what](path)
    except TactometryError as error:
        return str(error)
    return None


@pytest.mark.parametrize("what", READERS)
@given(data=st.data())
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_changed_file_is_read_or_refused_clearly(tmp_path: Path, what: str, data: st.DataObject) -> None:
    """Some values or bytes are replaced or removed."""
    lines, path, begun_s = SOUND[what].splitlines(), tmp_path / "file.toml", time.process_time()
    stated = [n for n, line in enumerate(lines) if re.match(r"[\w.]+ *=", line)]
    for n in data.draw(st.lists(st.sampled_from(stated), min_size=1, max_size=3)):
        value = data.draw(st.sampled_from([*ODD, None]))
        lines[n] = "" if value is None else f"{lines[n].partition('=')[0]} = {value}"
    content = bytearray("\n".join(lines).encode())
    if data.draw(st.booleans()):
        place = data.draw(st.integers(0, len(content) - 1))
        content[place : place + data.draw(st.integers(0, 4))] = data.draw(st.binary(max_size=3))
    path.write_bytes(content)
    refused = refusal(what, path)
    assert refused is None or re.fullmatch("[^\n]*found [^\n]*expected[^\n]*", refused)
    assert time.process_time() - begun_s < 5


@pytest.mark.parametrize("what", sorted(set(READERS) - {"a questionnaire", "a study file"}))
def test_oversized_file_is_not_read(tmp_path: Path, what: str) -> None:
    with (tmp_path / "file.toml").open("wb") as file:
        file.truncate(2**30)
    with pytest.raises(InvalidFile, match=f"found {2**30} bytes, expected {what} of at most {LARGEST_FILE}"):
        READERS[what](tmp_path / "file.toml")


TEXT = st.text(max_size=3)
VALUES = st.recursive(
    st.none() | st.booleans() | TEXT,
    lambda part: st.lists(part, max_size=3) | st.dictionaries(TEXT, part, max_size=3),
    max_leaves=5,
)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "found no JSON \\(Expecting value"),
        (b"\xff", "found no JSON \\('utf-8' codec"),
        (b"[" * 10**5, "found no JSON \\(nested deeper than 100 levels\\)"),
        (b"[" * 101 + b"]" * 101, "found no JSON \\(nested deeper than 100 levels\\)"),
        (b'{"\\ud800": 1}', "found no JSON \\('utf-8' codec can't encode"),
        (b'{"a": ["\\udfff"]}', "found no JSON \\('utf-8' codec can't encode"),
        (b"1" * 5000, "found no JSON \\(Exceeds the limit"),
        (b"[]", "found no JSON object"),
        (b" " * (LARGEST_OBJECT + 1), f"found {LARGEST_OBJECT + 1} bytes"),
    ],
    ids=["empty", "bytes", "open lists", "deep lists", "half a key", "half a text", "long number", "list", "large"],
)
def test_json_object_refuses_other_content(tmp_path, content, message):
    (tmp_path / "x.json").write_bytes(content)
    with pytest.raises(InvalidFile, match=f"x.json: {message}.*expected a description"):
        json_object(tmp_path / "x.json", "a description")


def test_json_value_accepts_the_deepest_nesting():
    text = "[" * DEEPEST + "]" * DEEPEST
    assert json.dumps(json_value(text)) == text


@given(
    st.lists(st.lists(VALUES, max_size=3), max_size=3), st.sampled_from([None, 2]), st.sampled_from(["", "\n", " \n\t"])
)
def test_json_items_yields_the_items_of_all_lists(lists, indent, between):
    text = between.join(json.dumps(each, indent=indent) for each in lists)
    assert list(json_items(between + text + between)) == [item for each in lists for item in each]


@pytest.mark.parametrize("text", ["{}", "[1", "[1,", "[1,]", "[,1]", "[1 2]", "[1]]", "[1] 2", "[" * 10**5])
def test_json_items_refuses_text_without_a_list(text):
    with pytest.raises(ValueError, match=r"Expecting|nested deeper"):
        list(json_items(text))
