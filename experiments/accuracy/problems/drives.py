"""Accuracy problems of drive signals."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactometry.stimuli.time_reversal import Responses, drive, focus_amplitude, impulse_responses
from tactometry.stimuli.time_reversal.focusing.focusing import emitted
from tactometry.stimuli.time_reversal.focusing.merit import contrast_whole_of, field, modal_history
from tactometry.stimuli.time_reversal.focusing.modulator import modulate
from tactometry.stimuli.time_reversal.plate.oscillators import Oscillators
from tactometry.stimuli.time_reversal.responses.responses import values_at
from tactometry.stimuli.time_reversal.screen.attenuation import TAU_S
from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE, Screen

from ..measure import Problem, Real, Reference, Setting, over_rms

ONE_BIT_TO_HZ, ONE_BIT_LASTS_S = 10e3, 4e-3
FOCI_M = ((0.121, 0.093), (0.06, 0.15), (0.2, 0.05), (0.17, 0.13))
ONE_BIT_RATES_HZ, SEARCH_HZ, N_NEWTON = (25e3, 100e3, 400e3, 1.6e6), 200e3, 5
TONE_HZ, BAND_HZ, TONE_LASTS_S, TONE_AMPLITUDE = 5e3, 25e3, 20e-3, 0.5
BIT_RATES_HZ = (250e3, 1e6, 4e6, 16e6)
RATE_HZ, F_MAX_HZ, FOCUS_M = 60e3, 20e3, (0.121, 0.093)
N_TAU, LONGEST, N_POINTS = (0.5, 1.0, 2.0, 4.0, 6.0, 8.0), 12.0, (120, 85)
Complex = NDArray[np.complex128]


def oversampling() -> Problem:
    """Compare a sampled one-bit drive with one that may switch at any time."""
    screen = replace(A4_PROTOTYPE, sources=A4_PROTOTYPE.sources[::8])
    return Problem(
        "rms error of the focus of each channel over the rms focus, one bit, modes below 10 kHz, 4 ms",
        reference=Reference("closed-form integrals between zero crossings", lambda: _at_crossings(screen), 1e-8),
        error=over_rms,
        settings=tuple(Setting(f"{hz / 1e3:g} kHz", partial(_emission, screen, hz)) for hz in ONE_BIT_RATES_HZ),
    )


def _emission(screen: Screen, rate_hz: float) -> Real:
    """Return displacements due to each one-bit channel (n_foci, n_channels)."""
    timing: dict[str, Any] = {"rate_hz": rate_hz, "duration_s": ONE_BIT_LASTS_S, "f_max_hz": ONE_BIT_TO_HZ}
    responses = impulse_responses(screen, FOCI_M, **timing)
    drives = [drive(responses.at_point(n), 1.0).samples[:, ::-1] for n in range(responses.n_points)]
    return np.asarray(np.einsum("pqn,pqn->pq", np.array(drives), responses.samples))


def _at_crossings(screen: Screen) -> Real:
    """Return integrals of |h| between its exact zero crossings."""
    modes = screen.oscillators(ONE_BIT_TO_HZ)
    forces = screen.modal_forces(ONE_BIT_TO_HZ) / screen.plate.mass_kg
    shapes = values_at(screen, FOCI_M, ONE_BIT_TO_HZ)
    return np.array([[_integral(modes, shape * force) for force in forces.T] for shape in shapes.T])


def _integral(modes: Oscillators, weights: Real) -> float:
    at_s = np.arange(1, round(ONE_BIT_LASTS_S * SEARCH_HZ) + 1) / SEARCH_HZ
    response, half_step_s = weights @ modes.impulse_at(at_s), 0.5 / SEARCH_HZ
    zeros_s = at_s[:-1][response[:-1] * response[1:] < 0] + half_step_s
    for _ in range(N_NEWTON):
        slope = weights @ modes.impulse_at(zeros_s, "velocity")
        zeros_s = zeros_s - np.clip(weights @ modes.impulse_at(zeros_s) / slope, -half_step_s, half_step_s)

    ends_s = np.concatenate([[0.0], zeros_s, [ONE_BIT_LASTS_S]])
    velocity, displacement = (modes.impulse_at(ends_s, quantity) for quantity in ("velocity", "displacement"))
    moved = 1 - velocity - 2 * modes.decay_per_s[:, None] * displacement
    integrals = moved / modes.omega_rad_per_s[:, None] ** 2  # follows from the equation of motion
    return float(np.abs(np.diff(weights @ integrals)).sum())


def modulated(order: int) -> Problem:
    """Compare a tone's sigma-delta bit stream with the tone."""
    line = np.zeros(round(BAND_HZ * TONE_LASTS_S) + 1, complex)
    line[round(TONE_HZ * TONE_LASTS_S)] = -1j * TONE_AMPLITUDE
    return Problem(
        f"rms error in the band of 0 to 25 kHz over the rms of a 5 kHz tone, order {order}, 20 ms",
        reference=Reference("the spectral line of the tone", lambda: line, 1e-12),
        error=over_rms,
        settings=tuple(Setting(f"{hz / 1e6:g} MHz", partial(_modulation, order, hz)) for hz in BIT_RATES_HZ),
    )


first_order = partial(modulated, 1)
second_order = partial(modulated, 2)


def _modulation(order: int, rate_hz: float) -> Complex:
    times_s = np.arange(round(TONE_LASTS_S * rate_hz)) / rate_hz
    return _spectrum(modulate((TONE_AMPLITUDE * np.sin(2 * np.pi * TONE_HZ * times_s))[None, :], order).bits[0])


def _spectrum(samples: NDArray[np.generic]) -> Complex:
    return np.asarray(2 * np.fft.rfft(samples)[: round(BAND_HZ * TONE_LASTS_S) + 1] / samples.size)


def reversal_amplitude() -> Problem:
    """Compare focus amplitudes at shorter reversal times with the longest one."""
    responses = _responses()
    return _against_time(
        "loss of focus amplitude at a shorter reversal time T (one bit, tau = 3.5 ms)",
        lambda reversal_s: focus_amplitude(drive(responses, 1.0, reversal_s=reversal_s), responses),
        Reference("convolution with the whole drive, last sample", lambda: _emitted_m(responses), 6.2e-6),
    )


def reversal_contrast() -> Problem:
    """Compare focus contrasts at shorter reversal times with the longest one.

    The contrast is the focus amplitude over the rms amplitude of the plate.
    """
    responses = _responses()
    return _against_time(
        "loss of focus contrast (over the rms of the plate) at a shorter T (one bit, tau = 3.5 ms)",
        partial(_contrast, responses),
        Reference("exact time steps of the modes", lambda: _contrast_of_modes(responses), 1e-9),
    )


def _against_time(title: str, after: Callable[[float], float], independent: Reference) -> Problem:
    return Problem(
        title,
        reference=Reference("twelve time constants", lambda: after(LONGEST * TAU_S), 6.2e-6),
        independent=independent,
        error=lambda found, reference: abs(1 - found / reference),
        settings=tuple(Setting(f"T = {n:g} tau", partial(after, n * TAU_S), price=n * TAU_S) for n in N_TAU),
        price="time of emission T (s)",
    )


def _responses() -> Responses:
    return impulse_responses(A4_PROTOTYPE, [FOCUS_M], rate_hz=RATE_HZ, duration_s=LONGEST * TAU_S, f_max_hz=F_MAX_HZ)


def _contrast(heard: Responses, reversal_s: float) -> float:
    signal, sides_m = (
        drive(heard, 1.0, reversal_s=reversal_s),
        (A4_PROTOTYPE.plate.length_m, A4_PROTOTYPE.plate.width_m),
    )
    x_m, y_m = (side_m * (np.arange(n) + 0.5) / n for side_m, n in zip(sides_m, N_POINTS, strict=True))
    drawn = field(A4_PROTOTYPE, signal, signal.samples.shape[1] - 1, (x_m, y_m), F_MAX_HZ)
    return contrast_whole_of(focus_amplitude(signal, heard), drawn)


def _contrast_of_modes(heard: Responses) -> float:
    """Return the contrast from exact time steps of the modes.

    The sum of the squared modal amplitudes is the mean square over the plate.
    """
    signal = drive(heard, 1.0)
    modes = modal_history(A4_PROTOTYPE, signal, [signal.samples.shape[1] - 1], F_MAX_HZ)
    return abs(_emitted_m(heard)) / float(np.linalg.norm(modes))


def _emitted_m(heard: Responses) -> float:
    signal = drive(heard, 1.0)
    return float(emitted(signal, heard)[0, signal.samples.shape[1] - 1])
