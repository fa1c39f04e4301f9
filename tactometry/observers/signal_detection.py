"""Observer that decides by signal detection."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from ..arguments.constraints import Finite, NotNegative, Positive, Rate, constrained
from . import decisions
from .changes import Shift
from .people import ObserverWithTraits, Traits

LIKING_NOISE = 0.3
"""Range: `liking` in `stimuli/sources.toml`."""


@dataclass(frozen=True)
@constrained
class SignalDetectionObserver(ObserverWithTraits):
    """Equal-variance signal detection on a sensation level in decibels.

    d'(L) = criterion * 10^(exponent (L + sensitivity_db) / 20): at L = -sensitivity_db a stimulus is felt in half of
    the trials of a yes/no task; Green and Swets, Signal Detection Theory and Psychophysics (1966), with a power
    transducer. Sources of the defaults: `signal_detection` in `stimuli/sources.toml`. The criterion
    gives 5 % false alarms.

    - `criterion`: Decision criterion in units of the internal noise, above 0.
    - `exponent`: Exponent of the transducer, above 0.
    - `lapse_rate`: Fraction of trials that are answered at random, in [0, 1).
    - `sensitivity_db`: Sensitivity of this participant relative to the reference, in dB of sensation level.
    - `between_sd_db`: Standard deviation of `sensitivity_db` between participants (see `participant`).
    - `bias`: Addition to the criterion in yes/no tasks, in units of the internal noise. Above 0, there are fewer false
      alarms and hits.
    - `number_factor`: Ratio of a number stated for a magnitude to d'.
    - `latency_s`: Median time to answer. Answer times are log-normal with a coefficient of variation near 0.3.
    """

    criterion: Positive = 1.645
    exponent: Positive = 1.0
    lapse_rate: Rate = 0.02
    sensitivity_db: Finite = 0.0
    between_sd_db: NotNegative = 5.0
    latency_s: Positive = 0.8
    bias: Finite = 0.0
    number_factor: Positive = 1.0

    def person(self, traits: Traits) -> Self:
        """Return the participant with these traits."""
        return replace(
            self,
            sensitivity_db=self.sensitivity_db + self.between_sd_db * traits.sensitivity,
            bias=self.bias + traits.criterion,
            exponent=self.exponent * traits.exponent_factor,
            lapse_rate=traits.lapse_rate(self.lapse_rate),
            latency_s=self.latency_s * traits.latency_factor,
            number_factor=self.number_factor * traits.number_factor,
        )

    def shifted(self, shift: Shift) -> Self:
        """Return this participant in one trial."""
        return replace(
            self,
            sensitivity_db=self.sensitivity_db + shift.sensitivity_db,
            bias=self.bias + shift.criterion,
            lapse_rate=decisions.either(self.lapse_rate, min(shift.lapse_rate, decisions.ALMOST_ALL)),
        )

    def d_prime(self, sensation_db: float) -> float:
        """Return d' at a level, from 0 to 1e6."""
        exponent = self.exponent * (sensation_db + self.sensitivity_db) / 20
        return float(min(self.criterion * 10.0 ** min(exponent, 300.0), 1e6))

    def detect(self, sensation_db: float, rng: np.random.Generator) -> bool:
        # draw all numbers, used or not, so that the generator's state does not depend on the answer
        noise, lapses, guess = rng.standard_normal(), rng.random() < self.lapse_rate, rng.random() < 0.5
        return bool(guess) if lapses else bool(self.d_prime(sensation_db) + noise > self.criterion + self.bias)

    def compare(self, sensations_db: Sequence[float], rng: np.random.Generator) -> int:
        signals = np.array([self.d_prime(level) for level in sensations_db])
        felt = signals + rng.standard_normal(len(sensations_db))
        lapses, guess = rng.random() < self.lapse_rate, int(rng.integers(len(sensations_db)))
        return guess if lapses else int(np.argmax(felt))

    def identify(self, alternatives_db: Sequence[Sequence[float]], n_felt: int, rng: np.random.Generator) -> int:
        """Return the most likely alternative, in equal independent noise.

        The observer knows the d' of each alternative at each place of the skin, and reports the alternative whose d'
        are nearest to the sensation. With two alternatives, ``Phi(D / 2)`` of the answers are right, where D is the
        distance of their d' (Green and Swets, 1966, chapter 9).
        """
        expected = np.array([[self.d_prime(level) for level in levels] for levels in alternatives_db])
        felt = expected[n_felt] + rng.standard_normal(expected.shape[1])
        lapses, guess = rng.random() < self.lapse_rate, int(rng.integers(len(expected)))
        likelihood = expected @ felt - (expected**2).sum(axis=1) / 2
        best = np.flatnonzero(likelihood == likelihood.max())  # guess between equal sensations
        return guess if lapses else int(best[guess % len(best)])

    def differ(self, sensations_db: Sequence[float], rng: np.random.Generator) -> bool:
        """Decide by the differencing rule.

        Macmillan and Creelman, Detection Theory, 2nd ed. (2005), chapter 9. The criterion on the difference is sqrt(2)
        times that of a single stimulus (a choice).
        """
        first, second = (self.d_prime(level) for level in sensations_db)
        noise, lapses, guess = rng.standard_normal(2), rng.random() < self.lapse_rate, rng.random() < 0.5
        difference = abs(first - second + float(noise[0] - noise[1]))
        return bool(guess) if lapses else difference > math.sqrt(2) * self.criterion + self.bias

    def magnitude(self, sensation_db: float, rng: np.random.Generator) -> float:
        """Return noisy d' times the number factor, to three digits."""
        felt = max(self.d_prime(sensation_db) + float(rng.standard_normal()), 0.0)
        return decisions.in_words(self.number_factor * felt)

    def liking(self, sensation_db: float, rng: np.random.Generator) -> float:
        """Return `decisions.liking` with noise."""
        felt = decisions.liking(sensation_db + self.sensitivity_db)
        return float(np.clip(felt + LIKING_NOISE * rng.standard_normal(), -1.0, 1.0))

    def answer_time_s(self, rng: np.random.Generator) -> float:
        return decisions.answer_time_s(self.latency_s, rng)
