"""Hierarchical fit of thresholds over participants and conditions.

Means and effects (`model`) are integrated out by Laplace's approximation. All other parameters are integrated by
importance sampling (`posterior`) at fixed quasi-random points, so the same answers yield the same result. Estimates of
participants with few or extreme answers shrink to the group mean. An out-of-range threshold is reported as a bound.

Priors are in units of the range of the levels (widths: its logarithm). Mean thresholds are normal about the middle of
their levels, mean log widths normal about half the range. Standard deviations are half-normal, the correlation is
LKJ(2), and lapse rates of participants are normal on the logit scale.
"""

from __future__ import annotations  # lets `help` show ArrayLike instead of its expansion

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any, Required, TypedDict, Unpack

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from tactometry.arguments.require import between, expect
from tactometry.psychometric import shape_named

from ..arrays import Array
from ..threshold.counts import count_arrays
from ..threshold.fitting import check_rates
from .model import GroupModel, StudyCounts, rate_of
from .posterior import N_POINTS, Integrated, Laplace, integrate
from .result import Contrast, FactorEffect, GroupStatus, HierarchicalFit
from .tables import (
    CONDITION_COLUMNS,
    Known,
    ParameterPlace,
    SingleFits,
    cell_place,
    condition_table,
    group_place,
    participant_table,
    single_fits,
)

ENOUGH_EFFECTIVE = 25.0
COARSE = "the integral over the variances has only {:.0f} effective points, so the intervals are approximate"
OPEN_MEAN = "the standard error of a condition's mean threshold exceeds the range of its levels"


class GroupOptions(TypedDict, total=False):
    """Options of `fit_hierarchical`: rates, shape and priors."""

    shape: Required[str]
    guess_rate: Required[float | None]
    lapse_rate: float | None
    lapse_beta: float
    guess_beta: float
    scale_free_width: bool


def fit_hierarchical(
    levels: ArrayLike,
    n_correct: ArrayLike,
    n_trials: ArrayLike,
    participants: Sequence[str],
    conditions: Mapping[str, Sequence[float | str]],
    *,
    width_by: Sequence[str] = (),
    interval: float = 0.95,
    n_false_alarms: ArrayLike = 0,
    n_catch: ArrayLike = 0,
    known: Known | None = None,
    n_points: int = N_POINTS,
    **options: Unpack[GroupOptions],
) -> HierarchicalFit:
    """Fit the psychometric functions of all participants jointly.

    Parameters
    ----------
    levels, n_correct, n_trials, participants : (n_rows,)
        One row per participant, condition and level. Rows without trials are ignored; cells may be missing.
    conditions : mapping of factor to (n_rows,)
        The values of each factor.
    shape, guess_rate, lapse_rate, lapse_beta, guess_beta, scale_free_width
        As for `threshold.fit`. A free lapse rate differs between participants, a free guess rate is shared.
        `scale_free_width` (on by default) applies to the fits of single cells, which determine the statuses.
    n_false_alarms, n_catch : int or (n_rows,)
        "Yes" answers to catch trials, and numbers of catch trials: one total for all participants, or (better) the
        numbers of each row's cell.
    width_by : sequence of str
        Factors on which the mean log width depends. By default all conditions share one mean.
    known : mapping of (participant, values of the factors) to ThresholdFit, optional
        Existing fits of single cells with the same options, which are reused. Not supported for the shape ``weibull``.
    n_points : int
        Points per round of the integral over the hyperparameters; the first round uses half as many.

    Raises
    ------
    InvalidParameter
        For a value that is not a number, an impossible count (the error names the row), or an unknown name.

    Examples
    --------
    >>> k, levels = [1, 4, 9, 10, 0, 2, 6, 10, 3, 6, 9, 10], [1, 2, 3, 4] * 3
    >>> result = fit_hierarchical(levels, k, 10, list("AAAABBBBCCCC"), {"force_n": [0.5] * 12}, shape="logistic",
    ...     guess_rate=0.0, lapse_rate=0.0)
    >>> result.n_participants, round(float(result.conditions["threshold"][0]), 1)
    (3, 2.2)
    """
    curve = shape_named(options["shape"])
    answers = tuple(rows[0] for rows in count_arrays(levels, n_correct, n_trials, logarithms=curve.on_log_levels))
    rates = options["guess_rate"], options.get("lapse_rate")
    _check({"participants": participants, **conditions}, answers[0].size, width_by, interval, rates)
    if not answers[2].any():
        return _no_data(tuple(conditions), interval)
    catch, of_study = (n_false_alarms, n_catch), {**options, "shape": curve}
    study = StudyCounts.of(participants, conditions, width_by, answers, catch, **of_study)
    return _fit(single_fits(study, options["shape"], known or {}), interval, n_points)


def _check(
    columns: Mapping[str, Sequence[object]],
    n_rows: int,
    width_by: Sequence[str],
    interval: float,
    rates: tuple[float | None, float | None],
) -> None:
    factors = list(columns)[1:]  # the first column is the participants
    for name in width_by:
        expect(name in factors, "width_by", repr(name), f"factors of {', '.join(factors)}")
    expect(len(factors) > 0, "conditions", "no factor", "at least one (with a single value if nothing was varied)")
    between("fit_hierarchical", 0, 1, interval=interval)
    check_rates("fit_hierarchical", *rates)
    for name, values in columns.items():
        expect(len(values) == n_rows, name, f"{len(values)} rows", f"{n_rows}, one for each level")


def _no_data(factors: tuple[str, ...], interval: float) -> HierarchicalFit:
    empty = pd.DataFrame({name: [] for name in (*factors, *CONDITION_COLUMNS)})
    return HierarchicalFit(conditions=empty, participants=empty, factors=factors, interval=interval)


def _fit(single: SingleFits, interval: float, n_points: int) -> HierarchicalFit:
    study, chosen = single.study, single.with_threshold
    kept, n = study.only(chosen), study.n_participants
    if not kept.n_conditions:
        return _without_model(single, GroupStatus.NO_THRESHOLD, interval)

    model = GroupModel(kept)
    hyper, means = model.start(*single.start())
    try:
        result = integrate(Laplace(model, hyper, means), hyper, n_points)
        of_group, (of_cells, rates) = group_place(model, result, interval), cell_place(model, result, interval)
    except np.linalg.LinAlgError:
        return _without_model(single, GroupStatus.NOT_CONVERGED, interval)

    status = GroupStatus.ONE_PARTICIPANT if n == 1 else GroupStatus.OK
    group = ParameterPlace.unknown(study.n_conditions).replaced(chosen, of_group)
    cells = ParameterPlace.unknown(study.n_conditions, n).replaced(chosen, of_cells)
    all_means, covariance, width_group = _means_of_all(single, model, result)
    return HierarchicalFit(
        conditions=condition_table(single, group),
        participants=participant_table(single, cells, rates),
        **_mean_hyperparameters(model, result),
        lapse_rate=float(rates.mean()),
        n_effective=result.n_effective,
        status=status,
        note="; ".join(filter(None, (status.note, *_open(kept, of_group, result.n_effective)))),
        factors=tuple(study.conditions.columns),
        n_participants=n,
        interval=interval,
        weights=result.weights,
        means=all_means,
        covariance=covariance,
        width_group=width_group,
    )


def _mean_hyperparameters(model: GroupModel, found: Integrated) -> dict[str, Any]:
    """Return posterior means of SDs, correlation and rates."""
    study, hyper = model.study, found.at.hyper
    sds = found.mean(np.exp(hyper[:, : len(model.sds)])).tolist()
    components = {
        name: sd * (study.spread if "threshold" in name else 1.0) for name, sd in zip(model.sds, sds, strict=True)
    }
    correlation, guess_rate = None, study.guess_rate
    if study.n_participants > 1:
        correlation = float(found.mean(np.tanh(model.at(hyper, "correlation"))))
    if guess_rate is None:
        guess_rate = float(found.mean(rate_of(model.at(hyper, "guess_rate"))[0]))
    return {"components": MappingProxyType(components), "correlation": correlation, "guess_rate": guess_rate}


def _open(study: StudyCounts, group: ParameterPlace, n_effective: float) -> Iterator[str]:
    """Yield notes about parameters that the responses do not determine."""
    low, high, _ = study.ranges()
    if np.any((high > low) & ~(group.se[:, 0] <= high - low)):
        yield OPEN_MEAN
    if n_effective < ENOUGH_EFFECTIVE:
        yield COARSE.format(n_effective)


def _means_of_all(single: SingleFits, model: GroupModel, found: Integrated) -> tuple[Array, Array, tuple[int, ...]]:
    """Return the means and their covariances in the unit of the levels."""
    study, kept, n_points = single.study, model.study, len(found.weights)
    group = np.zeros(study.n_conditions, dtype=np.int64)
    group[single.with_threshold] = kept.width_group
    places = np.concatenate([single.with_threshold, study.n_conditions + np.arange(kept.n_groups)])
    n = study.n_conditions + kept.n_groups
    # Convert to the unit of the levels: scale thresholds, shift logarithms of widths.
    is_threshold = np.arange(n) < study.n_conditions
    scale = np.where(is_threshold, study.spread, 1.0)
    offset = np.where(is_threshold, study.centre, np.log(study.spread))
    means, covariance = np.zeros((n_points, n)), np.zeros((n_points, n, n))
    means[:, places] = model.every_mean(found.at.hyper, found.at.means)
    free = places[: found.at.means.shape[1]]
    covariance[:, free[:, None], free] = found.at.covariance
    return offset + scale * means, np.outer(scale, scale) * covariance, tuple(group.tolist())


def _without_model(single: SingleFits, status: GroupStatus, interval: float) -> HierarchicalFit:
    """Return a result that contains only statuses and bounds."""
    n_conditions, n_participants = single.study.n_conditions, single.study.n_participants
    return replace(
        _no_data(tuple(single.study.conditions.columns), interval),
        conditions=condition_table(single, ParameterPlace.unknown(n_conditions)),
        participants=participant_table(single, ParameterPlace.unknown(n_conditions, n_participants), None),
        status=status,
        note=status.note,
        n_participants=n_participants,
    )


__all__ = ["Contrast", "FactorEffect", "GroupStatus", "HierarchicalFit", "fit_hierarchical"]
