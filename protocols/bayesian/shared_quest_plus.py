"""QUEST+ in several conditions at once: a threshold each, and one width, guess and lapse rate for all."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Self

import numpy as np
from scipy.special import logsumexp

from tactometry.arguments.require import expect, lookup, of_kind
from tactometry.errors import InvalidParameter

from ..procedures.procedure import Ending, Procedure, RuleThreshold, Sharing
from .outcome_model import Array, size
from .posterior import Posterior, log_prior
from .quest_plus import QuestPlus, QuestPlusRun


@dataclass(frozen=True, eq=False)
class SharedQuestPlus:
    """`QuestPlus` on several tracks whose posterior shares every parameter but the first.

    Given the shared parameters, thresholds are independent, so that the joint posterior of all thresholds is exact
    from one likelihood table (n_first, n_rest) a track: a track weighs its own table with the evidence of all others,
    ``p(t_k, s) ~ p(t_k) p(s) L_k(t_k, s) prod_j sum_t p(t) L_j(t, s)``. Expected entropy (Watson 2017) is that of the
    track's own threshold and the shared parameters; an answer tells nothing of the other thresholds that these do not.

    `procedures()` gives each track as a procedure for a block that interleaves them. A track whose spread was within
    the rule's `sd_stop` may go on again when another track's answers move what they share; `n_trials` bounds each.

    Parameters
    ----------
    rule : QuestPlus
        That of every track.
    tracks : tuple of str
        Their names.

    Raises
    ------
    InvalidParameter
        If there is no track, or a name stands twice.

    >>> from tactometry.protocols import ParameterGrid
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
        """How a track stands. Tell answers to the pool, not to this."""
        return lookup("SharedQuestPlus.track", track, self._views)

    def procedures(self) -> tuple["SharedTrack", ...]:
        """One for each track."""
        return tuple(SharedTrack(self, track) for track in self.tracks)

    @cached_property
    def _views(self) -> Mapping[str, QuestPlusRun]:
        evidence = {track: logsumexp(self._own(track), axis=0) for track in self.tracks}
        return {track: self._view(track, evidence) for track in self.tracks}

    def _view(self, track: str, evidence: Mapping[str, Array]) -> QuestPlusRun:
        of_others = sum((table for name, table in evidence.items() if name != track), start=self._log_shared_prior)
        state = Posterior.of((self._own(track) + of_others).ravel())
        assert state is not None  # answers that nothing allows are not taken in
        return replace(self.runs.get(track, self.rule.begin()), state=state)

    def _own(self, track: str) -> Array:
        """log p(t) L(t, s), (n_first, n_rest)."""
        return np.asarray(self._log_first_prior[:, None] + self.log_likelihoods.get(track, 0.0) + np.zeros(self._size))

    @property
    def _size(self) -> tuple[int, int]:
        return size(self.rule.grid)

    @cached_property
    def _log_first_prior(self) -> Array:
        first, *_ = self.rule.grid.parameters
        return self._log_prior(first)

    @cached_property
    def _log_shared_prior(self) -> Array:
        _, *shared = self.rule.grid.parameters
        return self._log_prior(*shared)

    def _log_prior(self, *names: str) -> Array:
        parameters, prior = self.rule.grid.parameters, self.rule.prior
        return log_prior(
            {name: parameters[name] for name in names},
            {name: prior[name] for name in names if name in prior},
            "SharedQuestPlus",
        )

    def after(self, track: str, response: int | bool, delivered: float | None = None) -> Self:
        """The pool after an answer to the level that was delivered on one track."""
        try:
            run = self.procedure(track).after(response, delivered)
        except InvalidParameter as error:
            raise InvalidParameter(f"SharedQuestPlus track {track!r}, {error}") from None
        pool = replace(self, runs={**self.runs, track: run})
        if run.contradicted:  # what nothing allows would leave no weight to the other tracks
            return pool
        log_likelihood = self.rule.grid.log_likelihood(run.delivered[-1], run.responses[-1]).reshape(self._size)
        table = self.log_likelihoods.get(track, 0.0) + log_likelihood
        return replace(pool, log_likelihoods={**self.log_likelihoods, track: table})


@dataclass(frozen=True, eq=False)
class SharedTrack(Sharing):
    """One track of a `SharedQuestPlus` as a procedure.

    >>> from tactometry.protocols import ParameterGrid
    >>> rule = QuestPlus((0.0, 5.0, 10.0), ParameterGrid((0.0, 5.0, 10.0), (4.0, 8.0)), n_trials=2)
    >>> slow, fast = SharedQuestPlus(rule, ("30 Hz", "240 Hz")).procedures()
    >>> slow = slow.after(1)
    >>> fast.learning_from(slow).pool is slow.pool
    True
    """

    pool: SharedQuestPlus
    track: str

    name = "quest_plus"

    @property
    def view(self) -> QuestPlusRun:
        """The track's run with what all tracks say: threshold, spread, marginals, `remark`."""
        return self.pool.procedure(self.track)

    @property
    def level(self) -> float:
        return self.view.level

    @property
    def bounds(self) -> tuple[float, float]:
        return self.pool.rule.bounds

    @property
    def n_trials_at_most(self) -> int:
        return self.pool.rule.n_trials_at_most

    @property
    def ending(self) -> Ending | None:
        return self.view.ending

    @property
    def estimate(self) -> RuleThreshold:
        return self.view.estimate

    def after(self, response: int | bool, delivered: float | None = None) -> Self:
        """The track after an answer of its own."""
        return replace(self, pool=self.pool.after(self.track, response, delivered))

    def learning_from(self, other: Procedure) -> Self:
        """The track after an answer on another track of the same pool."""
        if isinstance(other, SharedTrack) and other.pool.rule is self.pool.rule:
            return replace(self, pool=other.pool)
        return self
