"""Thresholds of the skin, and how a masker raises one: numbers alone, for effects that may be off."""

from typing import Final

BEST_DB: Final = -20.0
"""Of Pacini: dB re 1 um, of a peak displacement of the skin."""

THRESHOLD_M: Final = 1e-6 * 10 ** (BEST_DB / 20)
"""0.1 um, of Pacini at 250 Hz; from memory of the published curve, as all of it is: unverified default."""

MASKING_SLOPE: Final = 0.52
"""Decibels of threshold per decibel of a masker of the same frequency above its own, from 13 dB at 25 dB (Sci. Rep.
2018, doi 10.1038/s41598-018-22865-x); unverified default."""
