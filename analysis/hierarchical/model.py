"""The mixed model of thresholds behind `hierarchical`: cells of participants by conditions, each with a threshold and a
log width of its own, on the scale of the whole study's levels."""

from collections.abc import Callable

import numpy as np

from ..arrays import Array, Expansion
from ..mixed_models.laplace import ClusteredModel
from ..threshold.counts import Counts
from ..threshold.likelihood import GUESS, LAPSE, LOG_WIDTH, N_PARAMETERS, THRESHOLD, chance_information, expansion
from ..threshold.prior import LARGEST_RATE, log_rate, log_threshold, log_width
from .study import StudyCounts

START_SD = (0.1, 0.2, 0.05, 0.1)
"""Standard deviations at the start: threshold (in ranges of the levels), log width, and their cells' deviations."""
CORRELATED_FROM = 5
"""Participants from which the correlation of threshold and width is estimated."""
START_RATE = 0.03


def rate_of(angle: Array) -> tuple[Array, Array, Array]:
    """A rate in [0, 0.5] by an angle without bounds, and its two derivatives: even about 0, as a scale's is."""
    half = LARGEST_RATE / 2
    rate = half * (1 - np.cos(2 * angle))
    slope, bent = 2 * half * np.sin(2 * angle), 4 * half * np.cos(2 * angle)
    return rate, slope, bent


def angle_rad(probability: float) -> float:
    """The angle of a rate."""
    return float(np.arcsin(np.sqrt(probability / LARGEST_RATE)))


def mixed_model(study: StudyCounts) -> ClusteredModel:
    """Threshold of participant p in condition c: mean of c + effect of p + deviation of the cell; the log width:
    mean of its group + effect of p (+ deviation of the cell where there are several groups)."""
    several = study.n_participants > 1 and study.n_conditions > 1
    varied = study.n_groups > 1 and study.width_varies
    n, c = study.n_participants, study.n_conditions
    present = (study.n_trials.sum(axis=2) > 0)[:, :, None, None]  # a missing cell is an unused slot, with X = Z = 0
    fixed = np.zeros((n, c, 2, c + study.n_groups))
    fixed[:, :, 0, :c] = np.eye(c)
    fixed[:, :, 1, c:] = np.eye(study.n_groups)[study.width_group]
    columns = [np.broadcast_to(np.eye(2), (n, c, 2, 2))]
    for place in range(several * (1 + varied)):
        deviations = np.zeros((n, c, 2, c))
        deviations[:, :, place] = np.eye(c)
        columns.append(deviations)
    random = np.concatenate(columns, axis=3) * present
    basis, prior = _basis(study, random.shape[3]), _prior(study)
    log_likelihood, information = _answers(study)
    return ClusteredModel(log_likelihood, fixed * present, random, basis, len(study.shared), prior, information)


def _basis(study: StudyCounts, size: int) -> Array:
    """Of Lambda: lower triangle of threshold and width (without their correlation for few participants), then a
    multiple of the unit matrix for each kind of deviation."""
    if study.n_participants == 1:
        return np.zeros((0, size, size))
    places = [(0, 0), (1, 0), (1, 1)] if study.n_participants >= CORRELATED_FROM else [(0, 0), (1, 1)]
    places = places if study.width_varies else [(0, 0)]
    basis = np.zeros((len(places), size, size))
    for matrix, place in zip(basis, places, strict=True):
        matrix[place] = 1.0
    kinds = (np.arange(size) - 2) // study.n_conditions  # after threshold and width a block for each kind of deviation
    blocks = [np.diag((kinds == kind).astype(float)) for kind in range(kinds[-1] + 1)]
    return np.concatenate([basis, np.reshape(blocks, (-1, size, size))])


def start_scales(model: ClusteredModel) -> Array:
    """theta at the start."""
    diagonals = np.diagonal(model.basis, axis1=1, axis2=2)
    n_deviations, n_conditions = model.basis.shape[1] - 2, max(1, model.fixed.shape[1])
    kinds = [0, 1, *(2 + k // n_conditions for k in range(n_deviations))]
    # A scale beside the diagonal is a covariance, which begins at 0.
    return np.array([START_SD[kinds[diagonal.argmax()]] if diagonal.any() else 0.0 for diagonal in diagonals])


def _answers(study: StudyCounts) -> tuple[Callable[[Array], Expansion], Callable[[Array], Array]]:
    """Log-likelihood with derivatives, and Fisher's information, of all cells at their threshold, log width and angles
    of rates."""
    n_units, kept = study.n_participants * study.n_conditions, [THRESHOLD, LOG_WIDTH, *study.shared]
    u, k, n = (counts.reshape(n_units, -1) for counts in (study.u, study.n_yes, study.n_trials))
    nothing, n_levels = np.zeros(n_units), np.zeros(n_units, dtype=np.int64)
    counts = Counts(u, k, n, nothing, nothing, nothing, n_levels).by_level()

    def theta_at(points: Array) -> Array:
        theta = np.empty((n_units, N_PARAMETERS))
        theta[:, LAPSE], theta[:, GUESS] = study.lapse_rate or 0.0, study.guess_rate or 0.0
        theta[:, kept] = points.reshape(n_units, -1)
        theta[:, study.shared] = rate_of(theta[:, study.shared])[0]
        return theta

    def log_likelihood(points: Array) -> Expansion:
        whole, angles = expansion(study.shape, counts, theta_at(points)), points.reshape(n_units, -1)
        gradient, hessian = whole.gradient[:, kept], whole.hessian[:, kept][:, :, kept]
        for place in range(2, len(kept)):
            _, slope, bent = rate_of(angles[:, place])
            hessian[:, place] *= slope[:, None]
            hessian[:, :, place] *= slope[:, None]
            hessian[:, place, place] += gradient[:, place] * bent  # still the gradient along the rate itself
            gradient[:, place] *= slope
        value = whole.value.reshape(points.shape[:2])
        return Expansion(value, gradient.reshape(points.shape), hessian.reshape(*points.shape, len(kept)))

    def information(points: Array) -> Array:
        # Unlike the observed it is never negative, which keeps the determinant of Laplace's approximation away from 0.
        return chance_information(study.shape, counts, theta_at(points)).reshape(*points.shape[:2], 2, 2)

    return log_likelihood, information


def _prior(study: StudyCounts) -> Callable[[Array], tuple[float, Array]]:
    """psignifit's priors, on the means of the conditions and the shared rates; the width's is flat in its logarithm."""
    low, high, gap = study.ranges()
    reach = np.where(high > low, high - low, 1.0)
    groups = range(study.n_groups)
    wide = np.array([reach[study.width_group == g].max() for g in groups])
    narrow = np.array([gap[study.width_group == g].min() for g in groups]) / wide
    answers = {
        LAPSE: (0, 0, study.lapse_beta),
        GUESS: (study.n_false_alarms, study.n_catch - study.n_false_alarms, study.guess_beta),
    }

    def log_prior(parameters: Array) -> tuple[float, Array]:
        m, v, angles = np.split(parameters, [study.n_conditions, study.n_conditions + study.n_groups])
        with np.errstate(all="ignore"):
            at_m, by_m, _ = log_threshold((m - low) / reach - 0.5)
            at_v, by_v, _ = log_width(v - np.log(wide), narrow, scale_free=True)
        at_v, by_v = at_v + v, by_v + 1.0  # a density of the log width, flat in it
        total = float(at_m.sum() + at_v.sum())
        slopes = [by_m / reach, by_v]
        for angle, place in zip(angles, study.shared, strict=True):
            rate, slope, _ = rate_of(angle)
            n_yes, n_no, beta = (np.array(float(n)) for n in answers[place])
            value, by_rate, _ = log_rate(rate, n_yes, n_no, float(beta))
            total += float(value)
            slopes.append(np.atleast_1d(by_rate * slope))
        return total, np.concatenate(slopes)

    return log_prior


def start(study: StudyCounts, model: ClusteredModel, thresholds: Array, log_widths: Array) -> Array:
    """Parameters (n_parameters,) from a threshold and a log width of each condition."""
    low, high, gap = study.ranges()
    reach = 0.2 * (high - low)
    inside = np.clip(thresholds, low - reach, high + reach)
    wide = np.maximum(log_widths, np.log(1.5 * gap))  # off the smallest spacing, where the width's prior ends
    groups = [wide[study.width_group == g].mean() for g in range(study.n_groups)]
    angles = [angle_rad(START_RATE)] * len(study.shared)
    return np.concatenate([inside, groups, angles, start_scales(model)])
