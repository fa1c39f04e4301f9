"""Tests of reserved names of factors."""

from pathlib import Path

import pytest

from tactometry.analysis.pipeline import analyse
from tactometry.errors import InvalidFile, InvalidParameter
from tactometry.trials.columns import DERIVED, RESERVED

HEADER = "participant,session,study,block,trial,{},procedure,level,level_unit,task,response"


def table(path: Path, factor: str) -> Path:
    rows = [
        f"P{participant},1,x,1,{trial},{condition},constant_stimuli,{level},dB,yes_no,{int(level > 3 - shift)}"
        for participant in (1, 2, 3)
        for condition, shift in (("a", 0), ("b", 1))
        for trial, level in enumerate((1, 2, 3, 4, 5, 2, 3, 4), 1)
    ]
    file = path / "c.csv"
    file.write_text("\n".join([HEADER.format(factor), *rows]) + "\n")
    return file


def test_factor_with_unreserved_name_is_analysed(tmp_path):
    found = analyse(table(tmp_path, "colour"))
    assert found.trials.factors == ("colour",)
    assert found.tables["thresholds"]["colour"].tolist() == ["a", "b"] * 3


@pytest.mark.parametrize("name", sorted(DERIVED))
def test_factor_with_reserved_name_is_rejected(tmp_path, name):
    with pytest.raises(InvalidFile, match=f"row 1: found '{name}' between 'trial' and 'procedure'"):
        analyse(table(tmp_path, name))


def test_every_column_that_an_analysis_adds_is_reserved(tmp_path):
    found = analyse(table(tmp_path, "colour"))
    named = ("thresholds", "rates", "mean_rates", "quality", "group_threshold")
    added = {column for name in named for column in found.tables[name]} - {"colour"}
    assert added <= RESERVED


@pytest.mark.parametrize("name", ["level", "response", "task", "participant"])
def test_measured_column_is_rejected_as_factor(tmp_path, name):
    with pytest.raises(InvalidParameter, match=f"--within: found '{name}', a reserved name"):
        analyse(table(tmp_path, "colour"), within=[name])


def test_sessions_and_blocks_may_be_compared(tmp_path):
    assert analyse(table(tmp_path, "colour"), within=["session", "colour"]).trials.factors == ("session", "colour")


def test_levels_with_infinite_range_are_rejected(tmp_path):
    file = table(tmp_path, "colour")
    file.write_text(file.read_text().replace(",5,dB", ",1e308,dB").replace(",1,dB", ",-1e308,dB"))
    with pytest.raises(InvalidParameter, match=r"found -1e\+308, expected an absolute value of at most 1e\+300"):
        analyse(file)
