"""Sampling of outputs for linear interpolation within an error.

A function without content above an angular frequency W has ``|f''| <= W^2 max |f|`` (Bernstein), and linear
interpolation over a step h errs by at most ``h^2 max |f''|/8``. Relative to the peak the error is at most ``(W
h)^2/8``.

Envelopes have kinks where the voltage is zero. The force is quadratic in the voltage, which hides the kinks. In a lossy
skin the voltage is not zero there, and the error is proportional to the step (an estimate, checked by tests). With a
constant of r times the peak, the force contains the envelope itself. Its kinks of 2 pi f change the slope over the peak
by 4 pi f r/(1 + r)^2, and the error is a quarter of that times the step.

At the end of a raised-cosine ramp the second derivative of the voltage steps by ``J = (pi/ramp)^2/2`` of its peak. A
lossy skin with a rate ``1/tau = q w`` at a tone w scales that tone by ``1/sqrt(1 + q^2)`` and shifts its phase, but
passes the step unchanged. The step adds at most ``J (sqrt(1 + q^2) + 1)`` to the curvature of the force over its peak,
and ``2 J sqrt(1 + q^2)`` times a constant added to the tone.

Dry friction jumps when a finger begins to slip or to stick. Linear interpolation fails across a jump, so the error
applies between the events, whose times are exact.
"""

from collections.abc import Callable
from math import ceil, hypot, pi, sqrt

from ..defaults import VACUUM_PERMITTIVITY_F_PER_M
from .content import VoltageContent
from .effect import Demand, Size, Surroundings

FEWEST, MOST = 16, 4_000_000
"""Limits of the number of samples of a record; the upper one takes about 2 GB."""


def force_rad_per_s(scene: Surroundings) -> float:
    """Return the highest angular frequency of the force, ramps included.

    >>> from tactometry.stimuli.scenes.scene import Scene
    >>> from tactometry.stimuli.scenes.surfaces.electrovibration import Electrovibration
    >>> scene = Scene(Electrovibration(frequency_hz=60.0), (), outputs=("voltage_v",))
    >>> round(force_rad_per_s(scene) / (4 * pi), 9)
    70.0
    """
    surface = scene.surface
    ramps_hz = 1 / (2 * surface.ramp_s) if surface.ramp_s else 0.0
    return float(4 * pi * (surface.frequency_hz + ramps_hz + content_of(scene).added_hz))


def n_samples(scene: Surroundings, error: float) -> int:
    """Return the samples needed for an interpolation error, at most `MOST`."""
    square, linear = _terms(scene)
    # the root of square step^2 + linear step = error, without cancellation
    step_s = 2 * error / (linear + sqrt(linear**2 + 4 * square * error))
    duration_s: float = scene.surface.duration_s
    return min(max(FEWEST, ceil(duration_s / step_s) + 1), MOST)


def per_sample(n_operations: float) -> Callable[[Demand], Size]:
    """Return the size of a stage by its operations per sample of the record."""
    return lambda demand: Size(n_operations=n_operations * demand.once(samples))


def samples(demand: Demand) -> int:
    return n_samples(demand, demand.error)


def record(demand: Demand) -> Size:
    n = demand.once(samples)
    return Size({"n_samples": n}, chord_error(demand, n), float(n))


def chord_error(scene: Surroundings, n: int) -> float:
    """Return the bound of the interpolation error with n samples."""
    square, linear = _terms(scene)
    step_s: float = scene.surface.duration_s / (n - 1)
    return square * step_s**2 + linear * step_s


def content_of(scene: Surroundings) -> VoltageContent:
    """Return the sum of the content of all effects."""
    return sum((effect.in_voltage(scene) for effect in scene.effects), start=VoltageContent())


def _terms(scene: Surroundings) -> tuple[float, float]:
    """Return error factors of the squared step (curvature), step (kinks)."""
    content = content_of(scene)
    skin = scene.surface
    insulator_m = skin.insulator_thickness_m / skin.insulator_permittivity + content.gap_m
    permittivity = skin.corneum_permittivity + skin.corneum_thickness_m / insulator_m
    # 1/tau of a leaky corneum, 0 of a lossless one
    leak = float(1 / (VACUUM_PERMITTIVITY_F_PER_M * content.resistivity_ohm_m * permittivity))
    carried = 2 * pi * (content.carrier_hz or scene.surface.frequency_hz)
    kinks = content.envelope_rad_per_s + content.kinks_rad_per_s
    bandwidth = max(force_rad_per_s(scene), content.swing_rad_per_s)
    if kinks:
        bandwidth = max(bandwidth, 2 * leak)
    # kinks of envelope times constant, in the force over its peak
    beside_constant = content.constant / (1 + content.constant) ** 2 * content.envelope_rad_per_s
    curvature = _ramp_end_per_s2(scene.surface.ramp_s, leak, leak / carried, content.constant)
    square = (bandwidth**2 + curvature) / 8
    return square, 2 * kinks * (leak / carried + content.bare_kinks) + beside_constant


def _ramp_end_per_s2(ramp_s: float, leak_per_s: float, leak_of_tone: float, constant: float) -> float:
    """Return the curvature of the force over its peak at the end of a ramp."""
    if not (ramp_s and leak_per_s):
        return 0.0
    return (pi / ramp_s) ** 2 / 2 * (hypot(1.0, leak_of_tone) * (1 + 2 * constant) + 1)
