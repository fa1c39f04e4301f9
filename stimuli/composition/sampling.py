"""How finely an output must be sampled so that straight lines between its samples are right to an error.

A function without content above an angular frequency W has ``|f''| <= W^2 max |f|`` (Bernstein), and a chord over a
step h is off by at most ``h^2 max |f''|/8``: relative to the peak the error is at most ``(W h)^2/8``.

Envelopes have kinks where the voltage is zero. The force goes with the square and hides them, but for a lossy skin,
whose voltage is not zero there: that brings an error in proportion to the step (an estimate, checked by tests).
Beside a constant of r times the peak the force holds the envelope itself, whose kinks of 2 pi f are 4 pi f r/(1 + r)^2
of the slope over the peak: a quarter of that times the step is the error.

Where a raised-cosine ramp ends the second derivative of the voltage steps by ``J = (pi/ramp)^2/2`` of its peak. What a
lossy skin with a rate ``1/tau = q w`` at a tone w hands on of that tone is ``1/sqrt(1 + q^2)``, turned by a phase, but
the step passes whole: it adds at most ``J (sqrt(1 + q^2) + 1)`` to the curvature of the force over its peak, and
``2 J sqrt(1 + q^2)`` times a constant beside the tone.

Dry friction jumps where a finger begins to slip or to stick: no line over a jump is right, so that its error is that
between the events, which are exact.
"""

from collections.abc import Callable
from math import ceil, hypot, pi, sqrt

from .effect import Demand, Size, Surroundings

FEWEST, MOST = 16, 4_000_000
"""Samples of a record; the most take about 2 GB."""
VACUUM_F_PER_M = 8.8541878128e-12


def voltage_hz(scene: Surroundings) -> float:
    """The highest frequency in the voltage of an electrovibration scene."""
    tone_hz: float = scene.surface.frequency_hz  # type: ignore[attr-defined]
    if scene.surface.ramp_s:  # type: ignore[attr-defined]
        tone_hz += 1 / (2 * scene.surface.ramp_s)  # type: ignore[attr-defined]
    carrier, texture = scene.find("carrier"), scene.find("texture")
    if carrier is not None:
        tone_hz += carrier.carrier_hz  # type: ignore[attr-defined]
    if texture is not None:
        tone_hz += texture.frequency_hz(scene) / 2  # type: ignore[attr-defined]
    return tone_hz


def force_rad_per_s(scene: Surroundings) -> float:
    """Angular frequency above which the force has nothing: twice that of the voltage, ramps included.

    >>> from tactometry.stimuli.scenes.scene import Scene
    >>> from tactometry.stimuli.scenes.surfaces.electrovibration import Electrovibration
    >>> scene = Scene(Electrovibration(frequency_hz=60.0), (), outputs=("voltage_v",))
    >>> round(force_rad_per_s(scene) / (4 * pi), 9)
    70.0
    """
    return 4 * pi * voltage_hz(scene)


def n_samples(scene: Surroundings, error: float) -> int:
    """Samples of a record for an error of straight lines between them, or as many as are to be had."""
    duration_s: float = scene.surface.duration_s  # type: ignore[attr-defined]
    square, linear = _terms(scene)
    # the root of square step^2 + linear step = error, without a difference of near equals
    step_s = 2 * error / (linear + sqrt(linear**2 + 4 * square * error))
    return min(max(FEWEST, ceil(duration_s / step_s) + 1), MOST)


def per_sample(n_operations: float) -> Callable[[Demand], Size]:
    """The size of a stage that does as many operations with each sample of the record."""
    return lambda demand: Size(n_operations=n_operations * demand.once(samples))


def samples(demand: Demand) -> int:
    """Samples of the record of a scene."""
    return n_samples(demand, demand.error)


def record(demand: Demand) -> Size:
    """The size of the sampling itself."""
    n = demand.once(samples)
    return Size({"n_samples": n}, chord_error(demand, n), float(n))


def chord_error(scene: Surroundings, n: int) -> float:
    """The bound for a number of samples."""
    duration_s: float = scene.surface.duration_s  # type: ignore[attr-defined]
    square, linear = _terms(scene)
    step_s = duration_s / (n - 1)
    return square * step_s**2 + linear * step_s


def _terms(scene: Surroundings) -> tuple[float, float]:
    """Factors of the step squared (curvature) and of the step (kinks, of which only a lossy skin shows any)."""
    leak, kinks = _leak_per_s(scene), _kinks_rad_per_s(scene)
    bandwidth = max(force_rad_per_s(scene), _swing_rad_per_s(scene))
    if kinks:
        bandwidth = max(bandwidth, 2 * leak)
    in_body = 1.0 if scene.find("body") is not None else 0.0
    beside = _share_beside_constant(scene) * _envelope_rad_per_s(scene)
    square = (bandwidth**2 + _ramp_end_per_s2(scene)) / 8
    return square, 2 * kinks * (leak / _carried_rad_per_s(scene) + in_body) + beside


def _ramp_end_per_s2(scene: Surroundings) -> float:
    """Curvature of the force over its peak behind a ramp, 0 without ramps or losses."""
    ramp_s: float = scene.surface.ramp_s  # type: ignore[attr-defined]
    leak = _leak_per_s(scene)
    if not (ramp_s and leak):
        return 0.0
    constant = _constant(scene)
    return (pi / ramp_s) ** 2 / 2 * (hypot(1.0, leak / _carried_rad_per_s(scene)) * (1 + 2 * constant) + 1)


def _carried_rad_per_s(scene: Surroundings) -> float:
    """Angular frequency of the tone or of its carrier."""
    carrier = scene.find("carrier")
    tone_hz: float = scene.surface.frequency_hz  # type: ignore[attr-defined]
    return 2 * pi * (tone_hz if carrier is None else carrier.carrier_hz)  # type: ignore[attr-defined]


def _kinks_rad_per_s(scene: Surroundings) -> float:
    """How fast an envelope goes through its zeros, where it has a kink."""
    texture, rad_per_s = scene.find("texture"), _envelope_rad_per_s(scene)
    if texture is not None:
        rad_per_s += pi * texture.frequency_hz(scene)  # type: ignore[attr-defined]
    return rad_per_s


def _envelope_rad_per_s(scene: Surroundings) -> float:
    carrier = scene.find("carrier")
    if carrier is None or carrier.modulation != "square_root":  # type: ignore[attr-defined]
        return 0.0
    return pi * scene.surface.frequency_hz  # type: ignore[attr-defined, no-any-return]


def _constant(scene: Surroundings) -> float:
    """The voltage beside the tone, over its peak."""
    offset = scene.find("offset")
    return 0.0 if offset is None else abs(offset.ratio)  # type: ignore[attr-defined]


def _share_beside_constant(scene: Surroundings) -> float:
    """What of the kinks of an envelope its product with a constant shows, in the force over its peak."""
    constant = _constant(scene)
    return constant / (1 + constant) ** 2


def _swing_rad_per_s(scene: Surroundings) -> float:
    """How fast a finger pad swings freely, 0 of one without dynamics."""
    dynamics = scene.find("dynamics")
    return getattr(dynamics, "natural_rad_per_s", 0.0)


def _leak_per_s(scene: Surroundings) -> float:
    """``1/tau`` of a leaky corneum, 0 of one without losses."""
    leakage, gap, skin = scene.find("leakage"), scene.find("gap"), scene.surface
    if leakage is None:
        return 0.0
    insulator_m: float = skin.insulator_thickness_m / skin.insulator_permittivity  # type: ignore[attr-defined]
    if gap is not None:
        insulator_m += gap.gap_m  # type: ignore[attr-defined]
    permittivity: float = skin.corneum_permittivity + skin.corneum_thickness_m / insulator_m  # type: ignore[attr-defined]
    return 1 / (VACUUM_F_PER_M * leakage.corneum_resistivity_ohm_m * permittivity)  # type: ignore[attr-defined, no-any-return]
