"""Hierarchical model of thresholds, log widths and lapse rates.

A cell is one participant in one condition.

The threshold of participant p in condition c is the mean of c plus the effect of p plus the deviation of the cell. The
log width is the mean of its width group plus the effect of p (plus the deviation of the cell if there are several
groups). The logit of the lapse rate is a mean plus the effect of p. Levels are scaled by the range of the whole study.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy.special import expit, log_expit

from tactometry.psychometric import Shape

from ..arrays import Array, Expansion, Indices, lay_out
from ..threshold.counts import POOLED_BELOW, Counts, normalise
from ..threshold.likelihood import GUESS, LAPSE, LOG_WIDTH, N_PARAMETERS, THRESHOLD, expansion, information
from ..threshold.log_posterior import BETA_B, LARGEST_RATE

SCALES = {"threshold": 0.25, "log_width": 0.5, "lapse": 1.0, "threshold_cell": 0.125, "log_width_cell": 0.25}
"""Scales of the half-normal priors of the standard deviations: thresholds in ranges of the levels, log widths, and
logits of the lapse rate."""
LOG_WIDTH_PRIOR = (float(np.log(0.5)), 1.0)
"""Mean and SD of the normal prior of a mean log width, relative to the log range of the levels."""
LKJ = 2.0
"""Concentration of the LKJ prior of the correlation (Lewandowski, Kurowicka and Joe 2009)."""
START = {"threshold": 0.1, "log_width": 0.2, "lapse": 0.5, "threshold_cell": 0.05, "log_width_cell": 0.1}
START_RATE = 0.03


@dataclass(frozen=True)
class StudyCounts:
    """Counts of all cells at scaled levels u = (level - centre) / spread.

    `u`, `n_yes`, `n_trials` have the shape (n_participants, n_conditions, n_levels); unused slots have 0 trials.
    `own_catch` (2, n_participants, n_conditions) contains false alarms and catch trials of each cell, `n_false_alarms`
    and `n_catch` are totals. `lapse_beta`, `guess_beta` and `scale_free_width` are options of `threshold.fit`.
    `conditions` has one row per condition. Conditions with the same `width_group` (n_conditions,) share a mean width.
    """

    participants: tuple[str, ...]
    conditions: pd.DataFrame
    width_group: Indices
    u: Array
    n_yes: Array
    n_trials: Array
    own_catch: Array
    centre: float
    spread: float
    n_false_alarms: float
    n_catch: float
    shape: Shape
    guess_rate: float | None
    lapse_rate: float | None = None
    lapse_beta: float = BETA_B
    guess_beta: float = BETA_B
    scale_free_width: bool = True

    @classmethod
    def of(
        cls,
        names: ArrayLike,
        factors: Mapping[str, ArrayLike],
        width_by: Sequence[str],
        answers: tuple[Array, Array, Array],
        catch: tuple[ArrayLike, ArrayLike] = (0, 0),
        **known: Any,
    ) -> "StudyCounts":
        """Arrange rows of levels, "yes" answers and numbers of trials by cell.

        `catch` contains false alarms and catch trials: of each row's cell, or totals over all participants.
        """
        used = answers[2] > 0
        keys = pd.DataFrame({name: np.asarray(values)[used] for name, values in factors.items()})
        conditions = keys.drop_duplicates().sort_values(list(factors)).reset_index(drop=True)
        both = conditions.reset_index().merge(keys.reset_index(), on=list(factors))
        place = both.sort_values("index_y")["index_x"]  # index of each row's condition, in the original order of rows
        who, participant = np.unique(np.asarray(names, dtype=str)[used], return_inverse=True)
        cell = participant * len(conditions) + place.to_numpy()
        shape = (len(who), len(conditions))
        levels, n_yes, n_trials = (rows[used] for rows in answers)
        low, high = float(levels.min()), float(levels.max())
        centre, spread = low + (high - low) / 2, (high - low) or 1.0
        columns = _counts_of_cells(cell, shape[0] * shape[1], ((levels - centre) / spread, n_yes, n_trials))
        u, k, n = (rows.reshape(*shape, -1) for rows in columns)
        group = conditions.groupby(list(width_by), sort=True).ngroup() if width_by else np.zeros(len(conditions))
        stated = np.array([np.broadcast_to(count, used.shape)[used] for count in catch], dtype=np.float64)
        own, totals = np.zeros((2, shape[0] * shape[1])), stated.max(axis=1)
        if np.ndim(catch[1]):
            own[:, cell] = stated
            totals = own.sum(axis=1)
        width_group, participants = np.asarray(group, dtype=np.int64), tuple(map(str, who))
        of_cells = u, k, n, own.reshape(2, *shape)
        return cls(participants, conditions, width_group, *of_cells, centre, spread, *totals.tolist(), **known)

    @property
    def n_participants(self) -> int:
        return int(self.u.shape[0])

    @property
    def n_conditions(self) -> int:
        return int(self.u.shape[1])

    @property
    def n_groups(self) -> int:
        return int(self.width_group.max()) + 1

    def level(self, u: Array) -> Array:
        """Convert scaled levels to the original unit."""
        with np.errstate(over="ignore"):
            level = self.centre + self.spread * u
            return np.asarray(np.exp(level) if self.shape.on_log_levels else level)

    def only(self, chosen: Indices) -> "StudyCounts":
        """Return the study restricted to some conditions."""
        u, k, n = (counts[:, chosen] for counts in (self.u, self.n_yes, self.n_trials))
        group = np.unique(self.width_group[chosen], return_inverse=True)[1].astype(np.int64)
        conditions, catch = self.conditions.iloc[chosen], self.own_catch[..., chosen]
        return replace(self, u=u, n_yes=k, n_trials=n, own_catch=catch, width_group=group, conditions=conditions)

    def ranges(self) -> tuple[Array, Array, Array]:
        """Return lowest level, highest level and smallest spacing by condition."""
        used = self.n_trials > 0
        low = np.where(used, self.u, np.inf).min(axis=(0, 2))
        high = np.where(used, self.u, -np.inf).max(axis=(0, 2))
        gaps = [_gap(self.u[:, c][used[:, c]], high[c] - low[c]) for c in range(self.n_conditions)]
        return low, high, np.array(gaps)


def _counts_of_cells(cell: Indices, n_cells: int, columns: tuple[Array, Array, Array]) -> tuple[Array, Array, Array]:
    """Arrange rows by cell, shape (n_cells, most rows), and pool equal levels."""
    counts = normalise(*lay_out(cell, *columns, n_clusters=n_cells))
    # Return to the scale of the study, as condition means compare cells.
    u = counts.centre[:, None] + counts.spread[:, None] * counts.u
    u = np.where(counts.n_trials > 0, u, 0.0)
    return u, counts.n_yes, counts.n_trials


def _gap(levels: Array, reach: float) -> float:
    gaps = [upper - lower for lower, upper in pairwise(np.unique(levels))]
    wide = [gap for gap in gaps if gap > POOLED_BELOW * reach]
    return float(min(wide, default=reach or 1.0))


def rate_of(logit: Array) -> tuple[Array, Array, Array]:
    """Return rates between 0 and 0.5 with two derivatives in the logit."""
    share = expit(logit)
    rate = LARGEST_RATE * share
    slope = rate * (1 - share)
    return rate, slope, slope * (1 - 2 * share)


def logit_of(probability: float) -> float:
    """Return the logit of a rate between 0 and 0.5."""
    return float(np.log(probability / (LARGEST_RATE - probability)))


def log_rate_prior(logit: Array, beta: float, n_yes: float = 0.0, n_no: float = 0.0) -> Array:
    """Return the log density of a rate's logit: prior times likelihood."""
    rate = rate_of(logit)[0]
    counted = n_yes * (np.log(LARGEST_RATE) + log_expit(logit)) + (beta - 1 + n_no) * np.log1p(-rate)
    return np.asarray(counted + log_expit(logit) + log_expit(-logit))


@dataclass(frozen=True)
class GroupModel:
    """Model of a study, evaluated at many hyperparameters (n_points, n_hyper).

    `hyper` names the columns: logarithms of standard deviations, the inverse hyperbolic tangent of the correlation,
    logits of rates, and the mean log width if all conditions share it.
    """

    study: StudyCounts

    @cached_property
    def sds(self) -> list[str]:
        """Names of the standard deviations, in the order of the effects."""
        study = self.study
        if study.n_participants == 1:
            return []
        several = study.n_conditions > 1
        lapse = ["lapse"] if study.lapse_rate is None else []
        cells = ["threshold_cell"] * several + ["log_width_cell"] * (several and study.n_groups > 1)
        return ["threshold", "log_width", *lapse, *cells]

    @cached_property
    def hyper(self) -> list[str]:
        rates = [name for name, rate in zip(("lapse_rate", "guess_rate"), self._rates, strict=True) if rate is None]
        correlation = ["correlation"] if self.sds else []
        return [*self.sds, *correlation, *rates, *(["width"] if self.has_one_width else [])]

    @property
    def has_one_width(self) -> bool:
        return self.study.n_groups == 1

    @property
    def _rates(self) -> tuple[float | None, float | None]:
        return self.study.lapse_rate, self.study.guess_rate

    @cached_property
    def kept(self) -> list[int]:
        """Indices of the parameters of the function that have predictors."""
        return [THRESHOLD, LOG_WIDTH, *([LAPSE] if self.study.lapse_rate is None else [])]

    @cached_property
    def fixed(self) -> Array:
        """Design X (n_conditions, n_predictors, n_fixed) of the means."""
        c, n_groups = self.study.n_conditions, self.study.n_groups
        matrix = np.zeros((c, len(self.kept), c + n_groups))
        matrix[:, 0, :c] = np.eye(c)
        matrix[:, 1, c:] = np.eye(n_groups)[self.study.width_group]
        return matrix[..., :c] if self.has_one_width else matrix

    @cached_property
    def random(self) -> Array:
        """Design Z (n_conditions, n_predictors, n_random) of random effects."""
        c, d = self.study.n_conditions, len(self.kept)
        columns = [np.zeros((c, d, 0))]
        for name in self.sds:
            kind = {"threshold": 0, "log_width": 1, "lapse": 2}[name.removesuffix("_cell")]
            block = np.zeros((c, d, c if name.endswith("_cell") else 1))
            block[:, kind] = np.eye(c) if name.endswith("_cell") else 1.0
            columns.append(block)
        return np.concatenate(columns, axis=2)

    @cached_property
    def counts(self) -> Counts:
        n_units = self.study.n_participants * self.study.n_conditions
        u, k, n = (part.reshape(n_units, -1) for part in (self.study.u, self.study.n_yes, self.study.n_trials))
        nothing, n_levels = np.zeros(n_units), np.zeros(n_units, dtype=np.int64)
        return Counts(u, k, n, nothing, nothing, nothing, n_levels)

    def at(self, hyper: Array, name: str) -> Array:
        """Return a hyperparameter by name."""
        return hyper[:, self.hyper.index(name)]

    def offsets(self, hyper: Array) -> Array:
        """Return hyperparameters added to predictors (n_points, n_predictors)."""
        offsets = np.zeros((len(hyper), len(self.kept)))
        if self.has_one_width:
            offsets[:, 1] = self.at(hyper, "width")
        if self.study.lapse_rate is None:
            offsets[:, 2] = self.at(hyper, "lapse_rate")
        return offsets

    def every_mean(self, hyper: Array, means: Array) -> Array:
        """Return mean thresholds of conditions, then mean log widths of groups."""
        widths = [self.at(hyper, "width")[:, None]] if self.has_one_width else []
        return np.concatenate([means, *widths], axis=1)

    def lapses(self, hyper: Array, effects: Array) -> Array:
        """Return lapse rates (n_points, n_participants)."""
        if self.study.lapse_rate is not None:
            return np.full(effects.shape[:2], self.study.lapse_rate)
        own = effects[..., self.sds.index("lapse")] if "lapse" in self.sds else 0.0
        return rate_of(self.at(hyper, "lapse_rate")[:, None] + own)[0]

    def precision(self, hyper: Array) -> tuple[Array, Array]:
        """Return the precision of a participant's effects, and half its log det."""
        size = self.random.shape[2]
        precision, half = np.zeros((len(hyper), size, size)), np.zeros(len(hyper))
        place = 0
        for column, name in enumerate(self.sds):
            n = self.study.n_conditions if name.endswith("_cell") else 1
            diagonal = np.arange(place, place + n)
            precision[:, diagonal, diagonal] = np.exp(-2 * hyper[:, column])[:, None]
            half -= n * hyper[:, column]
            place += n
        if self.sds:
            r = np.tanh(self.at(hyper, "correlation"))
            rest = 1 - r * r
            precision[:, [0, 1], [0, 1]] /= rest[:, None]
            precision[:, 0, 1] = precision[:, 1, 0] = -r * np.exp(-hyper[:, 0] - hyper[:, 1]) / rest
            half -= 0.5 * np.log(rest)
        return precision, half

    def log_prior(self, hyper: Array) -> Array:
        """Return the log density of the hyperparameters (n_points,)."""
        study, total = self.study, np.zeros(len(hyper))
        for column, name in enumerate(self.sds):
            total += hyper[:, column] - 0.5 * np.square(np.exp(hyper[:, column]) / SCALES[name])
        if self.sds:
            total += 2 * LKJ * -np.log(np.cosh(self.at(hyper, "correlation")))
        if study.lapse_rate is None:
            total += log_rate_prior(self.at(hyper, "lapse_rate"), study.lapse_beta)
        if study.guess_rate is None:
            alarms = study.n_false_alarms
            total += log_rate_prior(self.at(hyper, "guess_rate"), study.guess_beta, alarms, study.n_catch - alarms)
        if self.has_one_width:
            mean, precision = self.means_prior
            total -= 0.5 * precision[-1] * np.square(self.at(hyper, "width") - mean[-1])
        return total

    @cached_property
    def means_prior(self) -> tuple[Array, Array]:
        """Prior means and precisions of the mean thresholds and mean log widths."""
        study = self.study
        low, high, _ = study.ranges()
        reach = np.where(high > low, high - low, 1.0)
        wide = np.array([reach[study.width_group == g].max() for g in range(study.n_groups)])
        mean, sd = LOG_WIDTH_PRIOR
        middles = np.concatenate([(low + high) / 2, np.log(wide) + mean])
        return middles, np.concatenate([reach**-2, np.full(study.n_groups, sd**-2)])

    def _theta(self, points: Array, hyper: Array) -> tuple[Array, Array]:
        """Return the parameters of cells and their derivatives in predictors."""
        theta = np.empty((len(points), len(self.counts), N_PARAMETERS))
        theta[..., LAPSE], theta[..., GUESS] = self.study.lapse_rate or 0.0, self.study.guess_rate or 0.0
        theta[..., self.kept] = points.reshape(*theta.shape[:2], -1)
        slopes = np.ones((*theta.shape[:2], len(self.kept)))
        if self.study.guess_rate is None:
            theta[..., GUESS] = rate_of(self.at(hyper, "guess_rate"))[0][:, None]
        if self.study.lapse_rate is None:
            theta[..., LAPSE], slopes[..., 2], _ = rate_of(theta[..., LAPSE])
        return theta, slopes

    def _by_predictors(self, hessian: Array, slopes: Array) -> Array:
        """Convert second derivatives from parameters to predictors (chain rule)."""
        return hessian[..., self.kept, :][..., self.kept] * slopes[..., None] * slopes[..., None, :]

    def log_likelihood(self, points: Array, hyper: Array) -> Expansion:
        """Return the log-likelihood of cells, with derivatives in predictors.

        Predictors have the shape (n_points, n_participants, n_conditions, n_predictors).
        """
        theta, slopes = self._theta(points, hyper)
        whole = expansion(self.study.shape, self.counts, theta)
        gradient, hessian = whole.gradient[..., self.kept] * slopes, self._by_predictors(whole.hessian, slopes)
        if self.study.lapse_rate is None:
            hessian[..., 2, 2] += gradient[..., 2] * (1 - 2 * theta[..., LAPSE] / LARGEST_RATE)
        value = whole.value.reshape(points.shape[:3])
        return Expansion(value, gradient.reshape(points.shape), hessian.reshape(*points.shape, -1))

    def information(self, points: Array, hyper: Array) -> Array:
        """Return the Fisher information of the cells.

        Unlike the negative Hessian it is never negative.

        The shape is (n_points, n_participants, n_conditions, n_predictors, n_predictors).
        """
        theta, slopes = self._theta(points, hyper)
        known = information(self.study.shape, self.counts, theta)
        return self._by_predictors(known, slopes).reshape(*points.shape, -1)

    def start(self, thresholds: Array, log_widths: Array) -> tuple[Array, Array]:
        """Return start values of hyperparameters and means."""
        study = self.study
        low, high, gap = study.ranges()
        reach = 0.2 * (high - low)
        inside = np.clip(thresholds, low - reach, high + reach)
        wide = np.maximum(log_widths, np.log(1.5 * gap))
        groups = np.array([wide[study.width_group == g].mean() for g in range(study.n_groups)])
        known = {"correlation": 0.0, "width": groups[0]}
        known |= dict.fromkeys(("lapse_rate", "guess_rate"), logit_of(START_RATE))
        known |= {name: float(np.log(sd)) for name, sd in START.items()}
        means = inside if self.has_one_width else np.concatenate([inside, groups])
        return np.array([known[name] for name in self.hyper]), means
