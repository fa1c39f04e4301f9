"""What emitting longer buys: amplitude and contrast of the focus against the reversal time T."""

from collections.abc import Callable
from functools import partial

import numpy as np

from tactometry.stimuli.time_reversal import Responses, drive, emitted, focus_amplitude, impulse_responses
from tactometry.stimuli.time_reversal.focusing.merit import contrast_whole_of, field, modal_history
from tactometry.stimuli.time_reversal.screen.attenuation import TAU_S
from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE

from ..cost.problem import Problem, Reference, Rung

RATE_HZ, F_MAX_HZ, FOCUS_M = 60e3, 20e3, (0.121, 0.093)
N_TAU = (0.5, 1.0, 2.0, 4.0, 6.0, 8.0)
LONGEST = 12.0
SIDES_M, N_POINTS = (A4_PROTOTYPE.plate.length_m, A4_PROTOTYPE.plate.width_m), (120, 85)


def amplitude() -> Problem:
    """One bit on the A4 prototype, relative to twelve time constants."""
    heard = _responses()
    return _against_time(
        "amplitude of the focus that a shorter reversal time T loses (one bit, tau = 3.5 ms)",
        partial(_amplitude_m, heard),
        Reference("convolution of the whole drive, last sample", lambda: _emitted_m(heard), 6.2e-6),
    )


def contrast() -> Problem:
    """The focus over the rms of the plate."""
    heard = _responses()
    return _against_time(
        "contrast of the focus (over the rms of the plate) that a shorter T loses (one bit, tau = 3.5 ms)",
        partial(_contrast, heard),
        Reference("exact steps of the modes", lambda: _contrast_of_modes(heard), 1e-9),
    )


def _against_time(what: str, after: Callable[[float], float], independent: Reference) -> Problem:
    """The loss of what a reversal time gives, against that time."""
    return Problem(
        what,
        reference=Reference("twelve time constants", lambda: after(LONGEST * TAU_S), 6.2e-6),
        independent=independent,
        error=lambda found, reference: abs(1 - found / reference),
        rungs=tuple(Rung(f"T = {n:g} tau", partial(after, n * TAU_S), price=n * TAU_S) for n in N_TAU),
        price="time of emission T (s)",
    )


def _responses() -> Responses:
    return impulse_responses(A4_PROTOTYPE, [FOCUS_M], rate_hz=RATE_HZ, duration_s=LONGEST * TAU_S, f_max_hz=F_MAX_HZ)


def _contrast(heard: Responses, reversal_s: float) -> float:
    signal = drive(heard, 1.0, reversal_s=reversal_s)
    x_m, y_m = (side_m * (np.arange(n) + 0.5) / n for side_m, n in zip(SIDES_M, N_POINTS, strict=True))
    drawn = field(A4_PROTOTYPE, signal, signal.samples.shape[1] - 1, (x_m, y_m), F_MAX_HZ)
    return contrast_whole_of(focus_amplitude(signal, heard), drawn)


def _contrast_of_modes(heard: Responses) -> float:
    """By exact steps of the modes, whose squares add up to that of the plate."""
    signal = drive(heard, 1.0)
    modes = modal_history(A4_PROTOTYPE, signal, [signal.samples.shape[1] - 1], F_MAX_HZ)
    return abs(_emitted_m(heard)) / float(np.linalg.norm(modes))


def _amplitude_m(heard: Responses, reversal_s: float) -> float:
    return focus_amplitude(drive(heard, 1.0, reversal_s=reversal_s), heard)


def _emitted_m(heard: Responses) -> float:
    """By convolution of the whole drive, at its last sample."""
    signal = drive(heard, 1.0)
    return float(emitted(signal, heard)[0, signal.samples.shape[1] - 1])
