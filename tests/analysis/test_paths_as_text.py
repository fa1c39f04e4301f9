"""Tests of paths given as text, as in `analyse("data")`."""

from pathlib import Path

import pytest
from places import RECORDED

from tactometry.analysis import analyse, read_column_map, read_trials
from tactometry.analysis.plan import read_plan
from tactometry.errors import InvalidFile
from tactometry.stimuli.scenes.file import load_scene
from tactometry.stimuli.time_reversal.plate.glass import read_plate

DATA = RECORDED / "yes-no"


def test_a_data_set_is_read() -> None:
    assert read_trials(str(DATA)).rows.equals(read_trials(DATA).rows)


def test_a_report_and_figures_are_written(tmp_path: Path) -> None:
    report, figures = tmp_path / "report.html", tmp_path / "figures"
    found = analyse(str(DATA), report=str(report), figures=str(figures))
    assert (found.report, found.figures_folder) == (report, figures)
    assert report.is_file()


@pytest.mark.parametrize("read", [read_trials, read_plan, read_column_map, load_scene, read_plate])
def test_missing_path_is_named(read) -> None:
    with pytest.raises(InvalidFile, match=r"^nowhere\.toml: "):
        read("nowhere.toml")
