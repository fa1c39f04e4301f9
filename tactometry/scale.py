"""Places on a scale as the values that they stand for."""

from fractions import Fraction


def value_at(place: int, n_places: int, low: float, high: float) -> float:
    """The value of a place (0..n_places-1) on a scale from `low` to `high`, correctly rounded: whole steps stay whole.

    >>> value_at(2, 7, low=1, high=7), value_at(1, 11, low=0.0, high=1.0)
    (3.0, 0.1)
    """
    return float(Fraction(low) + (Fraction(high) - Fraction(low)) * place / (n_places - 1))
