"""How even a screen is over its focus positions and transducers (thesis 4.6).

Under the one-bit drive every transducer adds V times the sum of its absolute response, so that the amplitude of any
subset is a sum of one matrix.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from tactometry.arguments.annotations import Matrix
from tactometry.arguments.checked import checked
from tactometry.arguments.require import whole
from tactometry.errors import InvalidParameter

from ...arrays import FloatArray
from ..focusing.emission import Emission
from ..focusing.focusing import drive
from ..responses.responses import Point, Responses
from ..screen.screen import Screen
from .field import modal_amplitudes
from .merit import HALF, width_m


@checked
def contributions_m(responses: Responses, voltage_v: float) -> FloatArray:
    """(n_points, n_channels): what each transducer adds to a one-bit focus at each point; its amplitude alone."""
    return np.asarray(voltage_v * np.abs(responses.samples).sum(axis=2))


@checked
def amplitude_over_count_m(contributions: Matrix, rng: np.random.Generator, n_draws: int = 50) -> FloatArray:
    """(n_draws, n_points, n_channels): focus amplitude of 1..Q transducers, added in random orders."""
    whole("amplitude_over_count_m", lowest=1, n_draws=n_draws)
    orders = (rng.permutation(contributions.shape[1]) for _ in range(n_draws))
    return np.stack([np.cumsum(contributions[:, order], axis=1) for order in orders])


@checked
def amplitude_by_subset_m(contributions: Matrix, subsets: Mapping[str, Sequence[int]]) -> dict[str, FloatArray]:
    """Focus amplitudes (n_points,) of named subsets of transducers.

    Raises
    ------
    InvalidParameter
        If a subset is empty or names a channel that is not there.
    """
    for name, channels in subsets.items():
        if not channels or not set(channels) <= set(range(contributions.shape[1])):
            raise InvalidParameter(
                f"subsets[{name!r}]: found {list(channels)}, expected channels from 0 to {contributions.shape[1] - 1}"
            )
    return {name: contributions[:, list(channels)].sum(axis=1) for name, channels in subsets.items()}


@checked
def resolution_per_focus_m(
    screen: Screen, foci: Sequence[Point], emission: Emission, level: float = HALF
) -> FloatArray:
    """(n_foci, 2): widths along x and y of each simulated focus."""
    return np.array([_widths(screen, focus, emission, level) for focus in foci])


def _widths(screen: Screen, focus: Point, emission: Emission, level: float) -> tuple[float, float]:
    signal = drive(emission.responses(screen, [focus]), emission.voltage_v, emission.quantiser)
    last = signal.samples.shape[1] - 1
    amplitudes = modal_amplitudes(screen, signal, last, emission.f_max_hz)
    # a wavelength at the mean frequency of the band, to each side
    reach = 2 * np.sqrt(np.pi * screen.plate.wave_constant_m2_per_s / emission.band.mean_hz / 2)
    x, y = (_around(at, reach, side) for at, side in zip(focus, _sides(screen), strict=True))
    modes = screen.modes(emission.f_max_hz)
    along_x = modes.field(amplitudes, x, np.array([focus[1]]))[:, 0]
    along_y = modes.field(amplitudes, np.array([focus[0]]), y)[0]
    return width_m(x, along_x, level), width_m(y, along_y, level)


def _sides(screen: Screen) -> tuple[float, float]:
    return screen.plate.length_m, screen.plate.width_m


def _around(at_m: float, reach_m: float, side_m: float) -> FloatArray:
    return np.linspace(max(at_m - reach_m, 0.0), min(at_m + reach_m, side_m), 241)
