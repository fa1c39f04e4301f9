"""Results of runs, cached on disk by their content.

A file contains the outputs as arrays and their digest. A damaged or altered file is detected and computed again.
"""

import hashlib
import json
import os
import tempfile
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tactometry.provenance import versions

from .plan import Plan, Result, compute

DIGEST = "digest"


def cached_result(plan: Plan, given: Mapping[str, float], folder: Path) -> Result:
    """Return the result of a run from `folder`, or compute and store it there.

    Raises `OSError` if the folder cannot be made or written to.
    """
    path = folder / f"{key_of(plan, given)}.npz"
    values = _read(path)
    if values is not None:
        return Result(values, plan, given, elapsed_s=0.0)
    result = compute(plan, given)
    _write(path, result.values)
    return result


def key_of(plan: Plan, given: Mapping[str, float]) -> str:
    """Return a digest of all inputs of a result.

    >>> key_of(Plan((), (), ()), {}) == key_of(Plan((), (), ()), {}) != key_of(Plan((), (), ()), {"voltage_v": 1.0})
    True
    """
    stages = [[stage.name, stage.needs, stage.gives, stage.target, dict(stage.settings)] for stage in plan.stages]
    content = {"stages": stages, "outputs": plan.outputs, "given": dict(given), "versions": dict(versions())}
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def _digest(values: Mapping[str, Any]) -> str:
    import numpy as np

    total = hashlib.sha256()
    for name in sorted(values):
        array = np.ascontiguousarray(values[name])
        total.update(f"{name} {array.dtype} {array.shape}".encode())
        total.update(array.tobytes())
    return total.hexdigest()


def _read(path: Path) -> dict[str, Any] | None:
    """Return the outputs in a file, or None if it is missing or damaged."""
    import numpy as np

    try:
        with path.open("rb") as handle, np.load(handle, allow_pickle=False) as file:
            values = {name: file[name] for name in file.files}
    except (OSError, ValueError, EOFError, RuntimeError, zipfile.BadZipFile):
        return None
    digest = str(values.pop(DIGEST, ""))
    return {n: v.item() if v.ndim == 0 else v for n, v in values.items()} if digest == _digest(values) else None


def _write(path: Path, values: Mapping[str, Any]) -> None:
    """Write a result file atomically."""
    import numpy as np

    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=path.parent, suffix=".npz")
    arrays = {name: np.asarray(value) for name, value in values.items()}
    with os.fdopen(handle, "wb") as file:
        np.savez(file, **arrays, **{DIGEST: np.array(_digest(arrays))})  # type: ignore[arg-type]
    Path(name).replace(path)
