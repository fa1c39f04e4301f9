"""Accuracy problems of perceived amplitude of sampled taps and tones."""

from collections.abc import Iterable
from functools import partial
from typing import Any

import numpy as np

from tactometry.stimuli.perception import sensation_level_db
from tactometry.stimuli.perception.channels import channel_levels_db
from tactometry.stimuli.perception.detection import Components, components

from ..measure import Problem, Real, Reference, Setting, largest_relative

TAPS_HZ, N_TAPS, HIGHEST_HZ = 2.5, 16, 800.0
FALL_S, RISE_S = 4e-3, 5e-4
RATES_HZ = (1_000, 4_000, 16_000, 64_000)
FREQUENCIES_HZ = np.array([41.3, 87.7, 173.1, 311.9])
RATE_HZ, OFFSET = 4e3, 3.0
DURATION_S, PADDINGS = 1.6, (1, 2, 4, 8, 16)


def filter_bank() -> Problem:
    """Sample taps ``exp(-t/FALL_S) - exp(-t/RISE_S)``, which alias."""
    return Problem(
        "largest error of the sensed amplitude of taps at 2.5 Hz (channels NP III, NP I, P), by sampling rate",
        reference=Reference("Fourier series of the taps, explicit thresholds", _transformed, 1e-8),
        error=largest_relative,
        settings=tuple(Setting(f"{rate_hz / 1e3:g} kHz", partial(_sampled_taps, rate_hz)) for rate_hz in RATES_HZ),
    )


def _tap(time_s: Any) -> Any:
    return np.exp(-time_s / FALL_S) - np.exp(-time_s / RISE_S)


def _sampled_taps(rate_hz: int) -> Real:
    tap: Real = _tap(np.arange(round(rate_hz / TAPS_HZ)) / rate_hz)
    return _channel_amplitudes(components(np.tile(tap, N_TAPS), rate_hz))


def _channel_amplitudes(parts: Components) -> Real:
    return np.asarray(10 ** (channel_levels_db(parts, 1.0) / 20), dtype=np.float64)


def _transformed() -> Real:
    """Return the sensed amplitudes from the Fourier transform of a tap."""
    f = np.linspace(TAPS_HZ, HIGHEST_HZ, round(HIGHEST_HZ / TAPS_HZ))
    fall, rise = (-np.expm1(-1 / TAPS_HZ / tau_s) / (1 / tau_s + 2j * np.pi * f) for tau_s in (FALL_S, RISE_S))
    amplitudes = 2 * TAPS_HZ * np.abs(fall - rise)
    bowls_db = np.full(len(f), 48.0), 48 - 5 * np.log2(f / 3), 12 * np.abs(np.log2(250 / f))
    in_range = (f >= 0.4) & (f <= 3), (f >= 3) & (f <= 100), (f >= 35) & (f <= 800)
    pairs = zip(bowls_db, in_range, strict=True)
    return np.array([np.max(amplitudes[is_heard] * 10 ** (-db[is_heard] / 20)) for db, is_heard in pairs])


def sensitivity() -> Problem:
    """Compute sensed amplitudes of four tones from windowed spectra."""
    return Problem(
        "largest error of the sensed amplitude of tones between 40 and 320 Hz, from windowed spectra",
        reference=Reference("explicit formula of the sensitivity curve", _written_out, 1e-12),
        error=largest_relative,
        settings=tuple(
            Setting(f"padded to {p * DURATION_S:g} s", partial(_from_record, p), p * DURATION_S) for p in PADDINGS
        ),
        price="length of the padded record (s)",
    )


def _sensed_amplitudes(records: Iterable[Components]) -> Real:
    return np.array([10 ** (sensation_level_db(parts, 1.0) / 20) for parts in records])


def _from_record(padding: int) -> Real:
    time_s = np.arange(round(DURATION_S * RATE_HZ)) / RATE_HZ
    tones = [OFFSET + np.sin(2 * np.pi * f * time_s) for f in FREQUENCIES_HZ]
    return _sensed_amplitudes(components(tone, RATE_HZ, padding) for tone in tones)


def _written_out() -> Real:
    """Return the sensitivity of the Meissner and Pacini channels."""
    bowls_db = np.minimum(48 - 5 * np.log2(FREQUENCIES_HZ / 3), 12 * np.abs(np.log2(250 / FREQUENCIES_HZ)))
    return np.asarray(10 ** (-bowls_db / 20))
