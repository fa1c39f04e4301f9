"""Figures of electrovibration; each function returns a matplotlib figure."""

from collections.abc import Mapping, Sequence
from itertools import cycle
from typing import TYPE_CHECKING, Literal

import numpy as np

from tactometry.palette import COLOURS
from tactometry.stimuli.electrovibration.attraction.contact_area import UNVERIFIED_PRINTS, Print, power_law_of_prints
from tactometry.stimuli.electrovibration.attraction.force import LAWS, Law, electrostatic_force_n_at, force_form
from tactometry.stimuli.electrovibration.skin.skin import Skin
from tactometry.stimuli.electrovibration.skin.stack import DEEPER_TISSUE, STRATUM_CORNEUM
from tactometry.stimuli.electrovibration.textures.followed_texture import share_along
from tactometry.stimuli.electrovibration.textures.texture import Texture, Velvet
from tactometry.stimuli.electrovibration.waveforms.periodic import Trapezoid
from tactometry.stimuli.electrovibration.waveforms.sine import Sine
from tactometry.stimuli.electrovibration.waveforms.step import Step

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LENGTH_M, SPEED_M_PER_S, CARRIER_HZ = 0.04, 0.05, 100.0
LARGEST_M2 = 3e-4
LAW: Law = "sc_layer"
LEVEL_DB = 40.0
DASHES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 1)), (0, (8, 2)))


def input_against_position(textures: Mapping[str, Texture | Velvet], *, voltage_v: float = 100.0) -> "Figure":
    """Plot voltage against finger position, a panel per texture."""
    x_m = np.linspace(0, LENGTH_M, 8001)
    figure, axes = _panels(len(textures), 1, (7.0, 1.0 + 1.3 * len(textures)), sharex="all")
    for ax, (name, texture), colour in zip(axes, textures.items(), cycle(COLOURS), strict=False):
        envelope_v = voltage_v * np.sqrt(share_along(texture, x_m))
        carrier = np.sin(2 * np.pi * CARRIER_HZ * x_m / SPEED_M_PER_S)
        ax.plot(1e3 * x_m, envelope_v * carrier, color="0.6", linewidth=0.5)
        ax.plot(1e3 * x_m, envelope_v, color=colour, linewidth=1.8)
        ax.set(ylabel="voltage (V)", ylim=(-1.15 * voltage_v, 1.15 * voltage_v))
        ax.set_title(name, loc="left", fontsize=9)
    axes[-1].set_xlabel(
        f"finger position (mm), sliding at {1e3 * SPEED_M_PER_S:g} mm/s; "
        f"carrier of {CARRIER_HZ:g} Hz (thin), envelope (thick)"
    )
    return figure


def force_against_area(*, voltage_v: float = 100.0) -> "Figure":
    """Plot the force just after a step against contact area."""
    areas_m2 = np.geomspace(LARGEST_M2 / 100, LARGEST_M2, 60)
    figure, (ax,) = _panels(1, 1, (6.0, 4.0))
    for law, colour, dash in zip(LAWS, cycle(COLOURS), cycle(DASHES), strict=False):
        forces_n = [_force_after_step_n(law, area, voltage_v) for area in areas_m2]
        ax.loglog(1e4 * areas_m2, forces_n, color=colour, linestyle=dash, label=law)
    ax.set(xlabel="contact area (cm²)", ylabel="electrostatic force (N)")
    ax.set_title(f"{voltage_v:g} V step, at once after it", loc="left", fontsize=9)
    ax.legend(frameon=False, title="force law")
    ax.grid(which="major", color="0.9")
    return figure


def skin_properties() -> "Figure":
    """Plot resistivity and relative permittivity against frequency."""
    layers = {"stratum corneum (unverified)": STRATUM_CORNEUM, "deeper tissue (unverified)": DEEPER_TISSUE}
    figure, axes = _panels(1, 2, (8.0, 3.6))
    for (name, layer), colour, dash in zip(layers.items(), cycle(COLOURS), cycle(DASHES), strict=False):
        f_hz = np.geomspace(layer.frequencies_hz[0], layer.frequencies_hz[-1], 200)
        permittivity, resistivity = layer.properties(f_hz)
        axes[0].loglog(f_hz, resistivity, color=colour, linestyle=dash, label=name)
        axes[1].loglog(f_hz, permittivity, color=colour, linestyle=dash, label=name)
    axes[0].set(xlabel="frequency (Hz)", ylabel="resistivity (Ω m)")
    axes[1].set(xlabel="frequency (Hz)", ylabel="relative permittivity")
    axes[0].legend(frameon=False, fontsize=8)
    for ax in axes:
        ax.grid(which="major", color="0.9")
    return figure


def force_for_inputs(
    areas_m2: Sequence[float] = (0.5e-4, 1.0e-4, 1.5e-4),
) -> "Figure":
    """Plot voltage and force over time of a step, trapezoid and sine."""
    shown = {
        "step": Step(onset_s=1e-3, duration_s=6e-3).pieces(LEVEL_DB),
        "trapezoid": Trapezoid(rise_s=1e-3, high_s=3e-3, fall_s=1e-3, low_s=3e-3, duration_s=16e-3).pieces(LEVEL_DB),
        "sine, 60 Hz": Sine(frequency_hz=60.0, ramp_s=0.0, duration_s=2 / 60).pieces(LEVEL_DB),
    }
    figure, axes = _panels(2, len(shown), (3.2 * len(shown), 4.6), sharex="col")
    for column, (name, pieces) in enumerate(shown.items()):
        t_s = np.linspace(0, pieces.end_s, 2001)[:-1]
        above, below = axes[column], axes[len(shown) + column]
        above.plot(1e3 * t_s, pieces.at(t_s), color="0.3")
        above.set_title(name, loc="left", fontsize=9)
        for area_m2, colour, dash in zip(areas_m2, cycle(COLOURS), cycle(DASHES), strict=False):
            force_n = electrostatic_force_n_at(t_s, pieces, skin=Skin(), area_m2=area_m2, law=LAW)
            below.plot(1e3 * t_s, 1e3 * force_n, color=colour, linestyle=dash, label=f"{1e4 * area_m2:g} cm²")
        below.set_ylim(0, None)
        below.set_xlabel("time (ms)")
    axes[0].set_ylabel("voltage (V)")
    axes[len(shown)].set_ylabel("electrostatic force (mN)")
    axes[len(shown)].legend(frameon=False, fontsize=8, title=f"contact area ({LAW})", title_fontsize=8)
    return figure


def contact_ellipse(prints: Sequence[Print] = UNVERIFIED_PRINTS) -> "Figure":
    """Plot the contact ellipse at each force, and its area."""
    from matplotlib.patches import Ellipse

    figure, (left, right) = _panels(1, 2, (8.0, 3.8))
    ordered = sorted(prints, key=lambda one: one.force_n)
    for one, colour, dash in zip(ordered, cycle(COLOURS), cycle(DASHES), strict=False):
        ellipse = Ellipse((0, 0), 1e3 * one.width_m, 1e3 * one.length_m, fill=False, edgecolor=colour, linestyle=dash)
        left.add_patch(ellipse)
        ellipse.set(linewidth=1.8, label=f"{one.force_n:g} N")
        right.plot(one.force_n, 1e4 * one.area_m2, "o", color=colour)
    reach = 0.6e3 * max(one.length_m for one in prints)
    left.set(xlim=(-reach, 1.7 * reach), ylim=(-reach, reach), aspect="equal")
    left.set(xlabel="across the finger (mm)", ylabel="along the finger (mm)")
    left.legend(frameon=False, title="applied force", loc="right")
    law, top = power_law_of_prints(prints), ordered[-1].force_n
    force_n = np.linspace(0, 1.05 * top, 200)
    right.plot(force_n, 1e4 * law.area_m2(force_n), color="0.4", zorder=0, label=f"A ∝ F^{law.exponent:.2f}")
    right.set(xlabel="applied force (N)", ylabel="contact area (cm²)", xlim=(0, None), ylim=(0, None))
    right.legend(frameon=False, loc="lower right")
    if prints is UNVERIFIED_PRINTS:
        left.set_title("prints: unverified defaults", loc="left", fontsize=9)
    return figure


def _panels(
    rows: int, columns: int, size_in: tuple[float, float], sharex: Literal["none", "all", "col"] = "none"
) -> "tuple[Figure, list[Axes]]":
    from matplotlib.figure import Figure

    figure = Figure(figsize=size_in, layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, sharex=sharex)
    for ax in axes.flat:
        ax.spines[["top", "right"]].set_visible(False)
    return figure, list(axes.flat)


def _force_after_step_n(law: Law, area_m2: float, voltage_v: float) -> float:
    form = force_form(law, Skin(), area_m2)
    at_once = form.relaxations.dc_gain + sum(form.relaxations.gains)
    return form.newton_per_v2 * (at_once * voltage_v) ** 2
