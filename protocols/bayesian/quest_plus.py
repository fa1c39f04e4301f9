"""QUEST+ for one track, or for several that share all but a threshold."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal, Self, get_args

import numpy as np
from numpy.typing import NDArray

from tactometry.arguments.constraints import Positive, constrained
from tactometry.arguments.require import at_most, expect, lookup, numbers, of_kind, one_of
from tactometry.errors import rewording

from ..procedures.procedure import Count, DelegatingProcedure, Procedure
from .outcome_model import Array, DenseLikelihoods, Likelihoods, OutcomeModel, p_log_p, size, tabulate
from .weighing import Posterior, WeighingRule, WeighingRun, entropies

Aim = Literal["parameters", "threshold"]
Criterion = Literal["entropy", "variance"]
MOST_CHANCES = 100_000_000
"""Largest number of entries in a table of one outcome: 800 MB."""
TIE = 1e-12
"""Relative tolerance within which expected losses are equal, so that rounding does not choose a level."""


@dataclass(frozen=True, eq=False)
@constrained
class QuestPlus(WeighingRule):
    """Bayesian placement by minimum expected entropy or variance.

    It accepts any model of answers. Watson, J. Vision 17(3):10 (2017). The `aim` ``parameters`` minimises the entropy
    of the posterior, or the sum of the parameters' variances relative to their priors. The `aim` ``threshold``
    minimises that of the first parameter alone (Prins, J. Vision 13(7):3, 2013). Among equal levels the first one is
    chosen.

    A run ends after `n_trials`, or when the posterior standard deviation of the first parameter is at most `sd_stop`.
    It is censored if this parameter is most likely at an end of its grid, and aborted if no cell allows the answers.

    - `levels`: Candidate levels.
    - `grid`: `ParameterGrid`, or `FunctionModel` for other parameters and outcomes. Its first parameter is the
      threshold.
    - `prior`: Weights of the values of a parameter, on any scale. Parameters that are not named have a flat prior.

    >>> from tactometry.protocols.bayesian.parameter_grid import ParameterGrid
    >>> levels = tuple(range(-40, 1))
    >>> rule = QuestPlus(levels, ParameterGrid(levels, widths=(10.0,)), n_trials=2)
    >>> rule.level, rule.after(1).level, rule.after(1).after(0).ending
    (-17, -21, 'trials')
    """

    levels: tuple[float, ...]
    grid: OutcomeModel
    n_trials: Count = 60
    sd_stop: Positive | None = None
    aim: Aim = "parameters"
    criterion: Criterion = "entropy"
    prior: Mapping[str, Sequence[float]] = field(default_factory=dict)

    name = "quest_plus"

    def __post_init__(self) -> None:
        numbers("QuestPlus.levels", self.levels)
        n_levels, n_different = len(self.levels), len(set(self.levels))
        listed = f"{n_levels} levels, {n_different} of them different"
        expect(n_levels == n_different >= 2, "QuestPlus.levels", listed, "at least two, each once")
        one_of("QuestPlus.aim", self.aim, get_args(Aim))
        one_of("QuestPlus.criterion", self.criterion, get_args(Criterion))
        of_kind("QuestPlus", OutcomeModel, grid=self.grid)
        n_chances = n_levels * math.prod(size(self.grid))
        at_most("QuestPlus: levels times combinations of parameters", n_chances, MOST_CHANCES)
        _ = self.level, self.log_likelihood(self.levels[0], 0)  # builds the tables before the first trial

    @property
    def n_outcomes(self) -> int:
        return self.grid.n_outcomes

    def begin(self, rng: np.random.Generator | None = None) -> "QuestPlusRun":
        del rng
        return QuestPlusRun(self, state=self.prior_state)

    def begin_together(self, tracks: Sequence[str]) -> "tuple[SharedTrack, ...]":
        return SharedQuestPlus(self, tuple(tracks)).procedures()

    @cached_property
    def likelihoods(self) -> Likelihoods:
        return self.grid.likelihoods(self.levels)

    @cached_property
    def prior_state(self) -> Posterior:
        parameters = self.grid.parameters
        of_kind("QuestPlus", Mapping, prior=self.prior)
        for name, weights in self.prior.items():
            numbers(f"QuestPlus.prior[{name!r}]", weights)
            one_of("QuestPlus.prior", name, parameters)
            known, n_values = np.asarray(weights, dtype=np.float64), len(parameters[name])
            are_weights = known.shape == (n_values,) and (known >= 0).all() and 0 < known.sum() < math.inf
            listed = f"{len(weights)} weights from {known.min(initial=0):g} on"
            expect(are_weights, f"QuestPlus.prior[{name!r}]", listed, f"{n_values} finite numbers from 0, not all 0")

        with np.errstate(divide="ignore"):
            axes = [np.log(self.prior.get(name, np.ones(len(values)))) for name, values in parameters.items()]
        total: Array = sum(np.ix_(*axes), start=np.zeros(()))
        prior = Posterior.of(total.ravel())
        assert prior is not None  # every parameter has a weight above 0
        return prior

    @cached_property
    def thresholds(self) -> Array:
        return np.asarray(next(iter(self.grid.parameters.values())), dtype=np.float64)

    @property
    def point(self) -> str:
        return "of the half point of its functions"

    @cached_property
    def dense(self) -> DenseLikelihoods:
        """Probabilities in one table, for stacks of sets."""
        return tabulate(self.grid, self.levels)

    def places(self, log_weights: Array, weights: Array) -> Array:
        losses = expected_losses(self, self.dense, weights.T, entropies(log_weights, weights))
        return np.asarray(self.levels, dtype=np.float64)[least(losses)]

    def log_likelihoods(self, levels: Array, answers: NDArray[np.int8]) -> Array:
        index = {level: n for n, level in enumerate(self.levels)}
        places = np.array([index.get(level, -1) for level in levels.tolist()], dtype=np.intp)
        result = np.asarray(self.dense.logarithms[answers, places])
        for n in np.flatnonzero(places < 0):  # the delivered level is not a candidate
            result[n] = self.grid.log_likelihood(float(levels[n]), int(answers[n]))
        return result

    def log_likelihood(self, level: float, outcome: int) -> Array:
        tabled = self.likelihoods.log_likelihood(self.levels.index(level), outcome) if level in self.levels else None
        return self.grid.log_likelihood(level, outcome) if tabled is None else tabled


@dataclass(frozen=True, eq=False)
class QuestPlusRun(WeighingRun[QuestPlus]):
    """Run of a `QuestPlus`."""

    @property
    def posterior(self) -> Array:
        """Weights (n_first, n_rest) that add up to 1."""
        return self.state.weights.reshape(size(self.rule.grid))

    def marginal(self, parameter: str) -> Array:
        """Return the posterior of one parameter, (n_values,)."""
        names = list(self.rule.grid.parameters)
        one_of("QuestPlus.marginal", parameter, names)
        cells = self.state.weights.reshape([len(values) for values in self.rule.grid.parameters.values()])
        others = tuple(n for n, name in enumerate(names) if name != parameter)
        return np.asarray(cells.sum(axis=others), dtype=np.float64)

    def mean(self, parameter: str) -> float:
        """Return the posterior mean of one parameter."""
        return float(self.marginal(parameter) @ np.asarray(self.rule.grid.parameters[parameter]))

    @cached_property
    def level(self) -> float:
        """First level with the smallest expected loss."""
        return self.rule.levels[int(least(self.expected_loss()))]

    def expected_loss(self) -> Array:
        """Return the expected entropy (nat) or variance after an answer, (n_levels,)."""
        return expected_losses(self.rule, self.rule.likelihoods, self.state.weights, self.state.entropy)

    @property
    def remark(self) -> str | None:
        """Reason why a run has no threshold, or None."""
        first = next(iter(self.rule.grid.parameters))
        if self.ending == "aborted":
            return (
                f"QuestPlus.grid: found answer {self.responses[-1]} at level {self.delivered[-1]:g} in trial "
                f"{len(self.responses)}, which with the answers before it no cell of the grid allows, expected a grid "
                "that can; give it guess and lapse rates above 0 or a wider range"
            )
        if self.ending in ("censored_above", "censored_below"):
            end, bound = ("last", "above") if self.ending == "censored_above" else ("first", "below")
            return f"QuestPlus: the {end} {first} of the grid is the likeliest; the true one may lie {bound} it"
        return None


@dataclass(frozen=True, eq=False)
class SharedQuestPlus:
    """`QuestPlus` on several tracks that share all parameters but the first.

    The thresholds are independent given the shared parameters, so one likelihood table (n_first, n_rest) per track is
    exact: ``p(t_k, s) ~ p(t_k) p(s) L_k(t_k, s) prod_j sum_t p(t) L_j(t, s)``. A track that had reached `sd_stop` may
    continue after answers on another track, up to `n_trials`.

    >>> from tactometry.protocols.bayesian.parameter_grid import ParameterGrid
    >>> rule = QuestPlus((0.0, 5.0, 10.0), ParameterGrid((0.0, 5.0, 10.0), (4.0, 8.0)), n_trials=2)
    >>> pool = SharedQuestPlus(rule, ("30 Hz", "240 Hz")).after("30 Hz", 1)
    >>> len(pool.procedure("30 Hz").responses), len(pool.procedure("240 Hz").responses)
    (1, 0)
    """

    rule: QuestPlus
    tracks: tuple[str, ...]
    log_likelihoods: Mapping[str, Array] = field(default_factory=dict, repr=False)
    runs: Mapping[str, QuestPlusRun] = field(default_factory=dict, repr=False)

    def __post_init__(self) -> None:
        of_kind("SharedQuestPlus", QuestPlus, rule=self.rule)
        of_kind("SharedQuestPlus", tuple, tracks=self.tracks)
        are_names = self.tracks and len(set(self.tracks)) == len(self.tracks)
        expect(bool(are_names), "SharedQuestPlus.tracks", self.tracks, "names, each once")

    @property
    def finished(self) -> bool:
        return all(self.procedure(track).finished for track in self.tracks)

    def procedure(self, track: str) -> QuestPlusRun:
        """Return the run of a track. Report answers to the pool, not to this run."""
        return lookup("SharedQuestPlus.track", track, self._views)

    def procedures(self) -> tuple["SharedTrack", ...]:
        """Return a procedure for each track."""
        return tuple(SharedTrack(self, track) for track in self.tracks)

    @cached_property
    def _views(self) -> Mapping[str, QuestPlusRun]:
        from scipy.special import logsumexp  # slow to load

        prior = self.rule.prior_state.weights.reshape(size(self.rule.grid))
        with np.errstate(divide="ignore"):
            first, shared = np.log(prior.sum(axis=1)), np.log(prior.sum(axis=0))
        unanswered = np.zeros(prior.shape)
        joint = {track: first[:, None] + self.log_likelihoods.get(track, unanswered) for track in self.tracks}
        evidence = {track: logsumexp(table, axis=0) for track, table in joint.items()}

        views = {}
        for track in self.tracks:
            of_others = sum((each for name, each in evidence.items() if name != track), start=shared)
            state = Posterior.of((joint[track] + of_others).ravel())
            assert state is not None  # impossible answers are ignored
            views[track] = replace(self.runs.get(track, self.rule.begin()), state=state)
        return views

    def after(self, track: str, response: int | bool, delivered: float | None = None) -> Self:
        """Return the pool after an answer to a delivered level on one track."""
        with rewording(lambda words: f"SharedQuestPlus track {track!r}, {words}"):
            run = self.procedure(track).after(response, delivered)
        pool = replace(self, runs={**self.runs, track: run})
        if run.contradicted:  # an impossible answer would leave the other tracks without weights
            return pool
        log_likelihood = self.rule.grid.log_likelihood(run.delivered[-1], run.responses[-1])
        table = self.log_likelihoods.get(track, 0.0) + log_likelihood.reshape(size(self.rule.grid))
        return replace(pool, log_likelihoods={**self.log_likelihoods, track: table})


@dataclass(frozen=True, eq=False)
class SharedTrack(DelegatingProcedure):
    """One track of a `SharedQuestPlus` as a procedure."""

    pool: SharedQuestPlus
    track: str

    name = "quest_plus"
    learns_from_easy = True

    @property
    def view(self) -> QuestPlusRun:
        return self.pool.procedure(self.track)

    def after(self, response: int | bool, delivered: float | None = None) -> Self:
        return replace(self, pool=self.pool.after(self.track, response, delivered))

    def learning_from(self, other: Procedure) -> Self:
        if isinstance(other, SharedTrack) and other.pool.rule is self.pool.rule:
            return replace(self, pool=other.pool)
        return self


def least(losses: Array) -> NDArray[np.intp]:
    """Return the first index of the smallest loss (n_levels, ...), up to `TIE`."""
    lowest = losses.min(axis=0)
    return np.asarray((losses <= lowest + TIE * (1 + np.abs(lowest))).argmax(axis=0))


def expected_losses(rule: QuestPlus, likelihoods: Likelihoods, weights: Array, entropy: Array | float) -> Array:
    """Return the expected loss after one more answer at each level, (n_levels,).

    The loss is an entropy (nat) or a variance. Weights are (n_cells,), or (n_cells, n_sets) with the entropy of each
    set if `likelihoods` accepts stacks.
    """
    if rule.criterion == "variance":
        return _expected_variance(rule, likelihoods, weights)
    # the posterior of a possible answer is not needed: H(cell | answer) = H(cell) + H(answer | cell) - H(answer), and
    # for the threshold alone H(threshold | answer) = H(threshold, answer) - H(answer)
    spread = _sum_p_log_p(likelihoods.total(weights))
    if rule.aim == "threshold":
        return np.asarray(spread - _sum_p_log_p(likelihoods.joint(weights)).sum(axis=1), dtype=np.float64)
    return spread - likelihoods.certainty(weights) + entropy


def _expected_variance(rule: QuestPlus, likelihoods: Likelihoods, weights: Array) -> Array:
    """Return the expected variance of the first parameter, or the sum of all."""
    values = [np.asarray(each, dtype=np.float64) for each in rule.grid.parameters.values()]
    axes = [axis.ravel() for axis in np.meshgrid(*values, indexing="ij")]
    if rule.aim == "threshold":
        return _variance_of(axes[0], likelihoods, weights)

    prior, total = rule.prior_state.weights, np.zeros((len(rule.levels), *weights.shape[1:]))
    for axis in axes:
        spread = float(prior @ (axis - float(prior @ axis)) ** 2)
        if np.ptp(axis) > 0 and spread > 0:
            total += _variance_of(axis, likelihoods, weights) / spread
    return total


def _variance_of(axis: Array, likelihoods: Likelihoods, weights: Array) -> Array:
    # relative to the mean, so that the difference of squares does not lose digits
    away = np.subtract.outer(axis, axis @ weights)
    mass, first, second = (likelihoods.total(weights * away**power) for power in range(3))
    left: Array = second - first**2 / np.where(mass > 0, mass, 1.0)
    return np.asarray(np.where(mass > 0, left, 0.0).sum(axis=0), dtype=np.float64)


def _sum_p_log_p(probabilities: Array) -> Array:
    """Return the sum of p log p over outcomes, the first axis."""
    return np.asarray(p_log_p(probabilities).sum(axis=0), dtype=np.float64)
