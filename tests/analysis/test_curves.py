"""Tests of the curve figure: places of levels, rates and thresholds."""

import numpy as np
import pytest

from tactometry.analysis.figures.curves import MAX_PANELS, Panel, curve_figure
from tactometry.analysis.tasks.cell import Cell, Estimate
from tactometry.analysis.tasks.cells import estimates


def estimate(level: float = 20.0, k=(0, 3, 7, 10)) -> Estimate:
    levels = tuple(level + step for step in range(4))
    (made,) = estimates([Cell("P01", (level,), "yes_no", levels, k, (10,) * 4, 0, 0)])
    return made


@pytest.fixture(scope="module")
def panel() -> Panel:
    return Panel(estimate(), left=1.0, bottom=2.0, width=3.0, height=1.0, low=20.0, high=23.0)


def test_panel_clips_levels_to_its_axis(panel: Panel) -> None:
    x = panel.x([20.0, 21.5, 23.0])
    assert x[1] == pytest.approx(2.5)
    assert 1.0 < x[0] < x[2] < 4.0
    np.testing.assert_allclose(panel.x([-100.0, 100.0]), [1.0, 4.0])


def test_panel_contains_rates_and_threshold_bar(panel: Panel) -> None:
    bar, nothing, all_ = panel.y([-0.06, 0.0, 1.0])
    assert 2.0 < bar < nothing < all_ < 3.0


@pytest.mark.parametrize(("low", "high"), [(20.0, 23.0), (-10.0, 46.0), (0.001, 0.0042), (-1e-6, 3e5)])
def test_ticks_are_round_levels_of_the_axis(low: float, high: float) -> None:
    ticks = Panel(estimate(), 0.0, 0.0, 1.0, 1.0, low, high).ticks
    assert 1 <= len(ticks) <= 4
    assert all(low <= tick <= high and len(f"{tick:g}") <= 7 for tick in ticks)


def test_open_interval_extends_to_axis_end() -> None:
    above = Panel(estimate(k=(0, 0, 0, 0)), 0.0, 0.0, 1.0, 1.0, 20.0, 23.0)
    assert above.estimate.fit.threshold is None
    low, high = above.interval
    assert (low, high) == (above.estimate.fit.interval_low, 23.0)


def test_curve_figure_titles_panels_up_to_maximum() -> None:
    many = [estimate(20.0 + n) for n in range(MAX_PANELS + 2)]
    svg = curve_figure(many, ["frequency_hz"], unit="dB").svg
    titles = [f">{20 + n} Hz<" in svg for n in range(MAX_PANELS + 2)]
    assert titles == [True] * MAX_PANELS + [False] * 2
    assert "Level (dB)" in svg


def test_curve_figure_draws_catch_only_and_single_level() -> None:
    (single,) = estimates([Cell("P01", ("b",), "yes_no", (5.0,), (3,), (9,), 0, 0)])
    (catch,) = estimates([Cell("P01", ("a",), "yes_no", (), (), (), 3, 1)])
    assert curve_figure([catch], ["hand"], unit="").svg.startswith("<svg")
    assert curve_figure([catch, single], ["hand"], unit="").svg.startswith("<svg")
