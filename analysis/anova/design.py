"""Complete within-participant designs, checked for undefined statistics."""

from collections.abc import Sequence
from dataclasses import dataclass

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
