"""Thresholds of all participants and conditions at once: a hierarchical psychometric model.

The threshold of a participant in a condition is the condition's mean, plus the participant's effect, plus the
cell's own deviation; the logarithm of the width likewise. The effects are normal, those of threshold and width
correlated, and integrated over by Laplace's approximation (`laplace`). A participant with few or extreme answers is
drawn to the group as far as the answers leave it open; nothing is put in place of a threshold outside of the levels.
"""

from __future__ import annotations  # so that `help` says ArrayLike, and not what it stands for

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from tactometry.arguments.require import between, expect
from tactometry.psychometric import shape_named

from ..arrays import Array
from ..mixed_models.laplace import ClusteredModel, MixedFit, maximise
from ..threshold.counts import count_arrays
from ..threshold.fitting import check_rates
from ..threshold.likelihood import GUESS, LAPSE
from ..threshold.prior import BETA_B
from .model import CORRELATED_FROM, mixed_model, rate_of, start
from .result import Contrast, FactorEffect, GroupStatus, HierarchicalFit
from .starts import Alone, Known, single_fits
from .study import StudyCounts
from .tables import CONDITION_COLUMNS, ParameterPlace, cells, condition_table, means, participant_table, reaches

ZERO_SD = 1e-3
"""A standard deviation below this part of the range of the levels (below this, for the log width) is none."""
LARGEST_GRADIENT = 1e-2
START_FACTORS = (1.0, 0.3, 3.0)
ONE_WIDTH = "widths are taken to be the same in all participants: the answers do not tell how they vary"
HIGH_LAPSES = 0.1
OPEN_LAPSES = (
    "a lapse rate of {:.0%} for all: where levels lie about the threshold alone, the answers leave open whether it is "
    "that or lower thresholds; state the lapse rate, or ask far above the threshold too"
)
OPEN_MEAN = "the mean threshold of a condition is known to no better than the range of its levels"
COMPONENTS = ("threshold", "log_width", "threshold_cell", "log_width_cell")


def fit_hierarchical(
    levels: ArrayLike,
    n_correct: ArrayLike,
    n_trials: ArrayLike,
    participants: Sequence[str],
    conditions: Mapping[str, Sequence[float | str]],
    *,
    shape: str,
    guess_rate: float | None,
    lapse_rate: float | None = None,
    width_by: Sequence[str] = (),
    interval: float = 0.95,
    lapse_beta: float = BETA_B,
    guess_beta: float = BETA_B,
    scale_free_width: bool = True,
    n_false_alarms: ArrayLike = 0,
    n_catch: ArrayLike = 0,
    known: Known | None = None,
) -> HierarchicalFit:
    """Fit the thresholds of all participants and conditions at once.

    Parameters
    ----------
    levels, n_correct, n_trials, participants : (n_rows,)
        One row a participant, condition and level. Rows without trials are ignored; cells may be missing.
    conditions : mapping of factor to (n_rows,)
        The values of each factor.
    shape : str
        As for `threshold.fit`.
    guess_rate, lapse_rate : float or None
        Known, or (None) estimated, the same for all, under the prior of `threshold.fit`; a free guess rate with the
        catch trials of all participants together.
    n_false_alarms, n_catch : int or (n_rows,)
        "Yes" answers to catch trials, and catch trials: those of all participants together, or (better) of each row's
        cell, the same in all rows of a cell: then they bear on the verdict of each cell too.
    width_by : sequence of str
        The factors on which the mean log width depends; by default one mean for all.
    lapse_beta, guess_beta, scale_free_width
        As for `threshold.fit`; the latter for the fits of single cells, which the verdicts rest on.
    interval : float
        Coverage of the intervals.
    known : mapping of (participant, values of the factors) to ThresholdFit, optional
        What `threshold.fit` said of single cells with the same shape, rates and priors; others are fitted here. Not for
        the shape ``weibull``.

    Returns
    -------
    HierarchicalFit

    Raises
    ------
    InvalidParameter
        For what is no number, an impossible count (naming the row), an unknown name.

    Notes
    -----
    Maximum likelihood by Laplace's approximation, but for psignifit's priors on the mean threshold and width of each
    condition: flat within its levels, they keep means finite that the answers leave open. Standard errors of
    means and contrasts are multiplied by sqrt(n / (n - 1)), which makes the variances of a balanced design those of
    restricted maximum likelihood, and intervals are t with n - 1 degrees of freedom.

    Examples
    --------
    >>> rows = [(who, x, k) for who, ks in {"A": (1, 4, 9, 10), "B": (0, 2, 6, 10), "C": (3, 6, 9, 10)}.items()
    ...     for x, k in zip((1, 2, 3, 4), ks)]
    >>> participants, levels, k = zip(*rows)
    >>> found = fit_hierarchical(levels, k, 10, participants, {"force_n": [0.5] * 12}, shape="logistic", guess_rate=0.0,
    ...     lapse_rate=0.0)
    >>> found.n_participants, round(float(found.conditions["threshold"][0]), 1)
    (3, 2.2)
    """
    curve = shape_named(shape)
    _check(conditions, width_by, interval, (guess_rate, lapse_rate))
    names = np.asarray([str(name) for name in participants])
    x, k, n = (rows[0] for rows in count_arrays(levels, n_correct, n_trials, logarithms=curve.on_log_levels))
    used = n > 0
    factors = {name: np.asarray(values)[used] for name, values in conditions.items()}
    if not used.any():
        return _no_data(tuple(conditions), interval)
    answers = (x[used], k[used], n[used])
    by_row = [np.broadcast_to(count, n.shape)[used] for count in (n_false_alarms, n_catch)]
    catch = np.array(by_row, dtype=np.float64)
    stated = {"shape": curve, "guess_rate": guess_rate, "lapse_rate": lapse_rate}
    stated |= {"lapse_beta": lapse_beta, "guess_beta": guess_beta}
    stated |= dict(zip(("n_false_alarms", "n_catch"), catch.max(axis=1), strict=True))
    stated["scale_free_width"] = scale_free_width
    of_cells = catch if np.ndim(n_catch) else None  # one number is that of all participants together
    study = StudyCounts.of(names[used], factors, width_by, answers, of_cells, **stated)
    # By now the levels are logarithms, over which a Weibull function is a Gumbel function.
    alone = single_fits(study, "gumbel" if shape == "weibull" else shape, {} if curve.on_log_levels else known or {})
    return _fit(alone, interval, width_varies=not alone.separated)


def _check(
    conditions: Mapping[str, object], width_by: Sequence[str], interval: float, rates: tuple[float | None, float | None]
) -> None:
    for name in width_by:
        expect(name in conditions, "width_by", repr(name), f"factors of {', '.join(conditions)}")
    expect(len(conditions) > 0, "conditions", "no factor", "at least one, with one value if nothing varied")
    between("fit_hierarchical", 0, 1, interval=interval)
    check_rates("fit_hierarchical", *rates)


def _no_data(factors: tuple[str, ...], interval: float) -> HierarchicalFit:
    empty = pd.DataFrame({name: [] for name in (*factors, *CONDITION_COLUMNS)})
    return HierarchicalFit(conditions=empty, participants=empty, factors=factors, interval=interval)


def _fit(alone: Alone, interval: float, *, width_varies: bool) -> HierarchicalFit:
    study = alone.study
    kept = replace(study.only(alone.with_threshold), width_varies=width_varies)
    if not kept.n_conditions:
        return _without_model(alone, GroupStatus.NO_THRESHOLD, interval)
    model = mixed_model(kept)
    mixed_fit = _maximum(model, start(kept, model, *alone.start()))
    if width_varies and not _has_converged(mixed_fit):
        return _fit(alone, interval, width_varies=False)
    status = _status(kept, model, mixed_fit)
    if status == GroupStatus.NOT_CONVERGED:
        return _without_model(alone, status, interval)
    n = study.n_participants
    group_reach, participant_reach = reaches(n, interval)
    inflation = float(np.sqrt(n / (n - 1))) if n > 1 else 1.0  # to the restricted likelihood's
    chosen = alone.with_threshold
    of_group = ParameterPlace.unknown(study.n_conditions).replaced(chosen, means(kept, mixed_fit, inflation))
    of_cells = ParameterPlace.unknown(study.n_conditions, n).replaced(chosen, cells(model, mixed_fit))
    angles = zip(study.shared, model.parts(mixed_fit.parameters)[1], strict=True)
    rates = {place: float(rate_of(np.array(angle))[0]) for place, angle in angles}
    note = "; ".join(filter(None, (status.note, "" if width_varies else ONE_WIDTH, *_open(kept, mixed_fit, rates))))
    components, correlation = _components(kept, model, mixed_fit)
    all_means, covariance, width_group = _means_of_all(alone, kept, mixed_fit, inflation)
    return HierarchicalFit(
        conditions=condition_table(alone, of_group, group_reach),
        participants=participant_table(alone, of_cells, participant_reach),
        components=components,
        correlation=correlation,
        lapse_rate=rates.get(LAPSE, study.lapse_rate),
        guess_rate=rates.get(GUESS, study.guess_rate),
        log_likelihood=mixed_fit.log_marginal,
        status=status,
        note=note,
        factors=tuple(study.conditions.columns),
        n_participants=n,
        interval=interval,
        means=all_means,
        covariance=covariance,
        width_group=width_group,
    )


def _open(study: StudyCounts, mixed_fit: MixedFit, rates: Mapping[int, float]) -> Iterator[str]:
    """What the answers leave open although the likelihood has a maximum."""
    low, high, _ = study.ranges()
    errors = np.sqrt(np.diagonal(mixed_fit.covariance)[: study.n_conditions])
    if np.any((high > low) & ~(errors <= high - low)):
        yield OPEN_MEAN
    if rates.get(LAPSE, 0.0) > HIGH_LAPSES:
        yield OPEN_LAPSES.format(rates[LAPSE])


def _maximum(model: ClusteredModel, at: Array) -> MixedFit:
    """From scales as they are, then smaller and larger ones, until one start converges."""
    n = len(model.basis)
    for factor in START_FACTORS:
        means, scales = at[: len(at) - n], at[len(at) - n :]
        mixed_fit = maximise(model, np.concatenate([means, factor * scales]))
        if _has_converged(mixed_fit):
            break
    return mixed_fit


def _has_converged(mixed_fit: MixedFit) -> bool:
    return bool(np.isfinite(mixed_fit.log_marginal) and mixed_fit.gradient <= LARGEST_GRADIENT)


def _means_of_all(
    alone: Alone, kept: StudyCounts, mixed_fit: MixedFit, inflation: float
) -> tuple[Array, Array, tuple[int, ...]]:
    """Means and covariance in the unit of the levels, with zeros for the conditions without a threshold."""
    study = alone.study
    group = np.zeros(study.n_conditions, dtype=np.int64)
    group[alone.with_threshold] = kept.width_group
    places = np.concatenate([alone.with_threshold, study.n_conditions + np.arange(kept.n_groups)])
    n, free = study.n_conditions + kept.n_groups, len(places)
    # Thresholds are stretched to the unit of the levels; logarithms of widths are shifted to it.
    is_threshold = np.arange(n) < study.n_conditions
    scale = np.where(is_threshold, study.spread, 1.0)
    offset = np.where(is_threshold, study.centre, np.log(study.spread))
    means, covariance = np.zeros(n), np.zeros((n, n))
    means[places] = mixed_fit.parameters[:free]
    covariance[np.ix_(places, places)] = inflation**2 * mixed_fit.covariance[:free, :free]
    return offset + scale * means, np.outer(scale, scale) * covariance, tuple(group.tolist())


def _without_model(alone: Alone, status: GroupStatus, interval: float) -> HierarchicalFit:
    """Statuses and bounds without a model."""
    n_conditions, n_participants = alone.study.n_conditions, alone.study.n_participants
    return replace(
        _no_data(tuple(alone.study.conditions.columns), interval),
        conditions=condition_table(alone, ParameterPlace.unknown(n_conditions), 0.0),
        participants=participant_table(alone, ParameterPlace.unknown(n_conditions, n_participants), 0.0),
        status=status,
        note=status.note,
        n_participants=n_participants,
    )


def _status(study: StudyCounts, model: ClusteredModel, mixed_fit: MixedFit) -> GroupStatus:
    if not _has_converged(mixed_fit):
        return GroupStatus.NOT_CONVERGED
    if study.n_participants == 1:
        return GroupStatus.ONE_PARTICIPANT
    scale = model.scale(model.parts(mixed_fit.parameters)[2])
    kept = 2 if study.width_varies else 1
    between = np.linalg.svd(scale[:kept, :kept], compute_uv=False)
    deviations = np.abs(np.diagonal(scale)[2:])
    smallest = min(between.min(), deviations.min(initial=np.inf))
    return GroupStatus.SINGULAR if smallest < ZERO_SD else GroupStatus.OK


def _components(
    study: StudyCounts, model: ClusteredModel, mixed_fit: MixedFit
) -> tuple[Mapping[str, float], float | None]:
    """Standard deviations in the unit of the levels (of logarithms for widths), and the correlation."""
    theta = model.parts(mixed_fit.parameters)[2]
    if not len(theta):
        return MappingProxyType({}), None
    covariance = model.scale(theta) @ model.scale(theta).T
    sd = np.sqrt(np.diagonal(covariance))
    kinds = [0, 1, *range(2, len(sd), study.n_conditions)]
    units = (study.spread, 1.0, study.spread, 1.0)
    sd_or_0 = np.where(sd > ZERO_SD, sd, 0.0)
    # Not strict: one condition has no deviations of cells, and one group of widths none of their widths.
    columns = zip(COMPONENTS, units, kinds, strict=False)
    named = {name: float(unit * sd_or_0[place]) for name, unit, place in columns}
    if not study.width_varies:
        named.pop("log_width")
    is_correlated = study.n_participants >= CORRELATED_FROM and min(sd[:2]) > ZERO_SD
    correlation = float(covariance[0, 1] / (sd[0] * sd[1])) if is_correlated else None
    return MappingProxyType(named), correlation


__all__ = ["Contrast", "FactorEffect", "GroupStatus", "HierarchicalFit", "fit_hierarchical"]
