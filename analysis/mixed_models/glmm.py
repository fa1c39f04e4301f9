"""Generalised linear mixed models of answers with probit or logit link, by maximum likelihood.

eta = X beta + Z u with u ~ N(0, Sigma) for each participant, and psi = g + (1 - g - l) F(eta). Laplace's approximation
or adaptive Gauss-Hermite quadrature, as lme4's glmer (Bates, Maechler, Bolker and Walker 2015, Journal of Statistical
Software 67(1); there g = l = 0). In `hierarchical` the threshold and the width have effects of their own instead.
"""

from __future__ import annotations  # so that `help` says ArrayLike, and not what it stands for

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tactometry.arguments.require import expect, lookup
from tactometry.errors import nearest
from tactometry.psychometric import SHAPES, Shape

from ..arrays import Array, Expansion, Indices
from ..noted_status import NotedStatus
from ..threshold.chances import by_point, expected_information
from ..threshold.counts import count_arrays
from .laplace import ClusteredModel, MixedFit, maximise, maximise_by_quadrature

LINKS = MappingProxyType({"probit": "normal", "logit": "logistic"})
START_SD = 0.5
ZERO_SD = 1e-3
"""A random effect of a smaller standard deviation (its column scaled to a root mean square of 1) is none."""
WIDEST_SE = 10.0
"""A fixed effect of a larger standard error, on that scale, has no maximum."""
LARGEST_GRADIENT = 1e-3


class MixedStatus(NotedStatus):
    OK = "ok", ""
    SINGULAR = "singular", "the random effects have no variance, or one of them follows from the others"
    ONE_PARTICIPANT = "one_participant", "one participant: nothing can be said of the variance between participants"
    SEPARATED = "separated", "a fixed effect has no finite maximum: the answers do not vary enough"
    NO_DATA = "no_data", "no trial was given"
    NOT_CONVERGED = "not_converged", "the likelihood still rises"


@dataclass(frozen=True)
class MixedEstimate:
    """What a mixed model says; None where the data do not tell.

    `effects`, `standard_errors` by name of the fixed effect, `covariance` of the fixed effects in that order;
    `sd` and `correlation` (n_random, n_random) of the random effects; `participants` maps each participant to its
    random effects (conditional modes). `log_likelihood` is without the binomial coefficients.
    """

    status: MixedStatus
    effects: Mapping[str, float] | None = None
    standard_errors: Mapping[str, float] | None = None
    covariance: Array | None = None
    sd: Mapping[str, float] | None = None
    correlation: Array | None = None
    participants: Mapping[str, Array] = field(default_factory=dict)
    log_likelihood: float | None = None

    @property
    def note(self) -> str:
        return self.status.note


def fit_glmm(
    n_yes: ArrayLike,
    n_trials: ArrayLike,
    participants: Sequence[str],
    *,
    fixed: Mapping[str, ArrayLike],
    random: Sequence[str],
    link: str = "probit",
    guess_rate: float = 0.0,
    lapse_rate: float = 0.0,
    n_nodes: int = 1,
    expected: bool = False,
    correlated: bool = True,
) -> MixedEstimate:
    """Fit a mixed model to counts of answers, one row a participant and level.

    Parameters
    ----------
    n_yes, n_trials, participants : (n_rows,)
        Rows without trials are ignored.
    fixed : mapping of name to (n_rows,) array_like or number
        The columns of X.
    random : sequence of str
        The names of those that vary between participants (the columns of Z).
    link : str
        ``probit`` or ``logit``.
    guess_rate, lapse_rate : float
        Known asymptotes.
    n_nodes : int
        1 for Laplace's approximation, more for adaptive Gauss-Hermite quadrature with so many nodes along each of
        one or two random effects.
    expected : bool
        Whether Laplace's approximation takes the expected information instead of the observed. lme4 does; with the
        probit link the observed is nearer to the quadrature.
    correlated : bool
        Whether the random effects have correlations of their own, or none (lme4's ``||``), which few participants tell
        more easily.

    Raises
    ------
    InvalidParameter
        For impossible counts (naming the row), unknown names, or columns that depend on each other.

    Examples
    --------
    >>> x, participants = np.tile([-1.0, 0.0, 1.0, 2.0], 3), np.repeat(["A", "B", "C"], 4)
    >>> found = fit_glmm([1, 6, 9, 10, 3, 7, 10, 10, 0, 4, 7, 9], 10, participants,
    ...     fixed={"intercept": 1.0, "level": x}, random=("intercept",))
    >>> found.status.value, round(found.effects["level"], 3), round(found.sd["intercept"], 3)
    ('ok', 1.132, 0.443)
    """
    shape = lookup("link", link, LINKS)
    _check_random(fixed, random, n_nodes)
    names = np.asarray([str(name) for name in participants])
    x, k, n = count_arrays(np.zeros(len(names)), n_yes, n_trials)
    used = n[0] > 0
    if not used.any():
        return MixedEstimate(MixedStatus.NO_DATA)
    columns = {name: np.broadcast_to(np.asarray(column, float), x.shape[1:])[used] for name, column in fixed.items()}
    answers = (k[0, used], (n - k)[0, used])
    design = _Design.of(columns, random, names[used], answers, correlated=correlated)
    return design.fit(SHAPES[shape], (guess_rate, lapse_rate), n_nodes, expected=expected)


def _check_random(fixed: Mapping[str, ArrayLike], random: Sequence[str], n_nodes: int) -> None:
    for name in random:
        expect(name in fixed, "random", repr(name), f"names of fixed effects{nearest(name, list(fixed))}")
    holds = n_nodes == 1 or (n_nodes > 1 and len(random) <= 2)
    found = f"{n_nodes} with {len(random)} random effects"
    expect(holds, "n_nodes", found, "1 or more, and above 1 at most two effects")


@dataclass(frozen=True)
class _Design:
    """Columns scaled to a root mean square of 1, laid out as clusters by slots."""

    names: tuple[str, ...]
    random: tuple[str, ...]
    scale: Array
    fixed: Array
    answers: tuple[Array, Array]
    participants: tuple[str, ...]
    correlated: bool

    @classmethod
    def of(
        cls,
        columns: Mapping[str, Array],
        random: Sequence[str],
        participants: NDArray[np.str_],
        answers: tuple[Array, Array],
        *,
        correlated: bool,
    ) -> _Design:
        matrix = np.stack(list(columns.values()), axis=1)
        found = f"columns ({', '.join(columns)}) that depend on each other over the rows with trials"
        holds = np.linalg.matrix_rank(matrix) == matrix.shape[1]
        expect(holds, "fixed", found, "independent ones; leave one out")
        scale = np.sqrt(np.square(matrix).mean(axis=0))
        who, cluster = np.unique(participants, return_inverse=True)
        # Columns of like size: one START_SD and one tolerance serve effects of any unit.
        laid = lay_out(cluster, matrix / scale, *answers)
        names = tuple(str(one) for one in who)
        return cls(tuple(columns), tuple(random), scale, laid[0], (laid[1], laid[2]), names, correlated)

    def fit(self, shape: Shape, asymptotes: tuple[float, float], n_nodes: int, *, expected: bool) -> MixedEstimate:
        model = self._model(shape, asymptotes, expected=expected)
        is_on_diagonal = model.basis.trace(axis1=1, axis2=2) > 0
        # Without correlations, but not at variances of 0, where the gradient along a scale vanishes.
        start = np.concatenate([np.zeros(len(self.names)), START_SD * is_on_diagonal])
        mixed_fit = maximise(model, start)
        if n_nodes > 1 and len(model.basis):
            mixed_fit = maximise_by_quadrature(model, mixed_fit, n_nodes)
        return self._estimate(model, mixed_fit)

    def _model(self, shape: Shape, asymptotes: tuple[float, float], *, expected: bool) -> ClusteredModel:
        places = [self.names.index(name) for name in self.random]
        guess, lapse = (np.array([rate]) for rate in asymptotes)
        yes, no = (count[..., None] for count in self.answers)

        def log_likelihood(points: Array) -> Expansion:
            by = by_point(shape, points, guess, lapse, (yes, no))
            return Expansion(by.value[..., 0], by.z, by.zz[..., None])

        def information(points: Array) -> Array:
            return expected_information(shape, points, guess, lapse, yes + no)[..., None]

        fixed = self.fixed[:, :, None, :]
        # One participant has no variance between participants: no scale is looked for.
        n_varied = len(places) if len(self.participants) > 1 else 0
        basis = triangular_basis(n_varied, len(places))
        if not self.correlated:
            basis = basis[basis.trace(axis1=1, axis2=2) > 0]
        return ClusteredModel(
            log_likelihood, fixed, fixed[..., places], basis, information=information if expected else None
        )

    def _estimate(self, model: ClusteredModel, mixed_fit: MixedFit) -> MixedEstimate:
        beta, _, theta = model.parts(mixed_fit.parameters)
        covariance, n = mixed_fit.covariance[: len(beta), : len(beta)], len(self.random)
        status = self._status(model, mixed_fit, covariance)
        if status in (MixedStatus.SEPARATED, MixedStatus.NOT_CONVERGED):
            return MixedEstimate(status)
        random_scale = self.scale[[self.names.index(name) for name in self.random]]
        modes = mixed_fit.inner.effects @ model.scale(theta).T / random_scale
        sigma = model.scale(theta) @ model.scale(theta).T
        has_sd = len(theta) > 0
        sd = np.sqrt(np.diagonal(sigma)) if has_sd else np.full(n, np.nan)
        with np.errstate(divide="ignore", invalid="ignore"):
            correlation = sigma / np.outer(sd, sd)
        standard_errors = np.sqrt(np.diagonal(covariance)) / self.scale
        by_effect = dict(zip(self.random, (sd / random_scale).tolist(), strict=True))
        has_correlation = has_sd and (sd > ZERO_SD).all()
        return MixedEstimate(
            status,
            self._named(beta / self.scale),
            self._named(standard_errors),
            covariance / np.outer(self.scale, self.scale),
            by_effect if has_sd else None,
            correlation if has_correlation else None,
            MappingProxyType(dict(zip(self.participants, modes, strict=True))),
            mixed_fit.log_marginal,
        )

    def _status(self, model: ClusteredModel, mixed_fit: MixedFit, covariance: Array) -> MixedStatus:
        theta = model.parts(mixed_fit.parameters)[2]
        if not np.isfinite(covariance).all() or np.diagonal(covariance).max() > WIDEST_SE**2:
            return MixedStatus.SEPARATED
        if mixed_fit.gradient > LARGEST_GRADIENT * max(1.0, abs(mixed_fit.log_marginal)):
            return MixedStatus.NOT_CONVERGED
        if len(self.participants) == 1:
            return MixedStatus.ONE_PARTICIPANT
        scales = np.linalg.svd(model.scale(theta), compute_uv=False)
        is_singular = len(theta) > 0 and scales.min() < ZERO_SD
        return MixedStatus.SINGULAR if is_singular else MixedStatus.OK

    def _named(self, values: Array) -> Mapping[str, float]:
        return MappingProxyType(dict(zip(self.names, values.tolist(), strict=True)))


def lay_out(cluster: Indices, *columns: Array, n_clusters: int = 0) -> list[Array]:
    """Rows (n_rows, ...) laid out as (n_clusters, n_slots, ...), with zeros in the slots that are not used; clusters
    that no row names are empty, up to the largest named or `n_clusters`."""
    order = np.argsort(cluster, kind="stable")  # stable: the slots of a cluster keep the order of its rows
    sizes = np.bincount(cluster, minlength=n_clusters)
    slot = np.arange(len(cluster)) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    laid = []
    for column in columns:
        whole = np.zeros((len(sizes), sizes.max(), *column.shape[1:]))
        whole[cluster[order], slot] = column[order]
        laid.append(whole)
    return laid


def triangular_basis(n: int, size: int) -> Array:
    """Matrices (n (n + 1) / 2, size, size), each with a 1 in the lower triangle of the first n rows: any Cholesky
    factor is a sum of them."""
    basis = np.zeros((n * (n + 1) // 2, size, size))
    for place, (i, j) in enumerate(zip(*np.tril_indices(n), strict=True)):
        basis[place, i, j] = 1.0
    return basis
