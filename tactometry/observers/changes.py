"""Changes of a simulated participant during a session."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import exp, sqrt
from typing import Final, Protocol, Self, runtime_checkable

import numpy as np

from ..arguments.constraints import Finite, NotNegative, Positive, Share, constrained
from .decisions import either

Answer = float | str | None
"""Response in a row of the trials table."""


@dataclass(frozen=True)
class Shift:
    """Deviation of a participant in one trial.

    It changes sensitivity, criterion (in units of the internal noise) and additional lapses.
    """

    sensitivity_db: float = 0.0
    criterion: float = 0.0
    lapse_rate: float = 0.0

    def __add__(self, other: "Shift") -> "Shift":
        """Add two shifts. Lapses combine as independent events.

        >>> Shift(1.0, lapse_rate=0.5) + Shift(2.0, lapse_rate=0.5)
        Shift(sensitivity_db=3.0, criterion=0.0, lapse_rate=0.75)
        """
        return Shift(
            self.sensitivity_db + other.sensitivity_db,
            self.criterion + other.criterion,
            either(self.lapse_rate, other.lapse_rate),
        )


class Change(Protocol):
    """Change of a participant during a session.

    It is a pure function of the number of earlier trials, their answers, and a random stream that restarts in every
    trial.
    """

    def shift(self, n_trials: int, answers: Sequence[Answer], rng: np.random.Generator) -> Shift: ...


@runtime_checkable
class Shifted(Protocol):
    """Observer that a `Shift` can change."""

    def shifted(self, shift: Shift) -> Self: ...


@dataclass(frozen=True)
@constrained
class CriterionDrift:
    """Criterion that drifts as a stationary first-order process.

    Its autocorrelation falls to 1/e over `n_trials` trials (unverified defaults).

    - `sd`: Standard deviation of the criterion, in units of the internal noise.
    - `n_trials`: Number of trials after which the autocorrelation has fallen to 1/e.
    """

    sd: NotNegative = 0.3
    n_trials: Positive = 50.0

    def shift(self, n_trials: int, answers: Sequence[Answer], rng: np.random.Generator) -> Shift:
        del answers
        keep = exp(-1 / self.n_trials)
        steps = rng.standard_normal(n_trials + 1)
        weights = keep ** np.arange(n_trials, -1, -1.0)
        weights[1:] *= sqrt(1 - keep**2)  # the first value has the variance of the process
        return Shift(criterion=self.sd * float(weights @ steps))


@dataclass(frozen=True)
@constrained
class Fatigue:
    """Sensitivity that decreases linearly with trials (unverified defaults).

    - `loss_db`: Loss of sensitivity after `n_trials`.
    - `n_trials`: Number of trials after which the loss is reached.
    """

    loss_db: Finite = 2.0
    n_trials: Positive = 500.0

    def shift(self, n_trials: int, answers: Sequence[Answer], rng: np.random.Generator) -> Shift:
        del answers, rng
        return Shift(sensitivity_db=-self.loss_db * n_trials / self.n_trials)


@dataclass(frozen=True)
@constrained
class LapsesInRuns:
    """Lapses in runs, as a Markov chain of two states.

    In each trial attention is lost with probability `loss_rate` or returns with `return_rate`. While it is lost,
    `lapse_rate` of the answers are random (unverified defaults). In the long run attention is lost in ``loss_rate /
    (loss_rate + return_rate)`` of the trials, for ``1 / return_rate`` trials on average.

    - `loss_rate`: Probability per trial that attention is lost.
    - `return_rate`: Probability per trial that attention returns.
    - `lapse_rate`: Fraction of random answers while attention is lost.
    """

    loss_rate: Share = 0.01
    return_rate: Share = 0.2
    lapse_rate: Share = 0.9

    def shift(self, n_trials: int, answers: Sequence[Answer], rng: np.random.Generator) -> Shift:
        del answers
        is_lost = False
        for chance in rng.random(n_trials + 1).tolist():
            is_lost = chance >= self.return_rate if is_lost else chance < self.loss_rate
        return Shift(lapse_rate=self.lapse_rate if is_lost else 0.0)


@dataclass(frozen=True)
@constrained
class SlowLearning:
    """Sensitivity that rises by `gain_db` in total (unverified defaults).

    - `gain_db`: Deficit of sensitivity at the first trial.
    - `n_trials`: Number of trials after which 1/e of the deficit is left.
    """

    gain_db: Finite = 3.0
    n_trials: Positive = 100.0

    def shift(self, n_trials: int, answers: Sequence[Answer], rng: np.random.Generator) -> Shift:
        del answers, rng
        return Shift(sensitivity_db=-self.gain_db * exp(-n_trials / self.n_trials))


@dataclass(frozen=True)
@constrained
class SerialDependence:
    """Criterion that depends on the previous answer (unverified default).

    After a yes the criterion is lower by `pull`, after a no it is higher by `pull`. If `pull` is below 0, answers tend
    to alternate. This affects questions with a criterion: yes/no, and same or different.

    - `pull`: Decrease of the criterion after a yes, in units of the internal noise. Below 0, answers tend to alternate.
    """

    pull: Finite = 0.2

    def shift(self, n_trials: int, answers: Sequence[Answer], rng: np.random.Generator) -> Shift:
        del n_trials, rng
        last = answers[-1] if answers else None
        return Shift(criterion=-self.pull if last else self.pull) if last in (0, 1) else Shift()


CHANGES: Final = {
    "learning": f"{__name__}:SlowLearning",
    "fatigue": f"{__name__}:Fatigue",
    "lapses_in_runs": f"{__name__}:LapsesInRuns",
    "criterion_drift": f"{__name__}:CriterionDrift",
    "serial_dependence": f"{__name__}:SerialDependence",
}
"""Kinds of change, by their names in a study file."""
