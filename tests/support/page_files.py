"""Reader of the TOML blocks of a page."""

import tomllib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import tomlkit
from page_blocks import Block

from tactometry.analysis.plan import read_plan
from tactometry.analysis.reading.column_map import read_column_map
from tactometry.experiments.bench.bench_file import load_bench
from tactometry.experiments.reference.tables import tables
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.study_file import load, parse
from tactometry.questionnaire import parse as parse_questionnaire
from tactometry.stimuli.scenes.file import load_scene
from tactometry.stimuli.time_reversal.plate.glass import read_plate

READERS: dict[str, Callable[[Path], object]] = {
    "bench": load_bench,
    "map": read_column_map,
    "plan": read_plan,
    "plate": read_plate,
    "questionnaire": lambda path: parse_questionnaire(path.read_bytes(), str(path)),
    "scene": load_scene,
}


def read_toml(block: Block) -> None:
    if block.mark == "study" and not block.said:
        wire(parse(block.text.encode(), block.place), block.place)
        return
    if block.mark == "keys":
        table = tables()[block.said]
        values = tomllib.loads(block.text.removeprefix(table.header))
        table.read({key: value for key, value in values.items() if key != "kind" or not table.kind}, block.place)
        return
    if block.mark == "study":
        content = tomlkit.dumps(over(tomllib.loads(load(block.said)[1].decode()), tomllib.loads(block.text)))
        wire(parse(content.encode(), block.place), block.place)
        return
    path = Path("block.toml")
    path.write_text(block.text, encoding="utf-8")
    READERS[block.mark](path)


def over(study: Mapping[str, Any], part: Mapping[str, Any]) -> dict[str, Any]:
    """A study with the keys of a part of one; a table of another `kind` takes the place of that of the study."""
    merged = dict(study)
    for key, value in part.items():
        was = study.get(key)
        both = isinstance(value, dict) and isinstance(was, dict) and value.get("kind", 0) == was.get("kind", 0)
        merged[key] = over(was, value) if both else value
    return merged
