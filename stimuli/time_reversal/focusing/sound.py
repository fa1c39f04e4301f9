"""Airborne sound of a driven plate.

The model is for ranking drives. Absolute levels depend on the distance and the room.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from tactometry.arguments.checked import NotNegativeArray, Positive, Vector, checked
from tactometry.arguments.require import ascending, not_negative_array, positive
from tactometry.errors import InvalidParameter
from tactometry.signal import Signal

from ...arrays import COMPLEX, FloatArray, fast_length
from ...defaults import AUDIBLE_MAX_HZ, DISTANCE_M
from ..plate.oscillators import Oscillators
from ..plate.plate import Plate
from ..responses.responses import chunks
from ..screen.screen import Screen

SOUND_SPEED_M_PER_S: Final = 343.0
AIR_DENSITY_KG_PER_M3: Final = 1.204
REFERENCE_PRESSURE_PA: Final = 20e-6
FREQUENCIES_AT_ONCE: Final = 1024
NEAR: Final = 1e-9
"""Smallest relative distance from coincidence at which the laws below and above it are evaluated; closer to it the
plate's size limits both."""

_POLES_HZ: Final = (20.598997, 107.65265, 737.86223, 12194.217)


@checked
def a_weighting_db(frequency_hz: NotNegativeArray) -> FloatArray:
    """Return the A-weighting of IEC 61672, minus infinity above 20 kHz.

    >>> [round(float(a), 1) for a in a_weighting_db([100.0, 1000.0, 10000.0])]
    [-19.1, 0.0, -2.5]
    """
    f = np.atleast_1d(np.asarray(frequency_hz, float))
    with np.errstate(divide="ignore"):
        db = 20 * np.log10(_a_gain(f) / _a_gain(np.array([1000.0])))
    return np.where(f <= AUDIBLE_MAX_HZ, db, -np.inf)


@checked
def coincidence_frequency_hz(plate: Plate, sound_speed_m_per_s: Positive = SOUND_SPEED_M_PER_S) -> float:
    """Return the frequency at which bending waves are as fast as sound.

    It is c^2 / (2 pi) sqrt(rho_s / D).

    >>> from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN
    >>> round(coincidence_frequency_hz(A4_SCREEN) / 1e3, 1)
    10.8
    """
    return sound_speed_m_per_s**2 / (2 * math.pi * plate.wave_constant_m2_per_s)


@checked
def radiation_efficiency(plate: Plate, frequency_hz: NotNegativeArray) -> FloatArray:
    """Return the radiation efficiency of a plate in a baffle.

    Above coincidence it is (1 - f_c / f)^(-1/2). Below it the edges radiate (Maidanik 1962; Leppington, Broadbent and
    Heron 1982). Near it the size of the plate limits both, sqrt(k l) (0.5 - 0.15 l / L) with l the shorter side
    (Leppington et al.). The laws are averages over many modes of simply supported edges. Below coincidence, clamped
    edges radiate up to twice as much, and edges without a baffle less.

    >>> from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN
    >>> [round(float(sigma), 3) for sigma in radiation_efficiency(A4_SCREEN, [5e3, 10.8e3, 20e3])]
    [0.075, 2.539, 1.473]
    """
    f = np.asarray(frequency_hz, float)
    f_c = coincidence_frequency_hz(plate)
    of_area = 1 / np.sqrt(np.maximum(1 - f_c / np.maximum(f, f_c), NEAR))
    unlimited = np.where(f < f_c, _of_edges(plate, np.minimum(f / f_c, 1 - NEAR)), of_area)
    shorter, longer = sorted((plate.length_m, plate.width_m))
    limit = np.sqrt(2 * math.pi * f / SOUND_SPEED_M_PER_S * shorter) * (0.5 - 0.15 * shorter / longer)
    return np.asarray(np.minimum(unlimited, limit))


def _of_edges(plate: Plate, f_over_f_c: FloatArray) -> FloatArray:
    """Return P c / (4 pi^2 S f_c) [(1 - x^2) ln((1 + x) / (1 - x)) + 2 x] / (1 - x^2)^1.5, x^2 = f / f_c."""
    x = np.sqrt(f_over_f_c)
    across = (
        SOUND_SPEED_M_PER_S / coincidence_frequency_hz(plate) * plate.perimeter_m / (4 * math.pi**2 * plate.area_m2)
    )
    return np.asarray(across * ((1 - x**2) * np.log((1 + x) / (1 - x)) + 2 * x) / (1 - x**2) ** 1.5)


@checked
@dataclass(frozen=True, eq=False)
class NoiseSpectrum:
    """Mean-square sound pressure per hertz (Pa^2/Hz) over frequency, at a distance, on a hemisphere."""

    frequency_hz: Vector
    pressure_pa2_per_hz: Vector

    def __post_init__(self) -> None:
        ascending("NoiseSpectrum.frequency_hz", self.frequency_hz)
        not_negative_array("NoiseSpectrum.frequency_hz", self.frequency_hz)
        not_negative_array("NoiseSpectrum.pressure_pa2_per_hz", self.pressure_pa2_per_hz)
        if len(self.frequency_hz) != len(self.pressure_pa2_per_hz):
            raise InvalidParameter(
                f"NoiseSpectrum.pressure_pa2_per_hz: found {len(self.pressure_pa2_per_hz)} values, expected "
                f"{len(self.frequency_hz)}, one per frequency"
            )

    @property
    def level_db_re_20upa(self) -> FloatArray:
        """Spectral level per 1 Hz, at least -60 dB."""
        return np.asarray(10 * np.log10(np.maximum(self.pressure_pa2_per_hz / REFERENCE_PRESSURE_PA**2, 1e-6)))

    @property
    def a_weighted_db(self) -> float:
        """A-weighted level up to 20 kHz; minus infinity for silence."""
        weight = 10 ** (a_weighting_db(self.frequency_hz) / 10)
        total = float(np.sum(self.pressure_pa2_per_hz * weight) * (self.frequency_hz[1] - self.frequency_hz[0]))
        return 10 * math.log10(total / REFERENCE_PRESSURE_PA**2) if total > 0 else -math.inf


@checked
def noise(
    screen: Screen,
    signal: Signal,
    f_max_hz: float,
    *,
    distance_m: Positive = DISTANCE_M,
    duration_s: float | None = None,
) -> NoiseSpectrum:
    """Return the sound of a drive, by default until 5 tau after its end.

    W = rho_0 c S sigma <v^2>, spread over a hemisphere; <v^2> is computed from the modes in the frequency domain.
    """
    frequency_hz, power = velocity_spectrum(screen, signal, f_max_hz)
    span_s = signal.duration_s + 5 * screen.attenuation.tau_s if duration_s is None else duration_s
    positive("noise", duration_s=span_s)
    sigma = radiation_efficiency(screen.plate, frequency_hz)
    watt_per_hz = AIR_DENSITY_KG_PER_M3 * SOUND_SPEED_M_PER_S * screen.plate.area_m2 * sigma * power / span_s
    intensity = watt_per_hz / (2 * math.pi * distance_m**2)
    return NoiseSpectrum(frequency_hz, intensity * AIR_DENSITY_KG_PER_M3 * SOUND_SPEED_M_PER_S)


@checked
def velocity_spectrum(screen: Screen, signal: Signal, f_max_hz: float) -> tuple[FloatArray, FloatArray]:
    """Return frequencies and the energy spectrum of the mean v^2.

    Its integral over frequency is the time integral of the mean over the plate of v^2 (m^2/s). Since
    <phi^2> = 1 the mean over the plate is the sum over modes.
    """
    positive("Screen.attenuation", tau_s=screen.attenuation.tau_s)
    oscillators = screen.oscillators(f_max_hz)
    n_ringing = round(6 * screen.attenuation.tau_s * signal.rate_hz)  # until the energy has decayed to e^-12
    n_fft = fast_length(2 * signal.samples.shape[1] + n_ringing, COMPLEX)
    frequency_hz = np.fft.rfftfreq(n_fft, 1 / signal.rate_hz)
    played = np.fft.rfft(signal.samples, n_fft) / signal.rate_hz
    w = np.asarray(2 * np.pi * frequency_hz, float)
    total = np.zeros(len(w))
    forces = screen.modal_forces(f_max_hz)
    for start, stop in chunks(len(w), FREQUENCIES_AT_ONCE):
        driven = np.abs(forces @ played[:, start:stop]) ** 2
        total[start:stop] = np.sum(driven * _mobility(oscillators, w[start:stop]), axis=0)
    return np.asarray(frequency_hz), 2 * total / screen.plate.mass_kg**2


def _mobility(oscillators: Oscillators, w: FloatArray) -> FloatArray:
    """Return |i w / (w_n^2 - w^2 + 2 i w / tau)|^2 (n_modes, n_frequencies)."""
    omega2, decay = oscillators.omega_rad_per_s[:, None] ** 2, oscillators.decay_per_s[:, None]
    # `tiny` avoids 0/0 of rigid modes at 0 Hz
    return np.asarray(w**2 / ((omega2 - w**2) ** 2 + (2 * decay * w) ** 2 + np.finfo(float).tiny))


def _a_gain(f: FloatArray) -> FloatArray:
    f1, f2, f3, f4 = (pole**2 for pole in _POLES_HZ)
    s = np.square(f)
    return np.asarray(f4 * s**2 / ((s + f1) * np.sqrt((s + f2) * (s + f3)) * (s + f4)))
