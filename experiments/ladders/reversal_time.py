"""What emitting longer buys: the amplitude of the focus against the reversal time T."""

from functools import partial

from tactometry.experiments.ladders.problem import Problem, Rung
from tactometry.stimuli.time_reversal import Responses, drive, emitted, focus_amplitude
from tactometry.stimuli.time_reversal.responses import impulse_responses
from tactometry.stimuli.time_reversal.screen import A4_PROTOTYPE, TAU_S

RATE_HZ, F_MAX_HZ, FOCUS_M = 60e3, 20e3, (0.121, 0.093)
N_TAU = (0.5, 1.0, 2.0, 4.0, 6.0, 8.0)
LONGEST = 12.0


def problem() -> Problem:
    """One bit on the A4 prototype, relative to twelve time constants."""
    heard = impulse_responses(A4_PROTOTYPE, [FOCUS_M], rate_hz=RATE_HZ, duration_s=LONGEST * TAU_S, f_max_hz=F_MAX_HZ)
    return Problem(
        "reversal-time",
        "amplitude of the focus that a shorter reversal time T loses (one bit, tau = 3.5 ms)",
        reference=lambda: (_amplitude_m(heard, LONGEST * TAU_S), 6.2e-6),
        independent=lambda: (_emitted_m(heard), 6.2e-6),
        error=lambda found, reference: abs(1 - found / reference),
        rungs=tuple(Rung(f"T = {n:g} tau", partial(_amplitude_m, heard, n * TAU_S), price=n * TAU_S) for n in N_TAU),
        price="time of emission T (s)",
    )


def _amplitude_m(heard: Responses, reversal_s: float) -> float:
    return focus_amplitude(drive(heard, 1.0, reversal_s=reversal_s), heard)


def _emitted_m(heard: Responses) -> float:
    """By convolution of the whole drive, at its last sample."""
    signal = drive(heard, 1.0)
    return float(emitted(signal, heard)[0, signal.samples.shape[1] - 1])
