"""Plots of a running session: levels, curve, force and position."""

from dataclasses import replace
from functools import reduce

import numpy as np
import pytest
from followed_rule import with_row
from hypothesis import given, strategies as st

from tactometry.experiments.watch import view
from tactometry.experiments.watch.curve import answers_of, band_of
from tactometry.experiments.watch.plots import MOST_TICKS, levels_plot, ruler_over
from tactometry.experiments.watch.traces import MOST_BINS, draw_touch, samples_plot, thinned
from tactometry.experiments.watch.watcher import TouchDrawn
from tactometry.records.data_set import Session
from tactometry.records.traces import TraceFiles
from tactometry.session.answer import Touched
from tactometry.session.progress import AnsweredTouch, Progress
from tactometry.session.request import Press
from tactometry.trials.trial import Trial

PRESS = Press("tone", 12.0, 1.0, 1.0, 0.2, 0.5, 20.0)


def test_curve_counts_present_condition_without_practice():
    def rows(n, yes, **known):
        return [Trial(1, n + i, {"f": 1.0}, "staircase", 5.0 * i, "dB", "yes_no", i > 2, **known) for i in range(yes)]

    caught = Trial(1, 50, {"f": 1.0}, "s", None, "dB", "yes_no", 1, catch=True)
    answers = answers_of(reduce(with_row, [*rows(1, 6), *rows(100, 6, practice=True), caught], Progress()))
    assert answers.n == 6
    assert (answers.cell.n_false_alarms, answers.cell.n_catch) == (1, 1)
    band = band_of(answers)
    assert ((band.low <= band.median) & (band.median <= band.high)).all()


def test_curve_has_alternatives_of_other_conditions():
    """By chance, the last six trials do not contain the third interval."""

    def row(n, f, target):
        return Trial(1, n, {"f": f}, "staircase", 5.0 * n, "dB", "forced_choice", target, correct=True, target=target)

    others = [row(n, 1.0, 1 + n % 3) for n in range(1, 7)]
    answers = answers_of(reduce(with_row, [*others, *(row(n, 2.0, 1 + n % 2) for n in range(7, 13))], Progress()))
    assert (answers.cell.n_choices, answers.n) == (3, 6)


def test_rating_of_one_is_neutral():
    progress = with_row(Progress(), Trial(1, 1, {}, "attrakdiff", 24.0, "dB", "rating", 1.0, item="PQ1"))
    assert [mark.kind for mark in view.level_plots(progress)[0].marks] == ["neutral"]


def test_too_few_answers_have_no_curve():
    progress = with_row(Progress(), Trial(1, 1, {}, "staircase", 5.0, "dB", "yes_no", 1))
    assert answers_of(progress) is None
    assert answers_of(with_row(progress, Trial(1, 2, {}, "s", 5.0, "dB", "magnitude", 7.0))) is None


def test_marks_lie_where_the_axes_say():
    progress = Progress()
    for n, level in enumerate((10.0, 8.0, 6.0, 8.0), 1):
        progress = with_row(progress, Trial(1, n, {}, "staircase", level, "dB", "yes_no", 1, valid=n != 2))
    plot = levels_plot("levels", "a title", progress.track)
    marks = [mark for mark in plot.marks if mark.kind != "reversal"]
    assert [mark.kind for mark in marks] == ["yes", "invalid", "yes", "yes"]
    assert [plot.y.at(level) for level in (10.0, 8.0, 6.0, 8.0)] == [mark.y for mark in marks]
    assert [mark.x for mark in marks if mark.kind == "reversal"] == []
    assert [mark.x for mark in plot.marks if mark.kind == "reversal"] == [plot.x.at(3)]


def test_one_value_has_an_axis_too():
    assert ruler_over([3.0], 0.0, 10.0).at(3.0) == 5.0
    assert ruler_over([], 0.0, 10.0).ticks


@given(low=st.floats(-1e6, 1e6), exponent=st.floats(-4, 6), share=st.floats(0, 1))
def test_every_axis_has_some_round_ticks_within_it(low, exponent, share):
    ruler = ruler_over([low, low + 10.0**exponent], 0.0, 100.0, margin=share)
    assert 2 <= len(ruler.ticks) <= MOST_TICKS
    slack = 1e-8 * (ruler.high - ruler.low)
    assert all(ruler.low - slack <= tick <= ruler.high + slack for tick in ruler.ticks)


def test_lost_samples_are_not_drawn():
    touch = AnsweredTouch(PRESS, Touched(10.0, 12.0, "0"))
    plot = samples_plot("force", np.array([[10.0, 1.0], [10.1, np.nan], [10.2, 1.2]]), touch)
    assert "nan" not in plot.strokes[0].points
    assert samples_plot("force", np.array([[10.0, np.nan]]), touch) is None


def test_thinning_keeps_extremes():
    times_s = np.arange(10_000) / 1000
    values = np.sin(times_s)
    values[4321], values[77] = 5.0, np.nan
    points = thinned(times_s, values)
    assert len(points) <= 2 * MOST_BINS
    assert (times_s[4321], 5.0) in points
    assert [time_s for time_s, _ in points] == sorted(time_s for time_s, _ in points)


def kept_touch(root, n_samples=3000):
    """Keep a touch of 3 s, from 1 s before onset, with force and position."""
    times_s = 9.0 + np.arange(n_samples) / 1000
    traces = TraceFiles(root, Session("P01", 1, "tutorial"))
    force = np.column_stack([times_s, 1.0 + 0.1 * np.sin(times_s)])
    force[17, 1] = np.nan
    position = np.column_stack([times_s, times_s / 100])
    parts = traces.keep("force", force, 1000.0), traces.keep("position", position, 1000.0)
    traces.close()
    return AnsweredTouch(PRESS, Touched(10.0, 12.0, "0", force_mean_n=1.0, trace=parts))


def test_last_touch_is_drawn_with_its_band(tmp_path):
    force, place = draw_touch(tmp_path, kept_touch(tmp_path)).plots
    assert (force.title, place.title) == ("Force", "Position")
    assert "1000.0 samples per second, 1.00 ms apart at most, 1 lost" in force.words
    assert [area.kind for area in force.areas] == ["playing", "wanted"]
    band = {float(point.split(",")[1]) for point in force.areas[1].points.split()}
    assert band == {force.y.at(0.8), force.y.at(1.2)}
    assert [area.kind for area in place.areas] == ["playing"]
    assert force.x.low == pytest.approx(-1.0)


def test_touch_with_closed_gate_shows_no_stimulus(tmp_path):
    """A finger without a position is lost before anything plays."""
    touch = kept_touch(tmp_path)
    lost = replace(touch.answer, level_delivered=None, digest=None, valid=False, invalid_reason="sensor_lost")
    force, place = draw_touch(tmp_path, replace(touch, answer=lost)).plots
    assert [area.kind for area in (*force.areas, *place.areas)] == ["wanted"]


def test_damaged_or_missing_traces_are_reported(tmp_path):
    touch = kept_touch(tmp_path)
    file = tmp_path / touch.answer.trace[0].file
    file.write_bytes(file.read_bytes()[:-10])
    assert "force_physio" in draw_touch(tmp_path, touch).problem
    file.unlink()
    assert "force_physio" in draw_touch(tmp_path, touch).problem


def test_touch_without_samples_has_no_plot(tmp_path):
    touch = AnsweredTouch(PRESS, Touched(10.0, 12.0, "0"))
    assert draw_touch(tmp_path, touch) == TouchDrawn()
