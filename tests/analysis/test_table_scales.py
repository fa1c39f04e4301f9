"""Tests of units and ratio scales of tables of other programs."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from command_line import output

from tactometry.analysis.pipeline import analyse
from tactometry.analysis.reading.column_map import ColumnMap, read_column_map
from tactometry.analysis.reading.level_scale import on_scale, wide_levels
from tactometry.analysis.reading.trials import read_trials
from tactometry.config.quantity import si_unit
from tactometry.errors import InvalidFile, InvalidParameter
from tactometry.psychometric import PsychometricFunction


@pytest.mark.parametrize(
    ("name", "unit", "cell", "value"),
    [
        ("latency_s", "ms", "812", 0.812),
        ("latency_s", "min", "1.5", 90.0),
        ("level", "mV", "455.2", 0.4552),
        ("level", "kHz", "2.3", 2300.0),
        ("force_n", "mN", "250", 0.25),
        ("speed_mean_m_per_s", "mm/s", "-50", -0.05),
    ],
)
def test_column_is_converted_to_si(tmp_path, name, unit, cell, value):
    file = tmp_path / "t.csv"
    cells = {"participant": "P1", "side": "a", "level": "1", "task": "yes_no", "response": "1"} | {name: cell}
    file.write_text(f"{','.join(cells)}\n{','.join(cells.values())}\n")
    found = read_trials(file, within=["side"], column_map=ColumnMap(units={name: unit})).rows
    assert float(found[name].iloc[0]) == value
    if name == "level":
        assert found["level_unit"].tolist() == [si_unit(unit, "")[0]]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('[units]\nlatency_s = "mV"', "units.latency_s: found 'mV', a unit of V, expected a unit of s"),
        ('[units]\nlevel = "mv"', "units.level: found 'mv', expected a unit such as ms, mV or N; did you mean"),
        ('level_scale = "log"', "level_scale: found 'log', expected one of linear, log10, db"),
    ],
)
def test_map_with_invalid_unit_or_scale_is_rejected(tmp_path, text, message):
    (tmp_path / "m.toml").write_text(text)
    with pytest.raises(InvalidFile, match=re.escape(message)):
        read_column_map(tmp_path / "m.toml")


def test_levels_in_two_units_are_refused(tmp_path):
    file = tmp_path / "t.csv"
    file.write_text("participant,side,level,level_unit,task,response\nP1,a,1,dB,yes_no,1\n")
    message = "found the level_unit 'dB', expected 'V', the unit after conversion by units.level"
    with pytest.raises(InvalidFile, match=message):
        read_trials(file, within=["side"], column_map=ColumnMap(units={"level": "mV"}))


TRUE = PsychometricFunction("weibull", 0.05, 0.1, 0.02, 0.02)
CONTRASTS = tuple(np.geomspace(0.002, 0.5, 9))


def contrasts(path: Path, *, unit: str = "") -> Path:
    """Write yes/no answers at contrasts that span a factor of 250."""
    lines = ["participant,side,level,level_unit,task,response,catch"]
    for level in CONTRASTS:
        n_yes = round(40 * TRUE.probability(level))
        lines += [f"P1,a,{level:.17g},{unit},yes_no,{int(n < n_yes)},0" for n in range(40)]
    lines += [f"P1,a,,{unit},yes_no,{int(n < 1)},1" for n in range(40)]
    file = path / "c.csv"
    file.write_text("\n".join(lines) + "\n")
    return file


def test_wide_linear_levels_have_warning(tmp_path, capsys):
    arguments = ("analyse", contrasts(tmp_path), "--within", "side", "--json")
    (warning,) = [text for text in json.loads(output(capsys, *arguments))["warnings"] if "linear axis" in text]
    assert warning.startswith("levels from 0.002 to 0.5 span a factor of 250 on a linear axis")
    assert "--level-scale log10 or db" in warning
    assert "linear axis" not in output(capsys, *arguments, "--level-scale", "linear")


def test_decibel_or_narrow_levels_have_no_warning(tmp_path):
    rows = read_trials(contrasts(tmp_path, unit="dB re 1 V"), within=["side"]).rows
    assert wide_levels(rows) == []
    few = read_trials(contrasts(tmp_path), within=["side"]).rows
    assert wide_levels(few[few["level"].isna() | (few["level"] > 0.03)]) == []
    assert wide_levels(few.assign(level=few["level"] - 0.01)) == []


def test_threshold_is_on_the_logarithmic_scale(tmp_path):
    file = contrasts(tmp_path, unit="V")
    log10, db = (analyse(file, within=["side"], level_scale=scale).tables["thresholds"] for scale in ("log10", "db"))
    for table, unit, factor in ((log10, "log10 V", 1), (db, "dB re 1 V", 20)):
        (row,) = table.to_dict("records")
        assert (row["level_unit"], row["shape"]) == (unit, "gumbel")
        assert row["interval_low"] < factor * np.log10(TRUE.threshold) < row["interval_high"]
        assert row["interval_high"] - row["interval_low"] < factor * 0.5
    np.testing.assert_allclose(db["threshold"].astype(float), 20 * log10["threshold"].astype(float), rtol=1e-6)


def test_command_option_overrides_scale_of_map(tmp_path, capsys):
    (tmp_path / "m.toml").write_text('level_scale = "db"\n')
    file = contrasts(tmp_path, unit="V")
    arguments = ("analyse", file, "--within", "side", "--json", "--columns", tmp_path / "m.toml")
    for options, unit in (((), "dB re 1 V"), (("--level-scale", "log10"), "log10 V")):
        found = json.loads(output(capsys, *arguments, *options))
        assert found["level_unit"] == unit
        assert not [text for text in found["warnings"] if "linear axis" in text]


def test_level_scale_converts_settings_but_not_magnitudes(tmp_path):
    lines = ["participant,side,level,level_unit,task,response"]
    lines += ["P1,a,1,V,adjustment,10", "P1,a,10,V,magnitude,3", "P1,a,,V,adjustment,"]
    (tmp_path / "t.csv").write_text("\n".join(lines) + "\n")
    rows = read_trials(tmp_path / "t.csv", within=["side"], level_scale="db").rows
    assert rows["response"].tolist() == ["20.0", "3", ""]
    assert rows["level_unit"].tolist() == ["dB re 1 V", "V", "dB re 1 V"]
    assert rows["level"].tolist()[:2] == [0.0, 10.0]


@pytest.mark.parametrize("name", ["level", "level_delivered", "standard_level"])
def test_level_without_logarithm_is_rejected_with_its_row(tmp_path, name):
    file = tmp_path / "t.csv"
    file.write_text(f"participant,side,{name},x,task,response\nP1,a,1,1,yes_no,1\nP1,a,0,1,yes_no,1\n")
    columns = ColumnMap({} if name == "level" else {"level": "x"})
    with pytest.raises(InvalidFile, match=rf"row 3, column '{name}': found 0.0, expected a level above 0 on a log"):
        read_trials(file, within=["side"], column_map=columns, level_scale="log10")


def test_decibels_have_no_second_logarithm(tmp_path):
    with pytest.raises(InvalidParameter, match="found log10 for levels in 'dB re 1 V', which are already logarithms"):
        read_trials(contrasts(tmp_path, unit="dB re 1 V"), within=["side"], level_scale="log10")
    with pytest.raises(InvalidParameter, match="--level-scale: found 'log', expected one of linear, log10, db"):
        on_scale(read_trials(contrasts(tmp_path), within=["side"]).rows, "log")
