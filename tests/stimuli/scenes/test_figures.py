"""Scene figures: units, finger load, and starts of stick and slip."""

from dataclasses import replace

import numpy as np
import pytest
from scene_cases import LEVEL, VOLT, default, effect, panel, screen

from tactometry.stimuli.composition.effect import FingerContact
from tactometry.stimuli.scenes.figures.courses import BESIDE_LOAD, courses, focus_sheet, numbers
from tactometry.stimuli.scenes.plan import compute, loads_n


def drawn(scene, given, draw):
    plan = scene.resolve()
    result = compute(plan, {name: given[name] for name in plan.given})
    return result, draw(result, "a scene")


def axes_of(figure, words):
    return [axes for axes in figure.axes if axes.get_ylabel().startswith(words)]


def test_beginnings_of_slip_and_stick_are_marked():
    outputs = ("t_s", "friction_force_n", "voltage_v", "slip_events_s")
    scene = panel(default("dry_friction"), default("finger_dynamics"), outputs=outputs)
    result, figure = drawn(replace(scene, contacts=(FingerContact(0.2, speed_m_per_s=0.05),)), LEVEL, courses)
    (rubbed,), (quiet,) = axes_of(figure, "friction force"), axes_of(figure, "voltage")
    events_ms = np.asarray(result.values["slip_events_s"]) * 1e3
    marks = [line.get_xdata()[0] for line in rubbed.lines if len(line.get_xdata()) == 2]
    assert len(events_ms) > 0
    assert marks == pytest.approx(events_ms)
    assert len(quiet.lines) == 1


@pytest.mark.parametrize("draw", [courses, focus_sheet])
def test_contact_force_figure_marks_static_load(draw):
    outputs = ("t_s", "contact_force_n", "x_m", "y_m", "field_m")
    result, figure = drawn(screen(effect("finger_load"), outputs=outputs, accuracy=0.1), VOLT, draw)
    assert loads_n(result.plan).tolist() == [2.0]
    force = axes_of(figure, "contact force")[0]
    assert force.get_title(loc="right") == BESIDE_LOAD
    prefix = {"N": 1.0, "mN": 1e-3}[force.get_ylabel().partition("(")[2].rstrip(")")]
    assert force.lines[-1].get_ydata()[0] * prefix == pytest.approx(-2.0)
    beside = [axes for axes in figure.axes if any(line.get_linestyle() == ":" for line in axes.lines)]
    assert len(beside) == (2 if draw is focus_sheet else 1)  # from afar and near the focus


def test_micrometres_are_written_one_way_and_levels_say_above_what():
    outputs = ("t_s", "focus_displacement_m", "x_m", "y_m", "field_m", "peak_m", "sensation_db")
    result, figure = drawn(screen(effect("focus_detection"), outputs=outputs, accuracy=0.1), VOLT, focus_sheet)
    words = [label for axes in figure.axes for label in (axes.get_ylabel(), axes.get_xlabel(), axes.get_title())]
    words += numbers(result.values)
    assert not any("um" in text.replace("column", "") for text in words)
    assert any("µm" in text for text in words)
    assert next(text for text in numbers(result.values) if text.startswith("sensation")).endswith(" dB SL")


def test_friction_error_is_relative_to_its_swing():
    scene = panel(default("friction"), outputs=("t_s", "friction_force_n"), accuracy=1e-2)
    got, fine = (
        plan.run(LEVEL)
        for plan in (scene.resolve(), panel(*scene.effects[1:], outputs=scene.outputs, accuracy=1e-5).resolve())
    )
    off_n = np.abs(np.interp(fine["t_s"], got["t_s"], got["friction_force_n"]) - fine["friction_force_n"]).max()
    assert off_n <= 1e-2 * np.ptp(fine["friction_force_n"])
