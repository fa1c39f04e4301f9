"""How finely an output must be sampled so that straight lines between its samples are right to an error.

A function without content above an angular frequency W has ``|f''| <= W^2 max |f|`` (Bernstein), and a chord over a
step h is off by at most ``h^2 max |f''|/8``: relative to the peak the error is at most ``(W h)^2/8``.
"""

from collections.abc import Callable
from math import ceil, pi, sqrt
from typing import TYPE_CHECKING

from tactometry.stimuli.scenes.effect import Surroundings

if TYPE_CHECKING:
    from tactometry.stimuli.electrovibration.pieces import Pieces, Real

FEWEST = 16


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
    """Samples of a record for an error of straight lines between them."""
    duration_s: float = scene.surface.duration_s  # type: ignore[attr-defined]
    return max(FEWEST, ceil(duration_s * force_rad_per_s(scene) / sqrt(8 * error)) + 1)


def chord_error(scene: Surroundings, n: int) -> float:
    """The bound for a number of samples."""
    duration_s: float = scene.surface.duration_s  # type: ignore[attr-defined]
    return (force_rad_per_s(scene) * duration_s / (n - 1)) ** 2 / 8


def grid(n_samples: int) -> "Callable[[Pieces], Real]":
    """Equal steps from the beginning to the end of a voltage."""
    import numpy as np

    return lambda voltage: np.linspace(0.0, voltage.end_s, n_samples)
