"""Effects of within-participant designs as scores on contrasts.

The scores have the shape (participant, contrast). They provide what pingouin and statsmodels lack: Chi and Muller's
epsilon, exact permutation tests, and designs with three factors (Winer, Brown and Michels 1991, chapter 7).
"""

from dataclasses import dataclass
from itertools import combinations, product

import numpy as np

from tactometry.errors import InvalidParameter

from ..arrays import Array
from .design import WithinDesign

MOST_EXACT = 14
"""Largest number of participants for which all sign changes are enumerated."""
RANK_TOLERANCE = 1e-12


@dataclass(frozen=True)
class ContrastEffect:
    """Main effect or interaction, with scores (participant, contrast)."""

    factors: tuple[str, ...]
    scores: Array

    @property
    def name(self) -> str:
        return " * ".join(self.factors)

    @property
    def df(self) -> tuple[int, int]:
        n, n_contrasts = self.scores.shape
        return n_contrasts, n_contrasts * (n - 1)

    @property
    def f(self) -> float:
        """F statistic, NaN if the error is 0."""
        ss = len(self.scores) * float(np.sum(self.scores.mean(axis=0) ** 2))
        return ss / self.df[0] / (self.ss_error / self.df[1]) if self.ss_error > 0 else np.nan

    @property
    def ss_error(self) -> float:
        return float(np.sum((self.scores - self.scores.mean(axis=0)) ** 2))

    @property
    def covariance(self) -> Array:
        """Covariance of the scores, shape (contrast, contrast)."""
        errors = self.scores - self.scores.mean(axis=0)
        return np.asarray(errors.T @ errors / (len(self.scores) - 1))

    @property
    def is_singular(self) -> bool:
        """Return True if the error matrix has no inverse."""
        n, n_contrasts = self.scores.shape
        eigenvalues = np.linalg.eigvalsh(self.covariance)
        is_dependent = bool(eigenvalues[0] <= RANK_TOLERANCE * eigenvalues[-1])
        return n_contrasts > 1 and (n - 1 < n_contrasts or is_dependent)


def effects(design: WithinDesign) -> list[ContrastEffect]:
    """Return the effects of a design: main effects first, then interactions."""
    found = []
    for places in effect_places(len(design.factors)):
        scores = design.cells @ contrasts(design.values.shape[1:], places).T
        mean = scores.mean(axis=0)
        if np.abs(scores - mean).max() <= design.rounding:
            scores = np.broadcast_to(mean, scores.shape)  # an error due to rounding counts as 0: F is then undefined
        found.append(ContrastEffect(tuple(design.factors[place] for place in places), scores))
    return found


def effect_places(n_factors: int) -> list[tuple[int, ...]]:
    """Return the indices of each effect's factors, main effects first."""
    return [places for r in range(1, n_factors + 1) for places in combinations(range(n_factors), r)]


def participant_scores(design: WithinDesign) -> Array:
    """Return a score per participant, for effects between participants."""
    scores: Array = design.cells.sum(axis=1) / np.sqrt(design.cells.shape[1])
    return scores


def contrasts(n_levels: tuple[int, ...], places: tuple[int, ...]) -> Array:
    """Return Helmert contrasts of the factors at `places`, else means."""
    from scipy.linalg import helmert  # slow to load

    whole = np.ones((1, 1))
    for place, k in enumerate(n_levels):
        along = helmert(k) if place in places else np.full((1, k), k**-0.5)
        whole = np.asarray(np.kron(whole, along), dtype=np.float64)
    return whole


def epsilons(covariance: Array, df: float) -> tuple[float, float, float]:
    """Return the epsilons of Greenhouse-Geisser, Huynh-Feldt and Chi-Muller.

    `covariance` (contrast, contrast) is that of orthonormal contrasts, estimated with `df` degrees of freedom.
    Huynh-Feldt's epsilon is corrected for groups (Lecoutre 1991, Journal of Educational Statistics 16, 371-372).
    Chi-Muller's epsilon accounts for few degrees of freedom (Chi, Gribbin, Lamers, Gregory and Muller 2012, Statistics
    in Medicine 31, 724-742); its lower limit here is Greenhouse-Geisser's.
    """
    p = len(covariance)
    squares = p * float(np.sum(covariance**2))
    greenhouse_geisser = float(np.trace(covariance)) ** 2 / squares if squares > 0 else 1.0
    room = p * (df - p * greenhouse_geisser)
    wide = ((df + 1) * p * greenhouse_geisser - 2) / room if room > 0 else np.inf  # infinite, limited to 1 below
    n_moments = (df - 1) + df * (df - 1) / 2
    kept = (n_moments - 2) * (n_moments - 4) / n_moments**2 if n_moments > 4 else 0.0
    huynh_feldt = min(1.0, max(wide, greenhouse_geisser))
    chi_muller = min(1.0, max(wide * kept, greenhouse_geisser)) if kept else greenhouse_geisser
    return greenhouse_geisser, huynh_feldt, chi_muller


def permutation_p(effect: ContrastEffect, *, rng: np.random.Generator | None = None, n_resamples: int = 9_999) -> float:
    """Return the p of an effect from sign changes of the contrasts.

    The test is exact for symmetric errors, without sphericity or an error matrix of full rank. The sum of squares of
    effect plus error is constant, so that ranking by the effect's sum of squares equals ranking by F.
    """
    n = len(effect.scores)
    exact = n <= MOST_EXACT
    if exact:
        # The first sign stays fixed, as changing all signs leaves the squares unchanged.
        signs = np.array(list(product((1.0,), *[(1.0, -1.0)] * (n - 1))))
    elif rng is None:
        raise InvalidParameter(f"rng: found none for {n} participants, expected a Generator that draws the signs")
    else:
        signs = rng.choice([-1.0, 1.0], size=(n_resamples, n))
    sums = np.sum((signs @ effect.scores) ** 2, axis=1)
    observed = float(np.sum(effect.scores.sum(axis=0) ** 2))
    n_as_large = int(np.sum(sums >= observed * (1 - 1e-12)))  # equal up to rounding counts as large
    # The observed signs count as one more draw, so that p is never 0.
    return n_as_large / len(signs) if exact else (n_as_large + 1) / (n_resamples + 1)
