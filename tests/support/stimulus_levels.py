"""Recorded levels and outputs of the built-in studies and scenes.

`python tests/support/stimulus_levels.py` records them.

The commit of a change of physics records them again, and states which numbers changed and why.
"""

import json
from collections.abc import Iterator, Mapping
from math import inf, isinf
from typing import Any

import numpy as np
from places import RECORDED

from tactometry.contact import Contact
from tactometry.experiments.scenes import names, path_of
from tactometry.experiments.study.cells import Wiring
from tactometry.experiments.study.session_plan import all_cells
from tactometry.experiments.study.study_file import builtin, load
from tactometry.stimuli.scenes.file import load_scene

FILE = RECORDED / "stimulus_levels.json"
LEVELS = (-10.0, 4.0, 12.0, 20.0, 28.0)
CONTACTS = (Contact(1.5), Contact(0.5, 0.02), Contact(3.0, 0.1))
SHARES = (0.5, 1.0)
"""Shares of the inputs in a scene's file."""
N_READ = 16


def study_levels(study: str) -> dict[str, list[float | str]]:
    """The sensation level of each stimulus of a study for each of its models, at all levels and contacts."""
    parsed, _ = load(study)
    wiring = Wiring(parsed)
    cells = [wiring.cell(factors) for factors in all_cells(parsed)]
    distinct = {(repr(cell.stimulus), repr(cell.sensation)): cell for cell in cells}.values()
    signals: dict[str, Any] = {}
    found: dict[str, list[float | str]] = {}
    for cell in distinct:
        name = cell.condition.stimulus
        reached = [level for level in LEVELS if level <= getattr(cell.stimulus, "level_max", inf)]
        at = signals.setdefault(name, [cell.stimulus.at(level) for level in reached])
        key = ", ".join(f"{factor}={value}" for factor, value in cell.condition.factors.items())
        found[key] = [_plain(cell.sensation.sensation_db(signal, touch)) for signal in at for touch in CONTACTS]
    return found


def scene_outputs(scene: str) -> dict[str, list[list[float | str]]]:
    """Every output of a scene at both shares; of a course or map its shape, norm, extremes and some of its values."""
    file = load_scene(path_of(scene))
    plan = file.scene.resolve()
    runs = [plan.run({name: share * file.given[name] for name in plan.given}) for share in SHARES]
    return {name: [_summary(run[name]) for run in runs] for name in plan.outputs}


def recorded() -> Mapping[str, Any]:
    found: Mapping[str, Any] = json.loads(FILE.read_text(encoding="utf-8"))
    return found


def _summary(value: Any) -> list[float | str]:
    values = np.asarray(value, float)
    if values.ndim == 0:
        return [_plain(float(values))]
    read = values.ravel()[np.linspace(0, values.size - 1, N_READ).astype(int)]
    whole = [*values.shape, np.linalg.norm(values), values.min(), values.max()]
    return [_plain(float(number)) for number in (*whole, *read)]


def _plain(value: float) -> float | str:
    return str(value) if isinf(value) else float(value)


def _all(rows: Mapping[str, Any]) -> Iterator[str]:
    for name, numbers in rows.items():
        yield (
            f"  {json.dumps(name)}: {{\n"
            + ",\n".join(f"   {json.dumps(key)}: {json.dumps(value)}" for key, value in numbers.items())
            + "\n  }"
        )


if __name__ == "__main__":
    parts = {"studies": {n: study_levels(n) for n in builtin()}, "scenes": {n: scene_outputs(n) for n in names()}}
    text = ",\n".join(f' "{part}": {{\n' + ",\n".join(_all(rows)) + "\n }" for part, rows in parts.items())
    FILE.write_text(f"{{\n{text}\n}}\n", encoding="utf-8")
