"""Complete within-participant designs, checked for undefined statistics."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations, product

import numpy as np
import pandas as pd

from tactometry.arguments.require import expect
from tactometry.errors import InvalidParameter

from ..arrays import RELATIVE_ZERO, Array, Indices, StatusWithNote, size_of
from ..reading.rows import no_column

MIN_PARTICIPANTS, MAX_FACTORS = 3, 3
AVERAGED = "several values of one participant in one cell were averaged"


class DesignStatus(StatusWithNote):
    """Reason why a statistic is undefined, except `OK` and `SINGULAR`."""

    OK = "ok", ""
    SINGULAR = "singular_error_matrix", "the error matrix is singular"
    NO_DATA = "no_data", "no value is known"
    NOT_FINITE = "not_finite", "a value is not finite"
    NO_NAME = "no_name", "a level of a factor has no name"
    MISSING_CELL = "missing_cell", "a participant has no value in one of the conditions"
    TOO_FEW_PARTICIPANTS = "too_few_participants", "too few participants have a value"
    SMALL_GROUP = "small_group", ""
    ONE_LEVEL = "one_level", "a factor has only one level"
    CONSTANT = "constant", "all values are equal"
    NO_VARIANCE_WITHIN = "no_variance_within", "no participant's values differ between conditions"
    ZERO_ERROR = (
        "zero_error",
        "the effect is the same in all participants, so its error is 0",
    )
    TOO_FEW_KNOWN = "too_few_known", "too few values are known"
    NO_MAXIMUM = "no_maximum", "the known values do not determine the estimates"


def reason_of(refusal: InvalidParameter) -> str:
    """Return the reason why an analysis has no result, as text for a report.

    >>> reason_of(UndefinedStatistic("y: found 3, expected more", DesignStatus.CONSTANT))
    'all values are equal'
    """
    status = refusal.status if isinstance(refusal, UndefinedStatistic) else DesignStatus.NO_MAXIMUM
    return status.note or str(refusal)  # without a note, the message names the small group


class UndefinedStatistic(InvalidParameter):
    """Error for values without a defined test; `status` is the reason."""

    def __init__(self, message: str, status: DesignStatus) -> None:
        super().__init__(message)
        self.status = status

    def __reduce__(self) -> tuple[type["UndefinedStatistic"], tuple[str, DesignStatus]]:
        """Pickle the status too, as the default passes only the message."""
        return type(self), (str(self), self.status)


def expect_defined(holds: bool | np.bool_, status: DesignStatus, where: str, found: object, expected: str) -> None:
    """Raise `UndefinedStatistic` with `status` unless `holds`."""
    if not holds:
        raise UndefinedStatistic(f"{where}: found {found}, expected {expected}", status)


@dataclass(frozen=True)
class WithinDesign:
    """Values (participant, level, ...) with the names along all axes.

    `notes` are for the report. Differences below `rounding` count as zero.
    """

    values: Array
    factors: tuple[str, ...]
    levels: tuple[tuple[object, ...], ...]
    participants: tuple[object, ...]
    notes: tuple[str, ...] = ()
    rounding: float = 0.0

    @property
    def n(self) -> int:
        return len(self.participants)

    @property
    def cells(self) -> Array:
        """Values (participant, cell), with the last factor varying fastest."""
        return self.values.reshape(self.n, -1)


def within_design(
    table: pd.DataFrame, *, dependent: str, within: Sequence[str] | str, subject: str, where: str
) -> WithinDesign:
    """Arrange a table in long form as a design; repeated cells are averaged.

    Raises `InvalidParameter` for a missing column, or if there are not one to three different factors. Raises
    `UndefinedStatistic` for values that are not finite, missing cells, too few participants or levels.
    """
    within = names_of(within)
    data = finite_rows(table, [dependent, subject, *within], dependent, where)
    are_different = len({dependent, subject, *within}) == len(within) + 2
    is_possible = are_different and 1 <= len(within) <= MAX_FACTORS
    expect(is_possible, "within", ", ".join(within), "one to three different factors")

    coded = [codes_of(data, name) for name in (subject, *within)]
    levels = tuple(tuple(different) for _, different in coded)
    refuse_few(levels, subject, within)
    shape = tuple(len(names) for names in levels)
    place = np.ravel_multi_index([codes for codes, _ in coded], shape)
    n_values = np.bincount(place, minlength=int(np.prod(shape))).reshape(shape)
    _refuse_holes(n_values, levels, (subject, *within), dependent)

    y = data[dependent].to_numpy()
    size = size_of(y)  # divided by the largest value first, as sums of very large floats would overflow
    values = size * (np.bincount(place, y / size, minlength=n_values.size).reshape(shape) / n_values)
    rounding = RELATIVE_ZERO * float(np.abs(values).max())
    return WithinDesign(values, tuple(within), levels[1:], levels[0], _average_note(n_values), rounding)


def names_of(within: Sequence[str] | str) -> list[str]:
    return [within] if isinstance(within, str) else list(within)


def codes_of(data: pd.DataFrame, name: str) -> tuple[Indices, Sequence[object]]:
    """Return each row's index in the sorted values, and these values.

    Raises `InvalidParameter` if the values cannot be sorted.
    """
    try:
        codes, different = pd.factorize(data[name], sort=True)
    except TypeError:
        kinds = ", ".join(sorted({type(value).__name__ for value in data[name]}))
        raise InvalidParameter(
            f"{name}: found values that cannot be sorted ({kinds}), expected numbers or text"
        ) from None
    return codes, list(different)


def _average_note(n_values: Indices) -> tuple[str, ...]:
    few, many = int(n_values.min()), int(n_values.max())
    uneven = f", {few} to {many} per cell" if few < many else ""
    return (AVERAGED + uneven,) if many > 1 else ()


def finite_rows(table: pd.DataFrame, columns: Sequence[str], dependent: str, where: str) -> pd.DataFrame:
    """Return the named columns, checked for finite values and named levels.

    An error names the first bad row.
    """
    expect_columns(table, columns, where)
    data = table[list(dict.fromkeys(columns))].reset_index(drop=True)
    values = pd.to_numeric(data[dependent], errors="coerce").to_numpy(dtype=np.float64)
    bad = ~np.isfinite(values)
    row = int(bad.argmax())
    place = ", ".join(f"{name} = {data[name][row]}" for name in columns if name != dependent)
    found = f"{data[dependent][row]} ({place})"
    expected = "a finite number; remove the participant or the condition"
    expect_defined(not bad.any(), DesignStatus.NOT_FINITE, f"{dependent}, row {row}", found, expected)
    expect_names(data, [name for name in columns if name != dependent])
    return data.assign(**{dependent: values})


def expect_columns(table: pd.DataFrame, columns: Sequence[str], where: str) -> None:
    """Raise for a table without rows or without one of the columns."""
    known = list(map(str, table.columns))
    for name in columns:
        if name not in known:
            raise InvalidParameter(f"{where}: {no_column(name, table)}")
    expect_defined(not table.empty, DesignStatus.NO_DATA, "table", "no row", "values to compare")


def expect_names(data: pd.DataFrame, columns: Sequence[str]) -> None:
    """Raise for a row without a participant or a condition."""
    expected = "the name of a participant or a condition; remove the row"
    for name in columns:
        is_empty = data[name].isna().to_numpy()
        where = f"{name}, row {is_empty.argmax()}"
        expect_defined(not is_empty.any(), DesignStatus.NO_NAME, where, "nothing", expected)


def refuse_few(levels: Sequence[Sequence[object]], subject: str, within: Sequence[str]) -> None:
    """Raise for fewer than three participants, or two levels of a factor.

    The first item of `levels` lists the participants.
    """
    n = len(levels[0])
    found, expected = f"{n} participant{'s' if n != 1 else ''}", f"at least {MIN_PARTICIPANTS} to compare"
    expect_defined(n >= MIN_PARTICIPANTS, DesignStatus.TOO_FEW_PARTICIPANTS, subject, found, expected)
    for name, values in zip(within, levels[1:], strict=True):
        refuse_one(name, len(values), "value")


def refuse_one(name: str, n: int, what: str) -> None:
    """Raise for a factor with fewer than two values (or groups)."""
    expect_defined(n >= 2, DesignStatus.ONE_LEVEL, name, f"{n} {what}", "at least 2 to compare")


def refuse_constant(spread: float, size: float, dependent: str) -> None:
    """Raise if the spread of the values is only rounding error."""
    has_spread = spread > RELATIVE_ZERO * size
    expect_defined(has_spread, DesignStatus.CONSTANT, dependent, "the same value everywhere", "values that differ")


def _refuse_holes(n_values: Indices, levels: Sequence[Sequence[object]], names: Sequence[str], dependent: str) -> None:
    holes = np.argwhere(n_values == 0)
    if not len(holes):
        return
    axes = zip(names, levels, holes[0], strict=True)
    first = ", ".join(f"{name} = {values[i]}" for name, values, i in axes)
    whose = ", ".join(dict.fromkeys(str(levels[0][i]) for i in holes[:, 0]))
    raise UndefinedStatistic(
        f"{dependent}: found no value for {first} ({len(holes)} missing cell{'s' if len(holes) > 1 else ''}: "
        f"{whose}), expected one in every cell; remove the participant or the condition, or fit a mixed model",
        DesignStatus.MISSING_CELL,
    )


def spread(values: Array, dependent: str) -> float:
    """Return the standard deviation of all values, if F is defined.

    Raises `UndefinedStatistic` if all values are equal, if conditions do not differ, or if they differ equally in all
    participants.
    """
    unit = size_of(values)
    values = values / unit
    size, sd = float(np.abs(values).max()), float(values.std())
    refuse_constant(sd, size, dependent)
    within = values - values.mean(axis=1, keepdims=True)
    has_differences = np.abs(within).max() > RELATIVE_ZERO * size
    found = "no difference between the conditions of any participant"
    expect_defined(
        has_differences,
        DesignStatus.NO_VARIANCE_WITHIN,
        dependent,
        found,
        "differences, without which F is undefined",
    )
    has_error = np.abs(within - within.mean(axis=0)).max() > RELATIVE_ZERO * size
    found, expected = (
        "the same differences in all participants",
        "some error, without which F is undefined",
    )
    expect_defined(has_error, DesignStatus.ZERO_ERROR, dependent, found, expected)
    return sd * unit


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
    result = []
    for places in effect_places(len(design.factors)):
        scores = design.cells @ contrasts(design.values.shape[1:], places).T
        mean = scores.mean(axis=0)
        if np.abs(scores - mean).max() <= design.rounding:
            scores = np.broadcast_to(mean, scores.shape)  # an error due to rounding counts as 0: F is then undefined
        result.append(ContrastEffect(tuple(design.factors[place] for place in places), scores))
    return result


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
