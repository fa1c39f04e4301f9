"""The figures of the gallery show the numbers that they are given, with units, without a screen."""

import subprocess
import sys

import numpy as np
import pytest

from tactometry.errors import InvalidParameter
from tactometry.stimuli.electrovibration import Bump, Grating, Print, Skin, Velvet, electrostatic_force_n, figures

ALL = [
    lambda: figures.input_against_position({"square": Grating(4e-3), "bump": Bump(0.02, 4e-3)}),
    figures.force_against_area,
    figures.skin_properties,
    figures.force_for_inputs,
    lambda: figures.applied_forces({"0.5 N": [0.4, 0.5, 0.6], "3 N": [2.9]}),
    figures.contact_ellipse,
]


@pytest.mark.parametrize("draw", ALL)
def test_a_figure_renders_and_names_its_units(draw, tmp_path) -> None:
    figure = draw()
    path = tmp_path / "figure.png"
    figure.savefig(path)
    assert path.stat().st_size > 5000
    labels = " ".join(ax.get_xlabel() + ax.get_ylabel() for ax in figure.axes)
    assert "(" in labels


def test_the_input_against_position_is_the_root_of_the_share_times_the_carrier() -> None:
    velvet = Velvet()
    figure = figures.input_against_position({"velvet": velvet, "grating": Grating(4e-3)}, voltage_v=80.0)
    for ax, share in zip(figure.axes, (velvet.force_share_along, Grating(4e-3).force_share), strict=True):
        carrier, envelope = ax.get_lines()
        x_m = envelope.get_xdata() * 1e-3
        np.testing.assert_allclose(envelope.get_ydata(), 80 * np.sqrt(share(x_m)), atol=1e-12)
        expected_v = envelope.get_ydata() * np.sin(2 * np.pi * 100 * x_m / 0.05)
        np.testing.assert_allclose(carrier.get_ydata(), expected_v, atol=1e-9)
    assert "carrier of 100 Hz" in figure.axes[-1].get_xlabel()


def test_force_against_area_is_the_force_of_each_law() -> None:
    figure = figures.force_against_area(voltage_v=50.0)
    for line in figure.axes[0].get_lines():
        area_m2 = line.get_xdata()[-1] * 1e-4
        expected_n = electrostatic_force_n([50.0], rate_hz=1.0, skin=Skin(), area_m2=area_m2, law=line.get_label())
        assert line.get_ydata()[-1] == pytest.approx(float(expected_n[0]))


def test_force_over_area_is_one_curve_without_body_resistance() -> None:
    figure = figures.force_for_inputs((1e-4, 2e-4))
    for ax in figure.axes[3:]:
        one, two = (line.get_ydata() for line in ax.get_lines())
        np.testing.assert_allclose(two, 2 * one, rtol=1e-12)


def test_mean_applied_forces_are_drawn_with_their_participants() -> None:
    figure = figures.applied_forces({"0.5 N": [0.4, 0.6], "3 N": [2.0, 4.0]})
    points = [line.get_ydata().tolist() for line in figure.axes[0].get_lines() if len(line.get_ydata()) == 2]
    assert [0.4, 0.6] in points
    assert [2.0, 4.0] in points
    with pytest.raises(InvalidParameter, match="found a condition without forces"):
        figures.applied_forces({"0.5 N": []})


def test_ellipses_have_the_measured_axes() -> None:
    figure = figures.contact_ellipse([Print(1.0, 0.012, 0.01), Print(2.0, 0.014, 0.011)])
    axes_mm = [(patch.width, patch.height) for patch in figure.axes[0].patches]
    np.testing.assert_allclose(axes_mm, [(10.0, 12.0), (11.0, 14.0)])
    one, two = (line.get_xydata()[0] for line in figure.axes[1].get_lines()[:2])
    np.testing.assert_allclose([one, two], [(1.0, np.pi / 4 * 1.2), (2.0, np.pi / 4 * 1.4 * 1.1)])


def test_more_curves_than_colours_are_all_drawn() -> None:
    prints = [Print(float(n), 0.01 + 1e-4 * n, 0.01) for n in range(1, 10)]
    assert len(figures.contact_ellipse(prints).axes[0].patches) == 9
    forces = figures.force_for_inputs([1e-5 * n for n in range(1, 10)]).axes[3]
    assert len(forces.get_lines()) == 9


def test_importing_the_package_imports_neither_matplotlib_nor_numba() -> None:
    code = (
        "import sys, tactometry.stimuli.electrovibration.figures\n"
        "print([name for name in ('matplotlib', 'numba') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
