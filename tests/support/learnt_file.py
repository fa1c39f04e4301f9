"""Files of measured responses of the default screen at its focus."""

from pathlib import Path

import numpy as np

from tactometry.stimuli.time_reversal.responses.learning import write_learnt
from tactometry.stimuli.time_reversal.responses.responses import Responses
from tactometry.stimuli.time_reversal.stimulus.setup import Setup

PROVENANCE = {"measured_on": "2026-11-20", "measured_by": "ZG"}


def true_responses():
    setup = Setup()
    return setup.responses_at(*setup.focus_m)


def write_responses(path, *, noise_db=np.inf, factor=1.0, n_samples=None, n_points=1):
    """Write them with noise so many dB below, and changed as asked: what was written."""
    true = true_responses()
    rms = np.sqrt(np.mean(true.samples**2))
    noise = rms * 10 ** (-noise_db / 20) * np.random.default_rng(5).standard_normal(true.samples.shape)
    samples = np.tile(factor * (true.samples + noise)[..., :n_samples], (n_points, 1, 1))
    write_learnt(Responses(samples, true.rate_hz), Path(path), PROVENANCE)
    return samples
