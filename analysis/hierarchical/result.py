"""Result of a hierarchical fit: tables, variances, contrasts and effects."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import reduce
from itertools import product

import numpy as np
import pandas as pd

from tactometry.arguments.require import expect

from ..anova.design import epsilons
from ..arrays import Array, StatusWithNote
from ..distributions import Fisher
from .posterior import normal_chances, quantiles


class GroupStatus(StatusWithNote):
    OK = "ok", ""
    ONE_PARTICIPANT = (
        "one_participant",
        "one participant: the variance between participants is unknown, and intervals apply to this participant only",
    )
    NO_THRESHOLD = "no_threshold", "no participant has a threshold in any condition"
    NOT_CONVERGED = "not_converged", "the integral over the variances did not converge: no estimate"
    NO_DATA = "no_data", "there are no trials"


@dataclass(frozen=True)
class Contrast:
    """Weighted sum of the conditions' mean thresholds (or log widths).

    The estimate is a posterior mean with standard deviation and interval. `p` is twice the smaller of the posterior
    probabilities of either sign.
    """

    estimate: float
    standard_error: float
    interval_low: float
    interval_high: float
    p: float


@dataclass(frozen=True)
class FactorEffect:
    """Wald F of an effect with p; `epsilon` multiplies both df."""

    f: float
    df: int
    df_error: int
    p: float
    epsilon: float = 1.0


@dataclass(frozen=True, kw_only=True)
class HierarchicalFit:
    """Result of a hierarchical fit over all participants.

    Parameters
    ----------
    conditions : DataFrame
        Per condition (a column per factor) `threshold`, `standard_error`, `interval_low`, `interval_high`, `width`,
        `width_low`, `width_high`, `status`. An out-of-range threshold is missing; one end of its interval is set if the
        model has one. For ``weibull`` widths and standard errors are of logarithms of the level.
    participants : DataFrame
        The same per participant and condition, with `n_trials` and the participant's own `lapse_rate`: shrunken
        estimates with intervals that include the uncertainty of the group's means, variances and rates.
    components : mapping
        Posterior means of standard deviations: ``threshold``, ``log_width`` and ``lapse`` (logit of the lapse rate)
        between participants, and ``threshold_cell`` and ``log_width_cell`` of the cells about condition plus
        participant.
    correlation : float or None
        Correlation of threshold and log width between participants.
    lapse_rate, guess_rate : float or None
        Mean lapse rate of the participants, and the shared guess rate.
    n_effective : float or None
        Effective number of points of the integral over the hyperparameters: the relative error of a standard error
        is about 1 / sqrt(2 `n_effective`).
    weights, means, covariance : ndarray
        Weights of the points of that integral, and at each point the means and covariance of the conditions' thresholds
        followed by the log widths of the width groups (for ``weibull`` log thresholds). `width_group` is the group of
        each condition.
    """

    conditions: pd.DataFrame
    participants: pd.DataFrame
    components: Mapping[str, float] = field(default_factory=dict)
    correlation: float | None = None
    lapse_rate: float | None = None
    guess_rate: float | None = None
    n_effective: float | None = None
    status: GroupStatus = GroupStatus.NO_DATA
    note: str = GroupStatus.NO_DATA.note
    factors: tuple[str, ...]
    n_participants: int = 0
    interval: float
    weights: Array = field(default_factory=lambda: np.zeros(0))
    means: Array = field(default_factory=lambda: np.zeros((0, 0)))
    covariance: Array = field(default_factory=lambda: np.zeros((0, 0, 0)))
    width_group: tuple[int, ...] = ()

    def contrast(self, weights: Mapping[tuple[float | str, ...], float], *, of: str = "threshold") -> Contrast:
        """Return a weighted sum of conditions, named by their factor values.

        Raises `InvalidParameter` for a condition without a mean, a quantity other than ``threshold`` or ``log_width``
        (or a width that is only bounded), or fewer than two participants.
        """
        keys = self._keys()
        for key in weights:
            expect(key in keys, "weights", repr(key), f"conditions, such as {keys[0]!r}")
        row = self._rows(np.array([[weights.get(key, 0.0) for key in keys]]), of)[0]
        at, sds = self.means @ row, np.sqrt(np.einsum("i,nij,j->n", row, self.covariance, row))
        estimate = float(self.weights @ at)
        error = float(np.sqrt(self.weights @ (np.square(sds) + np.square(at - estimate))))
        low, high = (float(quantiles(self.weights, at, sds, (1 + side * self.interval) / 2)) for side in (-1, 1))
        below = float(self.weights @ normal_chances(at, sds))
        return Contrast(estimate, error, low, high, 2 * min(below, 1 - below))

    def effect(self, *factors: str, of: str = "threshold") -> FactorEffect:
        """Return Wald's test of a main effect or of an interaction.

        The conditions must form a complete factorial.

        F is the posterior mean of Wald's statistic. The error has df (n - 1) degrees of freedom, as in the
        repeated-measures analysis: the model has one variance for the deviations of all cells. Chi and Muller's epsilon
        corrects both degrees of freedom if the differences between conditions have unequal variances
        (`contrasts.epsilons`).

        Raises `InvalidParameter` for an unknown factor, an incomplete factorial, or conditions that share a width. Also
        as `contrast`.
        """
        weights = self._effect_weights(factors)
        rows = self._rows(weights, of)
        has_own_widths = np.linalg.matrix_rank(rows) == len(rows)
        requested = f"{of!r} over {', '.join(factors)}"
        expect(has_own_widths, "of", requested, "conditions with separate widths (width_by)")
        differences, df = self.means @ rows.T, len(rows)
        scaled = np.linalg.solve(rows @ self.covariance @ rows.T, differences[..., None])[..., 0]
        f = float(self.weights @ (differences * scaled).sum(axis=1)) / df
        df_error, epsilon = df * (self.n_participants - 1), self._epsilon(weights, of)
        p = float(Fisher.sf(f, epsilon * df, epsilon * df_error))
        return FactorEffect(f, df, df_error, p, epsilon)

    def _epsilon(self, weights: Array, of: str) -> float:
        """Return Chi and Muller's epsilon (lower bound below 3 participants)."""
        names, column = list(self.factors), {"threshold": "threshold", "log_width": "width"}[of]
        wide = self.participants.pivot(index="participant", columns=names, values=column)
        # pandas does not use tuples for a single level
        keys = [key if len(key) > 1 else key[0] for key in self._keys()]
        values = wide[keys].dropna().to_numpy(dtype=np.float64)
        if len(values) < 3:
            return 1 / len(weights)
        contrast = np.linalg.qr(weights.T)[0]  # epsilon requires orthonormal contrasts
        scores = (np.log(values) if of == "log_width" else values) @ contrast
        covariance = np.asarray(np.cov(scores, rowvar=False), dtype=np.float64).reshape(len(weights), -1)
        return epsilons(covariance, len(values) - 1)[2]

    def _keys(self) -> list[tuple[float | str, ...]]:
        return [tuple(row) for row in self.conditions[list(self.factors)].itertuples(index=False)]

    def _rows(self, weights: Array, of: str) -> Array:
        """Convert weights of conditions to weights of all means."""
        expect(of in ("threshold", "log_width"), "of", repr(of), "'threshold' or 'log_width'")
        is_fitted = self.n_participants > 1 and len(self.means) > 0
        expect(is_fitted, "participants", self.n_participants, "at least two participants with a fit")
        is_missing = self.conditions["threshold"].isna().to_numpy()
        lost = self.conditions.loc[(weights != 0).any(axis=0) & is_missing]
        names = ", ".join(str(tuple(row)) for row in lost[[*self.factors, "status"]].itertuples(index=False))
        expect(not names, "conditions", f"no mean threshold for {names}", "conditions with one")
        is_bounded = of == "log_width" and bool(self.conditions["width"].isna().all())
        expect(not is_bounded, "of", repr(of), "'threshold', as the widths have only an upper bound")
        n, rows = len(self.conditions), np.zeros((len(weights), self.means.shape[1]))
        if of == "threshold":
            rows[:, :n] = weights
        else:  # add up the weights of conditions that share a width
            np.add.at(rows.T, n + np.array(self.width_group), weights.T)
        return rows

    def _effect_weights(self, factors: Sequence[str]) -> Array:
        levels = [sorted(self.conditions[name].unique()) for name in self.factors]
        is_complete = len(self.conditions) == int(np.prod([len(values) for values in levels]))
        requested = f"{', '.join(factors) or 'none'} over {len(self.conditions)} conditions"
        known = f"factors of {', '.join(self.factors)} with every combination of their levels"
        are_known = len(factors) > 0 and {*factors} <= {*self.factors}
        expect(are_known and is_complete, "factors", requested, known)
        by_factor = []
        for name, values in zip(self.factors, levels, strict=True):
            # Contrast the levels of the named factors and average over the levels of the others.
            differences, mean = np.diff(np.eye(len(values)), axis=0), np.full((1, len(values)), 1 / len(values))
            by_factor.append(differences if name in factors else mean)
        weights = reduce(np.kron, by_factor)
        order = {key: place for place, key in enumerate(product(*levels))}
        return np.asarray(weights[:, [order[key] for key in self._keys()]])
