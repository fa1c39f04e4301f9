"""`tactometry analyse` of measurements: loss of amplitude per condition, in tables, report and the thesis's figure."""

import numpy as np
import pandas as pd
import pytest
from scipy.stats import t as student

from tactometry.analysis.pipeline import analyse
from tactometry.analysis.report.summary import summary
from tactometry.errors import InvalidFile
from tactometry.experiments.data_sets.force_loss import measured_losses
from tactometry.experiments.study.study_file import builtin
from tactometry.experiments.thesis.figures.focus import loss_over_force

LOSS = {("finger", "F", 2.0): 0.30, ("finger", "P1", 2.0): 0.06, ("soft 5 mm", "F", 2.0): 0.1}
NOISE = {"P01": 0.01, "P02": -0.01, "P03": 0.03}


def rows(loss=LOSS, noise=NOISE, unit="dB re 1 um", level=20.0):
    """Two readings of each condition and participant."""
    for code, shift in noise.items():
        for n, ((contactor, place, force_n), lost) in enumerate(loss.items()):
            for half, reading in enumerate((-0.005, 0.005)):
                left = 1 - lost - shift - reading
                measured = level + 20 * np.log10(left) if unit.startswith("dB") else level * left
                yield {
                    "participant": code, "session": 1, "study": "force-loss", "block": 1, "trial": 2 * n + half + 1,
                    "contactor": contactor, "place": place, "force_n": force_n, "procedure": "constant_stimuli",
                    "level": level, "level_unit": unit, "task": "measurement", "response": 7000,
                    "force_mean_n": 1.1 * force_n, "valid": 1, "level_measured": measured,
                }  # fmt: skip


@pytest.fixture
def data_set(tmp_path):
    (tmp_path / "data").mkdir()
    (tmp_path / "study.toml").write_bytes(builtin()["force-loss"].read_bytes())
    for code, shift in NOISE.items():
        own = pd.DataFrame(rows(noise={code: shift}))
        own.to_csv(tmp_path / "data" / f"participant-{code}_session-1_study-forceloss_data.csv", index=False)
    return tmp_path


def written(path, **of):
    pd.DataFrame(rows(**of)).to_csv(path, index=False)
    return path


def of_condition(table, contactor, place):
    return table[(table["contactor"] == contactor) & (table["place"] == place)].iloc[0]


def test_measurement_data_set_reports_loss_per_condition(data_set):
    found = analyse(data_set)
    at_focus = of_condition(found.tables["loss"], "finger", "F")
    values = 0.30 + np.array(list(NOISE.values()))
    half = student.ppf(0.975, 2) * values.std(ddof=1) / np.sqrt(3)
    assert at_focus["mean"] == pytest.approx(values.mean(), abs=1e-4)
    kept = 1 - values.mean()
    ends = 1 - kept * np.exp(np.array([half, -half]) / kept)
    assert (at_focus["mean_low"], at_focus["mean_high"]) == pytest.approx(ends, abs=1e-4)
    assert (at_focus["n"], at_focus["n_readings"]) == (3, 6)
    assert at_focus["force_mean_n"] == pytest.approx(2.2)
    assert of_condition(found.tables["loss"], "finger", "P1")["mean"] == pytest.approx(0.07, abs=1e-4)
    assert not found.warnings


def test_two_readings_have_no_interval_when_alone(tmp_path):
    found = analyse(written(tmp_path / "one.csv", noise={"P01": 0.0}))
    row = of_condition(found.tables["loss"], "finger", "F")
    assert row["mean"] == pytest.approx(0.3, abs=1e-4)
    assert row[["mean_low", "mean_high"]].isna().all()


def test_levels_in_metres_lose_the_same(tmp_path):
    in_db = analyse(written(tmp_path / "db.csv")).tables["loss"]
    in_m = analyse(written(tmp_path / "m.csv", unit="m", level=1e-5)).tables["loss"]
    np.testing.assert_allclose(in_m["mean"], in_db["mean"], rtol=1e-4)


def test_zero_amplitude_is_refused_with_its_row(tmp_path):
    with pytest.raises(InvalidFile, match="row 2, column 'level': found 0"):
        analyse(written(tmp_path / "a.csv", unit="m", level=0.0))


def test_report_and_figures_hold_the_loss(data_set, tmp_path):
    found = analyse(data_set, report=tmp_path / "report.html", figures=tmp_path / "figures")
    page = (tmp_path / "report.html").read_text("utf-8")
    assert "Loss of amplitude" in page
    assert "31.0 % [" in page
    assert (tmp_path / "report_tables" / "loss.csv").exists()
    assert (tmp_path / "figures" / "loss.png").stat().st_size > 5000
    assert len(summary(found)["loss"]) == 3


def test_thesis_figure_uses_the_data_set(data_set):
    measured = measured_losses(data_set)
    assert {(row.contactor, row.diameter_m, row.place) for row in measured} == {
        ("finger", 1e-2, "F"), ("finger", 1e-2, "P1"), ("soft", 5e-3, "F"),
    }  # fmt: skip
    panels = loss_over_force(measured, measured).axes
    drawn = [line.get_ydata().tolist() for line in panels[0].lines if "measured" in str(line.get_label())]
    assert drawn[0] == pytest.approx([31.0], abs=0.01)


def test_another_study_is_refused(tmp_path):
    path = tmp_path / "a.csv"
    pd.DataFrame(rows()).drop(columns="place").to_csv(path, index=False)
    with pytest.raises(InvalidFile, match="found the factors contactor, force_n, expected contactor, place, force_n"):
        measured_losses(path)
