"""Within-participant tests on ranks: Friedman's, and the aligned rank transform with contrasts."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np
import pandas as pd

from tactometry.arguments.require import expect
from tactometry.errors import nearest

from ..arrays import Array
from ..distributions import ChiSquare
from .contrasts import ContrastEffect, effects
from .design import WithinDesign, refuse_alike, spread, within_design
from .post_hoc import pairs

DIGITS = 9
"""Aligned values are rounded to so many digits of their spread: what is equal but for rounding is tied."""


def friedman(table: pd.DataFrame, *, dependent: str, factor: str, subject: str) -> pd.DataFrame:
    """Friedman's test of one factor, with Kendall's W: chi2 / (n (k - 1)). Other columns are averaged over.

    Ties count as in Conover (1999), Practical Nonparametric Statistics, section 5.8: by the spread that the ranks have.

    Raises
    ------
    InvalidParameter
        As `repeated_measures`; and if every participant has the same value in all conditions.

    >>> values = [3.0, 4, 6, 2, 5, 6, 4, 4, 7, 1, 3, 5]
    >>> table = pd.DataFrame({"who": list("aaabbbcccddd"), "force_n": [0.5, 1, 2] * 4, "y": values})
    >>> friedman(table, dependent="y", factor="force_n", subject="who").round(4).values.tolist()
    [['force_n', 0.95, 2, 7.6, 0.0224, 4]]
    """
    from scipy.stats import rankdata  # slow to load

    design = within_design(table, dependent=dependent, within=factor, subject=subject, where="friedman")
    values = _rounded(design.values)
    refuse_alike((np.ptp(values, axis=1) > 0).any(), dependent, "all ranks are tied")
    df = values.shape[1] - 1
    ranks = rankdata(values, axis=1) - (values.shape[1] + 1) / 2
    q = df * float((ranks.sum(axis=0) ** 2).sum() / (ranks**2).sum())
    columns = ["Source", "W", "ddof1", "Q", "p_unc", "n"]
    result = pd.DataFrame([[factor, q / (design.n * df), df, q, float(ChiSquare.sf(q, df)), design.n]], columns=columns)
    result.attrs["notes"] = list(design.notes)
    return result


def aligned_rank_transform(
    table: pd.DataFrame, *, dependent: str, within: Sequence[str] | str, subject: str
) -> pd.DataFrame:
    """Aligned rank transform (Wobbrock et al. 2011): an analysis of variance of the ranks of aligned values per effect.

    For each effect, all others are taken out of the cell means, what is left is ranked, and that effect alone is read.
    `f_stripped` is the largest F of the effects that were taken out, in the aligned values: near 0 if the transform
    was right. p is Greenhouse and Geisser's.

    >>> values = [3.0, 4, 6, 2, 5, 6, 4, 4, 7, 1, 3, 5]
    >>> table = pd.DataFrame({"who": list("aaabbbcccddd"), "force_n": [0.5, 1, 2] * 4, "y": values})
    >>> found = aligned_rank_transform(table, dependent="y", within="force_n", subject="who")
    >>> found[["Source", "F", "p_unc"]].round(4).values.tolist()
    [['force_n', 28.539, 0.0009]]
    """
    design = within_design(table, dependent=dependent, within=within, subject=subject, where="aligned_rank_transform")
    spread(design.cells, dependent)
    return pd.DataFrame([_ranked_row(design, effect) for effect in effects(design)])


def art_contrasts(
    table: pd.DataFrame, *, dependent: str, within: Sequence[str], contrast: Sequence[str], subject: str
) -> pd.DataFrame:
    """Pairs of the combined levels of the factors in `contrast` (ART-C, Elkin et al. 2021), Holm-corrected.

    The factors are joined into one, the values aligned for it and ranked: ordinary contrasts on the ranks of
    `aligned_rank_transform` would test something else. The paired t-tests are as those of `pairs`.

    >>> values = [3.0, 4, 6, 2, 5, 6, 4, 4, 7, 1, 3, 5]
    >>> table = pd.DataFrame({"who": list("aaabbbcccddd"), "force_n": [0.5, 1, 2] * 4, "y": values})
    >>> found = art_contrasts(table, dependent="y", within=["force_n"], contrast=["force_n"], subject="who")
    >>> found[["a", "b", "df"]].values.tolist()
    [[0.5, 1.0, 3.0], [0.5, 2.0, 3.0], [1.0, 2.0, 3.0]]
    """
    for name in contrast:
        expect(name in within, "contrast", repr(name), f"some of {', '.join(within)}{nearest(name, within)}")
    design = within_design(table, dependent=dependent, within=within, subject=subject, where="art_contrasts")
    axes = tuple(1 + place for place, name in enumerate(design.factors) if name not in contrast)
    cell_means = design.values.mean(axis=0, keepdims=True)
    joined = cell_means.mean(axis=axes, keepdims=True) - cell_means.mean()
    # Without all cell means, then with those of the joined factor alone: what is ranked holds no other effect.
    ranks = _ranks(design.values - cell_means + joined)
    kept = tuple(levels for name, levels in zip(design.factors, design.levels, strict=True) if name in contrast)
    cells = pd.MultiIndex.from_product(kept)
    names = cells.map(lambda key: key[0] if len(key) == 1 else ", ".join(map(str, key)))
    wide = pd.DataFrame(ranks.mean(axis=axes).reshape(design.n, -1), columns=names)
    long = wide.rename_axis("participant").reset_index().melt("participant", var_name="condition", value_name="rank")
    return pairs(long, dependent="rank", factor="condition", subject="participant")


def _ranked_row(design: WithinDesign, effect: ContrastEffect) -> dict[str, object]:
    cell_means = design.values.mean(axis=0, keepdims=True)
    aligned = _rounded(design.values - cell_means + _estimate(design, effect.factors))
    ranked = _named(replace(design, values=_ranks(aligned)), effect.name)
    stripped = [other.f for other in effects(replace(design, values=aligned)) if other.name != effect.name]
    shape = ranked.sphericity
    return {
        "Source": effect.name,
        "ddof1": ranked.df[0],
        "ddof2": ranked.df[1],
        "F": ranked.f,
        "p_unc": ranked.p(),
        "p_GG_corr": ranked.p(shape.greenhouse_geisser),
        "eps": shape.greenhouse_geisser,
        "f_stripped": max(stripped, default=0.0),
    }


def _named(design: WithinDesign, name: str) -> ContrastEffect:
    return next(effect for effect in effects(design) if effect.name == name)


def _estimate(design: WithinDesign, factors: Sequence[str]) -> Array:
    """The effect's own part of the cell means: sums and differences of marginal means."""
    means = design.values.mean(axis=0, keepdims=True)
    places = [place for place, name in enumerate(design.factors, 1) if name in factors]
    estimate: Array = np.zeros_like(means)
    for r in range(len(places) + 1):
        for kept in combinations(places, r):
            others = tuple(axis for axis in range(1, means.ndim) if axis not in kept)
            # Inclusion and exclusion: an interaction is what lower orders leave, with alternating signs.
            estimate += (-1) ** (len(places) - r) * means.mean(axis=others, keepdims=True)
    return estimate


def _rounded(values: Array) -> Array:
    scale = float(values.std()) or 1.0  # equal values have no spread to be rounded to
    return np.asarray(np.round(values / scale, DIGITS) * scale, dtype=np.float64)


def _ranks(values: Array) -> Array:
    from scipy.stats import rankdata  # slow to load

    return np.reshape(np.asarray(rankdata(_rounded(values), axis=None), dtype=np.float64), values.shape)
