"""Notebooks of the docs run and contain current outputs."""

import shutil
from pathlib import Path

import pytest
from places import DOCS

pytest.importorskip("nbclient")
pytest.importorskip("ipykernel")

from nbclient.exceptions import CellExecutionError
from nbformat.v4 import new_code_cell, new_notebook
from notebooks import NOTEBOOKS, executed, read, shown

SHORT = {"write_an_effect"}
"""`make test` runs these; the others take several seconds each."""

pytestmark = pytest.mark.filterwarnings("ignore")  # of Jupyter's own sockets and loops


def notebook_of(path: Path) -> object:
    return pytest.param(path, marks=() if path.stem in SHORT else pytest.mark.slow, id=path.stem)


@pytest.mark.parametrize("path", [notebook_of(path) for path in NOTEBOOKS])
def test_notebook_outputs_are_current(tmp_path: Path, path: Path) -> None:
    for file in (DOCS / "notebooks").glob("*.csv"):
        shutil.copy(file, tmp_path)
    kept = shown(read(path))
    assert kept == shown(executed(read(path), tmp_path))
    assert any(kept.values())


def test_failing_notebook_cell_fails(tmp_path: Path) -> None:
    with pytest.raises(CellExecutionError, match="ZeroDivisionError"):
        executed(new_notebook(cells=[new_code_cell("1 / 0")]), tmp_path)


def test_notebook_differences_are_reported_by_cell(tmp_path: Path) -> None:
    cells = [new_code_cell("print(1)", id="said"), new_code_cell("2", id="value"), new_code_cell("x = 3", id="none")]
    assert shown(executed(new_notebook(cells=cells), tmp_path)) == {
        "said": ["stdout: 1\n"],
        "value": ["[] 2"],
        "none": [],
    }
