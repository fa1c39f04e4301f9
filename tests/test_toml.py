"""Every file in TOML that is read: what cannot be is one sentence with the file and what was expected."""

from collections.abc import Callable
from pathlib import Path

import pytest

from tactometry.analysis.column_map import read_column_map
from tactometry.analysis.plan import read_plan
from tactometry.errors import InvalidFile
from tactometry.experiments.bench_file import load_bench
from tactometry.experiments.study import parse
from tactometry.questionnaire import parse as parse_questionnaire
from tactometry.stimuli.scenes.file import load_scene
from tactometry.stimuli.time_reversal.plate_file import read_plate

READERS: dict[str, Callable[[Path], object]] = {
    "a bench file": load_bench,
    "a column map": read_column_map,
    "a plan of analysis": read_plan,
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
def test_damage_is_told_in_one_sentence(tmp_path: Path, what: str, damage: str) -> None:
    content, found = DAMAGES[damage]
    path = tmp_path / "file.toml"
    path.write_bytes(content)
    with pytest.raises(InvalidFile) as refused:
        READERS[what](path)
    said = str(refused.value)
    assert said.startswith(str(path))
    assert found in said
    assert f"expected {what}" in said


@pytest.mark.parametrize("what", sorted(set(READERS) - {"a questionnaire", "a study file"}))
def test_an_absent_file_is_told(tmp_path: Path, what: str) -> None:
    with pytest.raises(InvalidFile, match=f"none.toml: cannot be read .No such file or directory., expected {what}"):
        READERS[what](tmp_path / "none.toml")
