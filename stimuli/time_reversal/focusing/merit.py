"""Figures of merit of a focus, each with its definition in the name.

Amplitude is the displacement at the focus. Contrasts are ratios of that amplitude to an rms, not in decibels.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Final

import numpy as np

from tactometry.arguments.checked import Matrix, NotNegative, Positive, Vector, checked
from tactometry.arguments.require import ascending, between, expect, not_negative, one_of, positive, whole
from tactometry.errors import InvalidParameter
from tactometry.signal import Signal

from ...arrays import FloatArray
from ..plate.oscillators import QUANTITIES
from ..responses.responses import Point, Responses, chunks
from ..screen.screen import Screen
from ..screen.transducer import PZ27_LOSS_TANGENT
from .focusing import Emission

Grid = tuple[Vector, Vector]

HALF: float = 0.5
"""Half of the amplitude, -6 dB."""


@checked
def contrast_whole_of(amplitude_m: float, field_m: FloatArray) -> float:
    """Return the ratio of |A| to the plate's rms field at the focus instant."""
    return _ratio(amplitude_m, field_m)


@checked
def width_m(at_m: Vector, profile: Vector, level: float = HALF) -> float:
    """Return the full width of a focus at `level`, along a line.

    `HALF` gives the width at -6 dB, 0.7071 at -3 dB; crossings are interpolated linearly.

    >>> x = np.linspace(-1.0, 1.0, 201)
    >>> round(width_m(x, 1 - np.abs(x)), 12)
    1.0
    """
    ascending("width_m.at_m", at_m)
    between("width_m", 0, 1, level=level)
    expected = f"{np.shape(at_m)}, like at_m, and not all zero"
    expect(np.shape(profile) == np.shape(at_m) and np.any(profile), "profile", f"shape {np.shape(profile)}", expected)
    peak = int(np.argmax(np.abs(profile)))
    relative = profile / profile[peak]  # 1 at the peak, for either sign
    right = _crossing(at_m[peak:], relative[peak:], level)
    left = _crossing(at_m[peak::-1], relative[peak::-1], level)
    return right - left


@checked
def area_m2(field_m: Matrix, grid_m: Grid, level: float = HALF) -> float:
    """Return the connected area around the peak above `level` times it."""
    from scipy.ndimage import label

    between("area_m2", 0, 1, level=level)
    for axis_m in grid_m:
        ascending("area_m2.grid_m", axis_m)
    expected = f"{tuple(map(len, grid_m))}, like the grid, and not all zero"
    expect(field_m.shape == tuple(map(len, grid_m)) and field_m.any(), "field_m", f"shape {field_m.shape}", expected)
    peak = np.unravel_index(np.argmax(np.abs(field_m)), field_m.shape)
    islands, _ = label(field_m / field_m[peak] >= level)
    cell = (grid_m[0][1] - grid_m[0][0]) * (grid_m[1][1] - grid_m[1][0])
    return float(np.count_nonzero(islands == islands[peak]) * cell)


@checked
def envelope(signal: FloatArray) -> FloatArray:
    """Return the magnitude of the analytic signal along the last axis."""
    from scipy.signal import hilbert

    whole("envelope", lowest=1, signal=np.size(signal))
    return np.asarray(np.abs(hilbert(signal, axis=-1)))


@checked
def temporal_width_s(signal_m: Vector, rate_hz: Positive, level: float = HALF) -> float:
    """Return the width in time of the envelope at `level` times its peak."""
    return width_m(np.arange(len(signal_m)) / rate_hz, envelope(signal_m), level)


@checked
def uniformity(amplitudes_m: Vector) -> float:
    """Return 1 - SD / mean over focus positions."""
    amplitudes = np.abs(np.asarray(amplitudes_m, float))
    if amplitudes.size < 2 or not amplitudes.any():
        raise InvalidParameter(f"amplitudes_m: found {amplitudes.size} values, expected two or more, not all zero")
    return 1 - float(np.std(amplitudes, ddof=1) / np.mean(amplitudes))


def _ratio(amplitude: float, field: FloatArray) -> float:
    rms = math.sqrt(float(np.mean(np.square(field)))) if np.size(field) else 0.0
    expect(rms > 0.0, "field", "zero everywhere", "a field that is not zero")
    return abs(amplitude) / rms


def _crossing(at: FloatArray, relative: FloatArray, level: float) -> float:
    below = np.flatnonzero(relative < level)
    expect(below.size != 0, "profile", f"no point below {level} of the peak", "a longer line")
    i = int(below[0])
    positive("width_m", profile=float(relative[i - 1] - relative[i]))
    share = (relative[i - 1] - level) / (relative[i - 1] - relative[i])
    return float(at[i - 1] + share * (at[i] - at[i - 1]))


@checked
def switched_power_w(signal: Signal, channel_capacitance_f: float) -> float:
    """Return the mean power of a drive that switches between levels.

    Each step dV of a capacitance at a stiff supply dissipates C dV^2 / 2. A +-V bridge loses 2 C V^2 per transition, or
    Q C 2 V^2 r_t in total. Use `dielectric_power_w` for a waveform without steps.
    """
    _drive("switched_power_w", signal, channel_capacitance_f)
    lost_j = 0.5 * channel_capacitance_f * np.sum(np.diff(signal.samples, axis=1) ** 2)
    return float(lost_j * signal.rate_hz / (signal.samples.shape[1] - 1))


@checked
def dielectric_power_w(
    signal: Signal, channel_capacitance_f: float, loss_tangent: NotNegative = PZ27_LOSS_TANGENT
) -> float:
    """Return the mean dielectric loss of a drive that repeats.

    P = w C tan(delta) V^2 / 2 for a component of amplitude V (the definition of the loss tangent), summed over the
    components of all channels. The heat of a linear amplifier depends on its class and supply and is not included.

    >>> sine = Signal(30 * np.sin(np.pi / 10 * np.arange(1000))[None], 100e3, "V")
    >>> round(dielectric_power_w(sine, 5e-9, 0.017) * 1e6)
    1202
    """
    _drive("dielectric_power_w", signal, channel_capacitance_f)
    n = signal.samples.shape[1]
    omega_rad_per_s = 2 * np.pi * np.abs(np.fft.fftfreq(n, 1 / signal.rate_hz))
    mean_square_v2 = np.sum(np.abs(np.fft.fft(signal.samples, axis=1)) ** 2, axis=0) / n**2
    return float(channel_capacitance_f * loss_tangent * (omega_rad_per_s @ mean_square_v2))


def _drive(owner: str, signal: Signal, channel_capacitance_f: float) -> None:
    not_negative(owner, channel_capacitance_f=channel_capacitance_f)
    expect(signal.samples.shape[1] >= 2, "signal", "fewer than two samples", "a drive")


@checked
def contributions_m(responses: Responses, voltage_v: float) -> FloatArray:
    """Return the contribution of each transducer to a one-bit focus."""
    return np.asarray(voltage_v * np.abs(responses.samples).sum(axis=2))


@checked
def amplitude_over_count_m(contributions: Matrix, rng: np.random.Generator, n_draws: int = 50) -> FloatArray:
    """Return amplitudes of 1..Q transducers, added in random orders."""
    whole("amplitude_over_count_m", lowest=1, n_draws=n_draws)
    orders = (rng.permutation(contributions.shape[1]) for _ in range(n_draws))
    return np.stack([np.cumsum(contributions[:, order], axis=1) for order in orders])


@checked
def amplitude_by_subset_m(contributions: Matrix, subsets: Mapping[str, Sequence[int]]) -> dict[str, FloatArray]:
    """Return focus amplitudes (n_points,) of named subsets of transducers.

    Raises `InvalidParameter` if a subset is empty or names a missing channel.
    """
    n_channels = contributions.shape[1]
    for name, channels in subsets.items():
        are_channels = len(channels) > 0 and set(channels) <= set(range(n_channels))
        expect(are_channels, f"subsets[{name!r}]", list(channels), f"channels from 0 to {n_channels - 1}")
    return {name: contributions[:, list(channels)].sum(axis=1) for name, channels in subsets.items()}


@checked
def resolution_per_focus_m(
    screen: Screen, foci: Sequence[Point], emission: Emission, level: float = HALF
) -> FloatArray:
    """Return the widths (n_foci, 2) along x and y of each simulated focus."""
    return np.array([_widths(screen, focus, emission, level) for focus in foci])


def _widths(screen: Screen, focus: Point, emission: Emission, level: float) -> tuple[float, float]:
    signal = emission.drive(emission.responses(screen, [focus]))
    last = signal.samples.shape[1] - 1
    amplitudes = modal_amplitudes(screen, signal, last, emission.f_max_hz)
    # one wavelength at the mean frequency to each side
    reach = 2 * np.sqrt(np.pi * screen.plate.wave_constant_m2_per_s / emission.band.mean_hz / 2)
    sides = screen.plate.length_m, screen.plate.width_m
    around = ((max(at - reach, 0.0), min(at + reach, side)) for at, side in zip(focus, sides, strict=True))
    x, y = (np.linspace(start, end, 241) for start, end in around)

    modes = screen.modes(emission.f_max_hz)
    along_x = modes.field(amplitudes, x, np.array([focus[1]]))[:, 0]
    along_y = modes.field(amplitudes, np.array([focus[0]]), y)[0]
    return width_m(x, along_x, level), width_m(y, along_y, level)


MAX_GRID: Final = 100_000


@checked
def modal_amplitudes(
    screen: Screen, signal: Signal, sample: int, f_max_hz: float, quantity: str = "displacement"
) -> FloatArray:
    """Return every mode at one sample of a drive, (n_modes,).

    Parameters
    ----------
    sample : int
        Index of the sample, at least 0; ``n_samples - 1`` is the focus instant.
    """
    one_of("modal_amplitudes.quantity", quantity, QUANTITIES)
    forces = screen.modal_forces(f_max_hz)
    expected = f"{forces.shape[1]} as in the screen"
    expect(signal.samples.shape[0] == forces.shape[1], "signal", f"{signal.samples.shape[0]} channels", expected)
    whole("modal_amplitudes", lowest=0, sample=sample)
    # by age: the latest sample first, `first` samples ago after the end of the drive
    first = max(sample + 1 - signal.samples.shape[1], 0)
    past = signal.samples[:, : sample + 1][:, ::-1]
    oscillators = screen.oscillators(f_max_hz)
    total = np.zeros(oscillators.n)
    for start, stop in chunks(past.shape[1]):
        basis = oscillators.impulse(signal.rate_hz, first + start, first + stop, quantity)
        total += np.einsum("nq,nq->n", basis @ past[:, start:stop].T, forces)
    return total / (screen.plate.mass_kg * signal.rate_hz)


@checked
def grid(screen: Screen, n_x: int, n_y: int) -> Grid:
    """Return equally spaced coordinates from edge to edge."""
    whole("grid", lowest=1, highest=MAX_GRID, n_x=n_x, n_y=n_y)
    return np.linspace(0, screen.plate.length_m, n_x), np.linspace(0, screen.plate.width_m, n_y)


@checked
def field(screen: Screen, signal: Signal, sample: int, at_m: Grid, f_max_hz: float) -> FloatArray:
    """Return the displacement (m) on a grid at one sample of a drive."""
    return screen.modes(f_max_hz).field(modal_amplitudes(screen, signal, sample, f_max_hz), *at_m)


@checked
def movie(screen: Screen, signal: Signal, samples: Sequence[int], at_m: Grid, f_max_hz: float) -> Iterator[FloatArray]:
    """Yield the fields at ascending samples, from one exact run of the drive."""
    draw = screen.modes(f_max_hz).frame(*at_m)
    for amplitudes in modal_history(screen, signal, samples, f_max_hz).T:
        yield draw(np.ascontiguousarray(amplitudes))


@checked
def modal_history(screen: Screen, signal: Signal, samples: Sequence[int], f_max_hz: float) -> FloatArray:
    """Return modal displacements at ascending samples (n_modes, n_kept)."""
    from ..plate.propagator import run_impulses

    if len(samples) == 0 or min(samples) < 0 or any(np.diff(samples) <= 0):
        raise InvalidParameter(f"samples: found {list(samples)[:4]}.., expected ascending numbers, at least 0")
    forces = screen.modal_forces(f_max_hz) / (screen.plate.mass_kg * signal.rate_hz)
    padded = np.zeros((signal.samples.shape[0], samples[-1] + 1))
    n = min(signal.samples.shape[1], padded.shape[1])
    padded[:, :n] = signal.samples[:, :n]
    oscillators = screen.oscillators(f_max_hz)
    return run_impulses(oscillators, forces @ padded, signal.rate_hz, np.asarray(samples, np.int64))
