"""An ideal participant: no noise, no lapse, no bias."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Self

import numpy as np

from ..arguments.require import finite, not_negative, positive
from ..session.request import Facts
from .people import Traits
from .signal_detection import COMFORT_DB, COMFORT_RANGE_DB

HIGHEST_DB = 300.0


@dataclass(frozen=True)
class IdealObserver:
    """Feels whatever is above its threshold, and tells apart whatever differs; guesses only between what is felt alike.

    Parameters
    ----------
    sensitivity_db : float
        How much more sensitive than the reference, in dB of sensation level.
    between_sd_db : float
        Standard deviation of it between people.
    latency_s : float
        Time to answer.

    Raises
    ------
    InvalidParameter
        If a value is outside of its range.
    """

    sensitivity_db: float = 0.0
    between_sd_db: float = 0.0
    latency_s: float = 0.8

    def __post_init__(self) -> None:
        finite("IdealObserver", sensitivity_db=self.sensitivity_db)
        not_negative("IdealObserver", between_sd_db=self.between_sd_db)
        positive("IdealObserver", latency_s=self.latency_s)

    def participant(self, rng: np.random.Generator) -> Self:
        """One participant of the population that this observer is the mean of."""
        return self.person(Traits(sensitivity=float(rng.standard_normal())))

    def person(self, traits: Traits) -> Self:
        """The participant with these traits; an ideal one has no other than its sensitivity and its time."""
        felt_db = self.sensitivity_db + self.between_sd_db * traits.sensitivity
        return type(self)(felt_db, self.between_sd_db, self.latency_s * traits.latency_factor)

    def detect(self, sensation_db: float, rng: np.random.Generator) -> bool:
        """Whether it is above the threshold."""
        del rng
        return sensation_db + self.sensitivity_db > 0

    def compare(self, sensations_db: Sequence[float], rng: np.random.Generator) -> int:
        """The index of the strongest."""
        best = np.flatnonzero(np.asarray(sensations_db) == max(sensations_db))
        return int(rng.choice(best))

    def identify(self, alternatives_db: Sequence[Sequence[float]], n_felt: int, rng: np.random.Generator) -> int:
        """The index of what is felt, or of another that is felt alike."""
        felt = tuple(alternatives_db[n_felt])
        alike = [n for n, levels in enumerate(alternatives_db) if tuple(levels) == felt]
        return int(rng.choice(alike))

    def differ(self, sensations_db: Sequence[float], rng: np.random.Generator) -> bool:
        """Whether two levels differ."""
        del rng
        first, second = sensations_db
        return first != second

    def magnitude(self, sensation_db: float, rng: np.random.Generator) -> float:
        """The amplitude in units of the threshold."""
        del rng
        return float(f"{10 ** (min(sensation_db + self.sensitivity_db, HIGHEST_DB) / 20):.3g}")

    def liking(self, sensation_db: float, rng: np.random.Generator) -> float:
        """That of signal detection, without its noise."""
        del rng
        return 1 - 2 * min(abs(sensation_db + self.sensitivity_db - COMFORT_DB) / COMFORT_RANGE_DB, 1.0)

    def answer_time_s(self, rng: np.random.Generator) -> float:
        del rng
        return self.latency_s

    def facts(self) -> Facts:
        return {"kind": type(self).__name__, **asdict(self)}
