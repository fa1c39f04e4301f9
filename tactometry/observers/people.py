"""Differences between participants in traits and in each cell."""

import itertools
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import exp, hypot
from typing import Final, Protocol, Self, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from ..arguments.constraints import Finite, NotNegative, constrained
from ..arguments.require import expect, one_of
from ..config.strict import LOST_LEVEL, check_keys
from ..session.request import Facts
from ..trials.cells import cell as cell_text
from .decisions import MOST_LAPSES, Observer
from .finger import SimulatedFinger

TRAITS: Final = ("sensitivity", "criterion", "exponent", "lapse", "latency", "number", "force", "speed")
"""Traits drawn together for a participant, in the order of the random stream."""
MODALITIES: Final[Mapping[str, tuple[str, ...]]] = {"hybrid": ("electrovibration", "time_reversal")}
"""Surfaces that are felt by several modalities, whose deviations are averaged (unverified default)."""


@dataclass(frozen=True)
class Traits:
    """Traits of one participant relative to the population.

    `sensitivity` is in standard deviations, `criterion` in units of the internal noise. The other traits are
    factors.
    """

    sensitivity: float = 0.0
    criterion: float = 0.0
    exponent_factor: float = 1.0
    lapse_factor: float = 1.0
    latency_factor: float = 1.0
    number_factor: float = 1.0
    force_factor: float = 1.0
    speed_factor: float = 1.0

    def lapse_rate(self, usual: float) -> float:
        """Return this participant's rate, limited by `MOST_LAPSES`."""
        return min(usual * self.lapse_factor, max(usual, MOST_LAPSES))


@runtime_checkable
class Varied(Protocol):
    """Average of a population whose participants have traits."""

    def person(self, traits: Traits) -> Self: ...


class ObserverWithTraits(ABC):
    """Average of a population that can draw a participant itself."""

    @abstractmethod
    def person(self, traits: Traits) -> Self:
        """Return the participant with these traits."""

    def participant(self, rng: np.random.Generator) -> Self:
        """Draw a participant who differs only in sensitivity."""
        return self.person(Traits(sensitivity=float(rng.standard_normal())))

    def facts(self) -> Facts:
        return {"kind": type(self).__name__, **vars(self)}


@dataclass(frozen=True)
class Feeling:
    """Sensitivity of one participant in one cell of the design.

    With a threshold (in the unit of the level), the sensation level is `level - threshold` plus the deviation, times
    `stretch`, instead of the model's.
    """

    deviation_db: float = 0.0
    threshold: float | None = None
    stretch: float = 1.0

    def felt_db(self, level: float, sensation_db: Callable[[], float]) -> float:
        """Return the sensation level at `level`.

        >>> Feeling(2.0).felt_db(30.0, lambda: -1.0), Feeling(2.0, threshold=25.0).felt_db(30.0, lambda: -1.0)
        (1.0, 7.0)
        """
        if self.threshold is None:
            return sensation_db() + self.deviation_db
        return self.stretch * (level - self.threshold + self.deviation_db)


@runtime_checkable
class Stated(Protocol):
    """Observer with thresholds in the unit of the level."""

    def stated(self, factors: Mapping[str, float | str]) -> Feeling: ...

    def check(self, factors: Mapping[str, Sequence[float | str]], path: str) -> None: ...


@dataclass(frozen=True)
class SimulatedPerson:
    """Drawn participant: observer, and factors of force and speed."""

    observer: Observer
    force_factor: float = 1.0
    speed_factor: float = 1.0

    def finger(self, usual: SimulatedFinger) -> SimulatedFinger:
        force_factor, speed_factor = usual.force_factor * self.force_factor, usual.speed_factor * self.speed_factor
        return replace(usual, force_factor=force_factor, speed_factor=speed_factor)

    def facts(self) -> Facts:
        habits = {"force_factor": self.force_factor, "speed_factor": self.speed_factor}
        return {**self.observer.facts(), **{name: value for name, value in habits.items() if value != 1.0}}


Draws = Callable[..., np.random.Generator]
"""Returns the random stream of a participant for a use named by words."""


@dataclass(frozen=True)
@constrained
class People:
    """Differences in a population: the keys of `[observer.people]`.

    All defaults are 0. A participant's deviation in a cell is the sum of the stated effects and of independent normal
    deviations for the modality, for each factor's level and for the cell, all in dB of sensation level. Each is drawn
    from a stream named by participant and cell, so that it does not depend on the order and number of cells. The other
    traits are jointly normal. Those whose spread ends in ``_cv`` are normal on a logarithmic scale.

    Raises `InvalidParameter` if a spread is negative, a trait unknown, or the correlations are inconsistent.

    - `modality_sd_db`: Standard deviation between participants of the sensitivity to one modality (electrovibration,
      time reversal).
    - `condition_sd_db`: Standard deviation between participants of the sensitivity in one cell of the design.
    - `factor_sd_db`: Standard deviation between participants of the sensitivity at the levels of a factor, by its name.
    - `effects_db`: Effect of a level of a factor on the sensation level of all participants, by factor and level.
    - `criterion_sd`: Standard deviation between participants of the criterion, in units of the internal noise.
    - `exponent_cv`: Coefficient of variation of the transducer's exponent, which sets the width of the psychometric
      function.
    - `lapse_cv`: Coefficient of variation of the lapse rate.
    - `latency_cv`: Coefficient of variation of the median time to answer.
    - `number_cv`: Coefficient of variation of the numbers given for one magnitude.
    - `force_bias_cv`: Coefficient of variation of the pressing force relative to the target force.
    - `speed_bias_cv`: Coefficient of variation of the sliding speed relative to the target speed.
    - `correlations`: Correlations of pairs of ``sensitivity``, ``criterion``, ``exponent``, ``lapse``, ``latency``,
      ``number``, ``force`` and ``speed``.
    """

    modality_sd_db: NotNegative = 0.0
    condition_sd_db: NotNegative = 0.0
    factor_sd_db: dict[str, NotNegative] = field(default_factory=dict)
    effects_db: dict[str, dict[str, Finite]] = field(default_factory=dict)
    criterion_sd: NotNegative = 0.0
    exponent_cv: NotNegative = 0.0
    lapse_cv: NotNegative = 0.0
    latency_cv: NotNegative = 0.0
    number_cv: NotNegative = 0.0
    force_bias_cv: NotNegative = 0.0
    speed_bias_cv: NotNegative = 0.0
    correlations: dict[str, dict[str, float]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        _check_correlations(self.correlations)

    @property
    def deviation_sd_db(self) -> float:
        """Standard deviation of deviations in a cell of one modality."""
        return hypot(self.modality_sd_db, self.condition_sd_db, *self.factor_sd_db.values())

    def traits(self, rng: np.random.Generator) -> Traits:
        """Draw the traits of one participant."""
        drawn = rng.standard_normal(len(TRAITS))
        if self.correlations:
            drawn = _cholesky(correlation_matrix(self.correlations)) @ drawn
        z = dict(zip(TRAITS, drawn.tolist(), strict=True))
        return Traits(
            sensitivity=z["sensitivity"],
            criterion=self.criterion_sd * z["criterion"],
            exponent_factor=exp(self.exponent_cv * z["exponent"]),
            lapse_factor=exp(self.lapse_cv * z["lapse"]),
            latency_factor=exp(self.latency_cv * z["latency"]),
            number_factor=exp(self.number_cv * z["number"]),
            force_factor=exp(self.force_bias_cv * z["force"]),
            speed_factor=exp(self.speed_bias_cv * z["speed"]),
        )

    def check(self, factors: Mapping[str, Sequence[float | str]], path: str) -> None:
        """Refuse names that are not factors or levels of a study."""
        check_keys(self.factor_sd_db, factors, f"{path}.factor_sd_db", "factor")
        check_keys(self.effects_db, factors, f"{path}.effects_db", "factor")
        for name, of_level in self.effects_db.items():
            check_keys(of_level, list(map(cell_text, factors[name])), f"{path}.effects_db.{name}", "level", LOST_LEVEL)

    def deviation_db(self, factors: Mapping[str, float | str], modality: str, draws: Draws) -> float:
        """Return the deviation of a participant from the skin model in a cell, dB."""
        levels = {name: cell_text(level) for name, level in factors.items()}
        of_everybody = sum(self.effects_db.get(name, {}).get(text, 0.0) for name, text in levels.items())
        cell = ", ".join(f"{name}={levels[name]}" for name in sorted(levels))
        parts = MODALITIES.get(modality, (modality,))
        spreads = [
            *((self.modality_sd_db / len(parts), ("modality", part)) for part in parts),
            *((self.factor_sd_db.get(name, 0.0), ("factor", name, text)) for name, text in levels.items()),
            (self.condition_sd_db, ("cell", cell)),
        ]
        own = (sd_db * float(draws(*words).standard_normal()) for sd_db, words in spreads if sd_db)
        return of_everybody + sum(own)


def correlation_matrix(pairs: Mapping[str, Mapping[str, float]]) -> NDArray[np.float64]:
    """Return the correlations of all traits from those of pairs.

    >>> correlation_matrix({"sensitivity": {"criterion": 0.5}})[:2, :2].tolist()
    [[1.0, 0.5], [0.5, 1.0]]
    """
    matrix = np.eye(len(TRAITS))
    for one, others in pairs.items():
        for other, value in others.items():
            i, j = TRAITS.index(one), TRAITS.index(other)
            matrix[i, j] = matrix[j, i] = value
    return matrix


def _check_correlations(pairs: Mapping[str, Mapping[str, float]]) -> None:
    where, seen = "People.correlations", set[frozenset[str]]()
    for one, other in itertools.chain.from_iterable(((one, other) for other in pairs[one]) for one in pairs):
        one_of(where, one, TRAITS)
        one_of(f"{where}.{one}", other, TRAITS)
        value = pairs[one][other]
        expect(one != other, f"{where}.{one}.{other}", "a trait with itself", "two traits")
        expect(-1 <= value <= 1, f"{where}.{one}.{other}", f"{value:g}", "from -1 to 1")
        expect(frozenset((one, other)) not in seen, f"{where}.{one}.{other}", "the pair twice", "it once")
        seen.add(frozenset((one, other)))
    lowest = float(np.linalg.eigvalsh(correlation_matrix(pairs)).min())
    found = f"inconsistent correlations (an eigenvalue of {lowest:.3g})"
    expect(lowest >= -1e-9, where, found, "eigenvalues of at least 0; move the correlations closer to 0")


def _cholesky(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a Cholesky factor of a matrix that may be singular."""
    n, root = len(matrix), np.zeros_like(matrix)
    for j in range(n):
        rest = matrix[j:, j] - root[j:, :j] @ root[j, :j]
        root[j:, j] = rest / np.sqrt(rest[0]) if rest[0] > 1e-12 else 0.0
    return root
