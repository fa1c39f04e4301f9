"""Defaults that several packages share, each stated once.

The module computes nothing, so that an inactive effect imports no physics with its defaults.

Facts (thesis): 2 N elsewhere than the focus cost 6 % of amplitude, 2 N at the focus up to 30 %. The finger, a damper of
10 N s/m at 2 N that goes with losses of tau = 3.5 ms, is set to meet both in simulation: it is neither measured nor a
prediction.
"""

from typing import Final

VACUUM_PERMITTIVITY_F_PER_M: Final = 8.8541878128e-12
"""CODATA 2018."""

ACCURACY: Final = 0.01
"""Relative error that a scene tolerates."""

REFERENCE_FORCE_N: Final = 2.0
RESISTANCE_N_S_PER_M: Final = 10.0
FORCE_EXPONENT: Final = 0.5
"""By which a finger's resistance grows with its force; source: `fingertip` in `stimuli/sources.toml`."""

LUMPED: Final = "lumped"
"""Impedance of a finger on a plate: damper, mass and spring."""

AREA_AT_1N_M2: Final = 1e-4
AREA_EXPONENT: Final = 1 / 3
"""Contact area of a finger at 1 N, and its growth with force; unverified defaults."""

SHEAR_VISCOSITY_PA_S: Final = 2.0
"""Of the soft tissue of a finger, within 0.3 to 15; unverified default."""

FOCUS_AT_THRESHOLD_M: Final = 10e-6
"""Amplitude of a single focus that is just felt (the thesis: about 10 um)."""

BEST_DB: Final = -20.0
"""Threshold of Pacini at its best: dB re 1 um, of a peak displacement of the skin."""

THRESHOLD_M: Final = 1e-6 * 10 ** (BEST_DB / 20)
"""0.1 um, of Pacini at 250 Hz; source: `sensitivity` in `stimuli/sources.toml`."""

STEEPEST_DB_PER_HZ: Final = 2.5
"""Upper bound of the slope of the thresholds of `tactometry.stimuli.perception.channels`, reached at 3 Hz."""

MASKING_SLOPE: Final = 0.52
"""Decibels of threshold per decibel of a masker of the same frequency above its own, from 13 dB at 25 dB (Sci. Rep.
2018, doi 10.1038/s41598-018-22865-x); unverified default."""

AUDIBLE_MAX_HZ: Final = 20e3
"""Where hearing ends, and the audible-band filter begins to pass; unverified default."""

DISTANCE_M: Final = 0.3
"""From a screen to the ear; unverified default."""

F_MAX_HZ: Final = 60e3
"""Upper end of the band in which a screen emits; source: `focus` in `stimuli/sources.toml`."""

REPETITION_HZ: Final = 200.0
TRAIN_S: Final = 50e-3
"""Of a train of foci: how often they come, and how long; source: `pattern` in `stimuli/sources.toml`."""
