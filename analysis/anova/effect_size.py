"""Sizes of effects of an analysis of variance, with intervals from the noncentral F distribution."""

from dataclasses import dataclass

from scipy.optimize import brentq
from scipy.special import ncfdtr

INTERVAL = 0.90
"""So wide an interval leaves out 0 exactly where the test is significant at 5 % (Steiger 2004)."""
LARGEST = 1e7


@dataclass(frozen=True)
class EtaSquared:
    """Partial and generalised eta squared, each with its interval."""

    partial: float
    partial_low: float
    partial_high: float
    generalised: float
    generalised_low: float
    generalised_high: float


def eta_squared(
    ss: float, ss_error: float, ss_residual: float, df: tuple[float, float], interval: float = INTERVAL
) -> EtaSquared:
    """Partial eta squared SS / (SS + SS error) and generalised SS / (SS + residual) (Bakeman 2005).

    `ss_residual` is what the generalised one divides by besides the effect: participants and all errors. `df` are
    the degrees of freedom, corrected if the test is. The interval is that of the noncentrality l of F, as
    l / (l + n) with n = df1 + df2 + 1 (Steiger 2004, Psychol. Methods 9, 164, eq. 21); the generalised one takes the
    sums of squares of participants and errors as they were found.

    >>> found = eta_squared(10.0, 10.0, 40.0, (2.0, 18.0))
    >>> [round(x, 3) for x in (found.partial, found.partial_low, found.partial_high, found.generalised)]
    [0.5, 0.159, 0.64, 0.2]
    """
    f = ss / df[0] / (ss_error / df[1])
    low, high = (x / (x + sum(df) + 1) for x in noncentrality(f, df, interval))
    share = ss_error / ss_residual
    partial, generalised = ss / (ss + ss_error), ss / (ss + ss_residual)
    return EtaSquared(partial, low, high, generalised, _scaled(low, share), _scaled(high, share))


def _scaled(partial: float, share: float) -> float:
    """The generalised eta squared that belongs to a partial one; `share`: of the error in the residual."""
    odds = share * partial / (1 - partial)
    return odds / (1 + odds)


def noncentrality(f: float, df: tuple[float, float], interval: float) -> tuple[float, float]:
    """The noncentralities under which so large or so small an F has the chance (1 - interval) / 2."""
    tail = (1 - interval) / 2
    return _under(f, df, 1 - tail), _under(f, df, tail)


def _under(f: float, df: tuple[float, float], chance: float) -> float:
    def above(x: float) -> float:
        return float(ncfdtr(*df, x, f)) - chance

    if above(0.0) <= 0:  # so small an F is likelier than that without any effect
        return 0.0
    top = 2 * (f * df[0] + sum(df))
    while above(top) > 0 and top < LARGEST:
        top *= 2
    return float(brentq(above, 0.0, top, xtol=1e-9, rtol=1e-12)) if above(top) < 0 else top
