"""The effects of a within-participant design as orthonormal contrasts: sums of squares, sphericity, permutations.

Each participant's values become scores Z of shape (participant, contrast); everything that an analysis of variance
says of an effect is a function of them (science 10.1; Winer, Brown and Michels 1991, chapter 7).
"""

from dataclasses import dataclass
from itertools import combinations, product

import numpy as np

from tactometry.errors import InvalidParameter

from ..arrays import Array
from ..distributions import ChiSquare, Fisher
from .design import WithinDesign

MOST_EXACT = 14
"""Up to so many participants every change of signs is tried."""
RANK_TOLERANCE = 1e-12


@dataclass(frozen=True)
class Sphericity:
    """How far the contrasts are from equal variances and no correlation.

    `w`, `p`: Mauchly's test (None where the error matrix is singular or there is one contrast); `greenhouse_geisser`,
    `huynh_feldt` and `chi_muller` are epsilons from 1/df to 1; `singular`: fewer participants than the contrasts need.
    """

    w: float | None
    p: float | None
    greenhouse_geisser: float
    huynh_feldt: float
    chi_muller: float
    singular: bool


@dataclass(frozen=True)
class Tested:
    """Sums of squares of an effect and its error, with degrees of freedom and the shape of the errors."""

    name: str
    ss: float
    ss_error: float
    df: tuple[int, float]
    sphericity: Sphericity

    @property
    def has_error(self) -> bool:
        """Without, all participants show exactly the same differences and F is undefined."""
        return self.ss_error > 0

    @property
    def f(self) -> float:
        first, second = self.df
        return self.ss / first / (self.ss_error / second) if self.has_error else np.nan

    def p(self, epsilon: float = 1.0) -> float:
        """Chance of such an F or a larger one; both degrees of freedom are multiplied by epsilon."""
        first, second = self.df
        return float(Fisher.sf(self.f, epsilon * first, epsilon * second))


@dataclass(frozen=True)
class ContrastEffect(Tested):
    """An effect of its factors with the scores of all participants, shape (participant, contrast)."""

    factors: tuple[str, ...]
    scores: Array

    @classmethod
    def of(cls, factors: tuple[str, ...], scores: Array, n_conditions: int) -> "ContrastEffect":
        """From the scores, in a design of `n_conditions` cells."""
        n, p = scores.shape
        errors = scores - scores.mean(axis=0)
        ss = n * float(np.sum(scores.mean(axis=0) ** 2))
        shape = sphericity(errors.T @ errors / (n - 1), n - 1, n_conditions)
        df = (p, p * (n - 1))
        return cls(" * ".join(factors), ss, float(np.sum(errors**2)), df, shape, factors, scores)


def effects(design: WithinDesign) -> list[ContrastEffect]:
    """Main effects first, then the interactions.

    >>> values = np.array([[1.0, 2, 4], [2, 2, 5], [1, 3, 3]])
    >>> (found,) = effects(WithinDesign(values, ("force_n",), ((0.5, 1, 2),), ("a", "b", "c")))
    >>> found.name, found.df, round(found.f, 3)
    ('force_n', (2, 4), 8.909)
    """
    return [_effect(design, places) for places in effect_places(len(design.factors))]


def effect_places(n_factors: int) -> list[tuple[int, ...]]:
    """The factors of each effect by their places: main effects first, then the interactions.

    >>> effect_places(2)
    [(0,), (1,), (0, 1)]
    """
    return [places for r in range(1, n_factors + 1) for places in combinations(range(n_factors), r)]


def _effect(design: WithinDesign, places: tuple[int, ...]) -> ContrastEffect:
    scores = design.cells @ contrasts(design.values.shape[1:], places).T
    mean = scores.mean(axis=0)
    if np.abs(scores - mean).max() <= design.rounding:
        scores = np.broadcast_to(mean, scores.shape)  # an error of rounding alone is 0, and F undefined, not huge
    return ContrastEffect.of(tuple(design.factors[place] for place in places), scores, design.cells.shape[1])


def participant_scores(design: WithinDesign) -> Array:
    """One score per participant, whose sum of squares about the mean is that of the participants."""
    scores: Array = design.cells.sum(axis=1) / np.sqrt(design.cells.shape[1])
    return scores


def contrasts(n_levels: tuple[int, ...], places: tuple[int, ...]) -> Array:
    """Orthonormal rows, shape (contrast, cell): Helmert's along the factors at `places`, the mean along the others."""
    from scipy.linalg import helmert  # slow to load

    whole = np.ones((1, 1))
    for place, k in enumerate(n_levels):
        along = helmert(k) if place in places else np.full((1, k), k**-0.5)
        whole = np.asarray(np.kron(whole, along), dtype=np.float64)
    return whole


def sphericity(covariance: Array, df: int, n_conditions: int) -> Sphericity:
    """Epsilons and Mauchly's test of the covariance (contrast, contrast) of orthonormal contrasts with `df` degrees of
    freedom. The p-value has the term of second order as R and pingouin have it, with the number of all conditions
    (Anderson 2003, 10.7, has that of the contrasts)."""
    p, shape = len(covariance), epsilons(covariance, df)
    if p == 1:
        return Sphericity(None, None, *shape, singular=False)
    eigenvalues = np.linalg.eigvalsh(covariance)
    if df < p or eigenvalues[0] <= RANK_TOLERANCE * eigenvalues[-1]:
        return Sphericity(None, None, *shape, singular=True)
    log_w = float(np.sum(np.log(eigenvalues))) - p * np.log(float(eigenvalues.sum()) / p)
    mauchly_p = _mauchly_p(log_w, p, df, n_conditions)
    return Sphericity(float(np.exp(log_w)), mauchly_p, *shape, singular=False)


def epsilons(covariance: Array, df: float) -> tuple[float, float, float]:
    """Greenhouse and Geisser's, Huynh and Feldt's, and Chi and Muller's epsilon of the covariance (contrast, contrast)
    of orthonormal contrasts, estimated with `df` degrees of freedom.

    Huynh and Feldt's as Lecoutre corrected it for groups (1991, Journal of Educational Statistics 16, 371-372): it
    comes close to 5 % of false alarms where the contrasts are spherical, and passes it where they are not. Chi and
    Muller shrink it by what few degrees of freedom leave uncertain (Chi, Gribbin, Lamers, Gregory and Muller 2012,
    Statistics in Medicine 31, 724-742); with very few that falls below Greenhouse and Geisser's, which is conservative
    itself: it is the least here.
    """
    p = len(covariance)
    squares = p * float(np.sum(covariance**2))
    greenhouse_geisser = float(np.trace(covariance)) ** 2 / squares if squares > 0 else 1.0
    room = p * (df - p * greenhouse_geisser)
    wide = ((df + 1) * p * greenhouse_geisser - 2) / room if room > 0 else np.inf  # infinite: cut to 1 below
    n_moments = (df - 1) + df * (df - 1) / 2
    kept = (n_moments - 2) * (n_moments - 4) / n_moments**2 if n_moments > 4 else 0.0
    huynh_feldt = min(1.0, max(wide, greenhouse_geisser))
    chi_muller = min(1.0, max(wide * kept, greenhouse_geisser)) if kept else greenhouse_geisser
    return greenhouse_geisser, huynh_feldt, chi_muller


def _mauchly_p(log_w: float, p: int, df: int, n_conditions: int) -> float:
    factor = 1 - (2 * p**2 + p + 2) / (6 * p * df)
    polynomial = (p + 2) * (p - 1) * (p - 2) * (2 * p**3 + 6 * p**2 + 3 * n_conditions + 2)
    second = polynomial / (288 * (df * p * factor) ** 2)
    statistic, df_chi2 = -df * factor * log_w, p * (p + 1) // 2 - 1
    first, later = float(ChiSquare.sf(statistic, df_chi2)), float(ChiSquare.sf(statistic, df_chi2 + 4))
    return first + second * (later - first)


def permutation_p(effect: ContrastEffect, *, rng: np.random.Generator | None = None, n_resamples: int = 9_999) -> float:
    """The chance of an effect as large or larger if each participant's contrasts could as well have the other sign.

    Exact for symmetric errors, whatever the sphericity and the rank of the error matrix; the sum of squares of effect
    and error together does not change with the signs, so that the effect's own orders them as F does. Up to
    `MOST_EXACT` participants all signs are tried and `rng` is not used.

    >>> effect = ContrastEffect.of(("force_n",), np.array([[1.0], [2.0], [3.0], [4.0]]), n_conditions=2)
    >>> permutation_p(effect)
    0.125
    """
    n = len(effect.scores)
    exact = n <= MOST_EXACT
    if exact:
        # The first sign stays: turning all signs changes no square, and half of the cases need no look.
        signs = np.array(list(product((1.0,), *[(1.0, -1.0)] * (n - 1))))
    elif rng is None:
        raise InvalidParameter(f"rng: found none for {n} participants, expected a Generator to draw signs with")
    else:
        signs = rng.choice([-1.0, 1.0], size=(n_resamples, n))
    sums = np.sum((signs @ effect.scores) ** 2, axis=1)
    observed = float(np.sum(effect.scores.sum(axis=0) ** 2))
    # What is equal but for rounding is as large.
    n_as_large = int(np.sum(sums >= observed * (1 - 1e-12)))
    # Drawn signs leave the answers' own out, which are as large as themselves: with them p is never 0.
    return n_as_large / len(signs) if exact else (n_as_large + 1) / (n_resamples + 1)
