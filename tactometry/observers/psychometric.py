"""Participant with a stated psychometric function, without physics."""

import functools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from ..arguments.constraints import Finite, NotNegative, Positive, constrained
from ..arguments.require import below, finite, one_of, positive, within
from ..config.strict import check_keys, convert
from ..psychometric import SHAPES, PsychometricFunction
from ..session.request import Facts
from ..trials.cells import cell as cell_text
from . import decisions
from .changes import Shift
from .decisions import ALMOST_ALL, HIGHEST_DB, MOST_LAPSES
from .people import Feeling, ObserverWithTraits, Traits

OF_WIDTH = 2 * 1.6448536269514722
"""Width of a cumulative normal distribution from 0.05 to 0.95, in standard deviations."""


@dataclass(frozen=True)
@constrained
class PsychometricObserver(ObserverWithTraits):
    """Observer with a stated psychometric function ``psi(level)``.

    Threshold and width are in the unit of the level. In a forced choice of m with one stimulus, the stimulus is chosen
    with probability ``1 / m + (1 - 1 / m - lapse_rate) F(level)``. Among several stimuli, the highest is chosen after
    adding normal noise that corresponds to the width. Schuett, Harmeling, Macke and Wichmann, Vision Research 122
    (2016), 105-123.

    - `threshold`: Level at which the unscaled function is 0.5, unless `conditions` states another.
    - `width`: Distance of levels between 0.05 and 0.95 of the unscaled function, unless `conditions` states another.
    - `conditions`: Levels of factors, each with the ``threshold`` and ``width`` that apply there. The last matching
      condition applies.
    - `shape`: One of the shapes of `tactometry.psychometric` on linear levels.
    - `false_alarm_rate`: Rate of the answer yes without a stimulus: the lower asymptote of yes/no.
    - `lapse_rate`: Distance of the upper asymptote from 1.
    - `sensitivity_db`: Decrease of the thresholds of this participant.
    - `between_sd_db`: Standard deviation of the sensitivity between participants.
    - `latency_s`: Median time to answer.
    """

    threshold: Finite
    width: Positive = 6.0
    conditions: tuple[dict[str, Any], ...] = ()
    shape: str = "normal"
    false_alarm_rate: float = 0.05
    lapse_rate: float = 0.02
    sensitivity_db: Finite = 0.0
    between_sd_db: NotNegative = 2.5
    latency_s: Positive = 0.8

    def __post_init__(self) -> None:
        owner = "PsychometricObserver"
        one_of(f"{owner}.shape", self.shape, [name for name, shape in SHAPES.items() if not shape.on_log_levels])
        within(owner, 0, MOST_LAPSES, false_alarm_rate=self.false_alarm_rate)
        within(owner, 0, ALMOST_ALL, lapse_rate=self.lapse_rate)
        below(owner, false_alarm_rate=self.false_alarm_rate, one_less_lapses=1 - self.lapse_rate)
        for n, of in enumerate(self.conditions):
            where = f"{owner}.conditions[{n}]"
            finite(where, threshold=convert(float, of.get("threshold", self.threshold), f"{where}.threshold"))
            positive(where, width=convert(float, of.get("width", self.width), f"{where}.width"))

    def check(self, factors: Mapping[str, Sequence[float | str]], path: str) -> None:
        """Refuse a condition with names that are not factors or levels of a study."""
        for n, of in enumerate(self.conditions):
            where = f"{path}.conditions[{n}]"
            check_keys(of, (*factors, "threshold", "width"), where)
            for name in factors.keys() & of.keys():
                one_of(f"{where}.{name}", cell_text(of[name]), list(map(cell_text, factors[name])))

    def stated(self, factors: Mapping[str, float | str]) -> Feeling:
        """Return this participant's sensitivity in a cell, in usual widths."""
        there = {"threshold": self.threshold, "width": self.width}
        levels = {name: cell_text(level) for name, level in factors.items()}
        for of in self.conditions:
            if all(cell_text(of[name]) == text for name, text in levels.items() if name in of):
                there |= {name: float(of[name]) for name in there if name in of}
        return Feeling(threshold=there["threshold"] - self.sensitivity_db, stretch=self.width / there["width"])

    def person(self, traits: Traits) -> Self:
        """Return the participant with these traits."""
        return replace(
            self,
            sensitivity_db=self.sensitivity_db + self.between_sd_db * traits.sensitivity,
            width=self.width / traits.exponent_factor,
            conditions=tuple(
                {**of, "width": of["width"] / traits.exponent_factor} if "width" in of else of for of in self.conditions
            ),
            lapse_rate=traits.lapse_rate(self.lapse_rate),
            latency_s=self.latency_s * traits.latency_factor,
        )

    def shifted(self, shift: Shift) -> Self:
        """Return this participant in one trial. The criterion does not change."""
        highest = ALMOST_ALL - self.false_alarm_rate
        return replace(self, lapse_rate=min(decisions.either(self.lapse_rate, min(shift.lapse_rate, highest)), highest))

    def chance(self, sensation_db: float, guess_rate: float) -> float:
        """Return the probability of a yes, or of the correct interval."""
        lapse_rate = min(self.lapse_rate, ALMOST_ALL - guess_rate)
        return _rate(self.shape, self.width, guess_rate, lapse_rate, sensation_db)

    def detect(self, sensation_db: float, rng: np.random.Generator) -> bool:
        return bool(rng.random() < self.chance(sensation_db, self.false_alarm_rate))

    def compare(self, sensations_db: Sequence[float], rng: np.random.Generator) -> int:
        chance, other = rng.random(), int(rng.integers(len(sensations_db) - 1)) if len(sensations_db) > 1 else 0
        noise = rng.standard_normal(len(sensations_db))
        there = np.flatnonzero(np.isfinite(sensations_db))
        if len(there) == 1:
            (right,) = there.tolist()
            is_right = chance < self.chance(sensations_db[right], 1 / len(sensations_db))
            return int(right) if is_right else other + (other >= right)
        if chance < self.lapse_rate or not len(there):
            return int(np.argmax(noise))
        return int(np.argmax(np.asarray(sensations_db) + self._sd * noise / math.sqrt(2)))

    def identify(self, alternatives_db: Sequence[Sequence[float]], n_felt: int, rng: np.random.Generator) -> int:
        """Return `n_felt` with the probability of a forced choice."""
        highest_db, m = max(alternatives_db[n_felt]), len(alternatives_db)
        chance, other = rng.random(), int(rng.integers(m - 1)) if m > 1 else 0
        return n_felt if chance < self.chance(highest_db, 1 / m) else other + (other >= n_felt)

    def differ(self, sensations_db: Sequence[float], rng: np.random.Generator) -> bool:
        """Compare noisy levels, which differ beyond a width (unverified default)."""
        first, second = (max(level, -HIGHEST_DB) for level in sensations_db)
        noise, lapses, guess = rng.standard_normal(2), rng.random() < self.lapse_rate, rng.random() < 0.5
        apart = abs(first - second + self._sd / math.sqrt(2) * float(noise[0] - noise[1]))
        return bool(guess) if lapses else apart > self.width

    @property
    def _sd(self) -> float:
        return self.width / OF_WIDTH

    def magnitude(self, sensation_db: float, rng: np.random.Generator) -> float:
        felt_db = sensation_db + self._sd * float(rng.standard_normal())
        return decisions.magnitude(felt_db)

    def liking(self, sensation_db: float, rng: np.random.Generator) -> float:
        del rng
        return decisions.liking(sensation_db)

    def answer_time_s(self, rng: np.random.Generator) -> float:
        return decisions.answer_time_s(self.latency_s, rng)

    def facts(self) -> Facts:
        names = ("threshold", "width", "shape", "false_alarm_rate", "lapse_rate", "sensitivity_db", "latency_s")
        return {"kind": type(self).__name__, **{name: getattr(self, name) for name in names}}


@functools.lru_cache(maxsize=4096)  # levels repeat
def _rate(shape: str, width: float, guess_rate: float, lapse_rate: float, level: float) -> float:
    if level == -math.inf:
        return guess_rate
    return float(PsychometricFunction(shape, 0.0, width, guess_rate, lapse_rate).probability(level))
