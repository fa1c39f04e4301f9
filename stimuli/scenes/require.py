"""Checks of numbers of effects and surfaces, by the name under which a person knows them."""

from math import isfinite

from tactometry.errors import InvalidParameter, nearest


def positive(owner: str, **values: float) -> None:
    """Refuse what is not finite and above 0."""
    for name, value in values.items():
        if not (isfinite(value) and value > 0):
            raise InvalidParameter(f"{owner}.{name}: found {value}, expected a finite number above 0")


def not_negative(owner: str, **values: float) -> None:
    """Refuse what is not finite and at least 0."""
    for name, value in values.items():
        if not (isfinite(value) and value >= 0):
            raise InvalidParameter(f"{owner}.{name}: found {value}, expected a finite number, at least 0")


def one_of(where: str, value: str, names: tuple[str, ...]) -> None:
    """Refuse a word that is not among the names."""
    if value not in names:
        raise InvalidParameter(f"{where}: found {value!r}, expected one of {', '.join(names)}{nearest(value, names)}")
