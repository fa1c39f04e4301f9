"""Beta-binomial answers: the chance of a level varies from block to block (Schuett et al. 2016).

eta in [0, 1) is the overdispersion: nu = 1/eta^2 - 1, and the chance of a block is drawn from
Beta(nu psi, nu (1 - psi)); the variance of k is n psi (1 - psi) (1 + (n - 1) eta^2). eta = 0 is the binomial.
Its prior is Beta(1, 10).
"""

import numpy as np
from scipy.special import gammaln, polygamma, psi

from tactometry.psychometric import Shape

from ..arrays import Array, Expansion
from .counts import Counts
from .likelihood import curvature_of_chances
from .prior import BETA_B

BINOMIAL_BELOW = 1e-4
"""Below this the beta-binomial differs from the binomial by less than its own rounding."""
LARGEST = 0.99
SMALLEST_CHANCE = 1e-100


def log_prior_of(eta: Array | float) -> Array:
    """Beta(1, 10) without its constant."""
    return np.asarray((BETA_B - 1) * np.log1p(-eta))


def log_weight(p: Array, q: Array, k: Array | float, n: Array | float, eta: float) -> Array:
    """Log chance of one order of k yes in n answers at the mean chance p = 1 - q, elementwise.

    >>> from scipy.special import binom
    >>> round(float(binom(20, 15) * np.exp(log_weight(np.array(0.75), np.array(0.25), 15, 20, 0.2))), 9)
    0.148414569
    """
    if eta < BINOMIAL_BELOW:
        return np.asarray(k * np.log(p) + (n - k) * np.log(q))
    nu = np.asarray(1 / eta**2 - 1)
    a, b = nu * np.maximum(p, SMALLEST_CHANCE), nu * np.maximum(q, SMALLEST_CHANCE)
    return _log_beta_ratio(k, n, a, b, nu)


def _log_beta_ratio(k: Array | float, n: Array | float, a: Array, b: Array, nu: Array) -> Array:
    """The logarithm of B(k + a, n - k + b) / B(a, b), where nu = a + b."""
    yes = gammaln(k + a) - gammaln(a)
    return np.asarray(yes + gammaln(n - k + b) - gammaln(b) + gammaln(nu) - gammaln(n + nu))


def overdispersed_expansion(shape: Shape, counts: Counts, theta: Array, eta: Array) -> Expansion:
    """The log-likelihood at eta (n_sets,), with gradient and Hessian along (threshold, log width, lapse,
    guess)."""
    p, q, by, by_by = curvature_of_chances(shape, counts.u, theta)
    k, n = counts.n_yes, counts.n_trials
    nu = (1 / np.square(eta) - 1)[:, None]
    a, b = nu * np.maximum(p, SMALLEST_CHANCE), nu * np.maximum(q, SMALLEST_CHANCE)
    value = _log_beta_ratio(k, n, a, b, nu)
    # Along psi of each level, where a rises and b falls; then the chain rule from psi to the parameters.
    first = nu * (psi(k + a) - psi(a) - psi(n - k + b) + psi(b))
    second = nu**2 * sum(
        np.where(count > 0, polygamma(1, count + x) - polygamma(1, x), 0.0) for count, x in ((k, a), (n - k, b))
    )
    gradient = np.einsum("nl,nli->ni", first, by)
    steep = np.einsum("nl,nli,nlj->nij", second, by, by)
    bent = np.einsum("nl,nlij->nij", first, by_by)
    return Expansion(value.sum(axis=1), gradient, steep + bent)
