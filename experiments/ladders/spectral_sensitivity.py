"""How strong a tone is felt, read off the spectrum of a record, against the tone itself."""

import math
from functools import partial

import numpy as np

from tactometry.stimuli.perception import Components, components, sensation_level_db

from ..cost.problem import Problem, Real, Rung, largest_relative

FREQUENCIES_HZ = np.array([41.3, 87.7, 173.1, 311.9])
RATE_HZ, OFFSET = 4e3, 3.0
DURATIONS_S = (0.1, 0.4, 1.6, 6.4, 25.6)


def problem() -> Problem:
    """Four tones one after another, each with a constant beside it, as amplitudes over their thresholds."""
    return Problem(
        "largest error of the sensed amplitude of tones between 40 and 320 Hz, flat-top spectrum of a record",
        "the curve of sensitivity at the tone",
        "the formula of the curve, written out",
        reference=lambda: (np.array([_sensed(Components(np.array([f]), np.ones(1))) for f in FREQUENCIES_HZ]), 1e-12),
        independent=lambda: (np.array([_written_out(f) for f in FREQUENCIES_HZ]), 1e-12),
        error=largest_relative,
        rungs=tuple(
            Rung(f"{duration_s:g} s", partial(_from_record, duration_s), duration_s) for duration_s in DURATIONS_S
        ),
        price="length of the record (s)",
    )


def _sensed(parts: Components) -> float:
    return float(10 ** (sensation_level_db(parts, 1.0) / 20))


def _from_record(duration_s: float) -> Real:
    time_s = np.arange(round(duration_s * RATE_HZ)) / RATE_HZ
    tones = [OFFSET + np.sin(2 * np.pi * f * time_s) for f in FREQUENCIES_HZ]
    return np.array([_sensed(components(tone, RATE_HZ)) for tone in tones])


def _written_out(frequency_hz: float) -> float:
    bowl_db = 62 * (math.log10(frequency_hz / 550 + 6 / 11) / math.log10(6 / 11)) ** 2
    return float(10 ** (-min(bowl_db, 77.0) / 20))
