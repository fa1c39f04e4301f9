"""Interventions of the experimenter, which take effect between two trials."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final, Literal, get_args

from ..arguments.require import one_of
from ..trials.trial import Key

Wanted = Literal["invalidate", "skip", "rest", "end"]
WANTED: Final[tuple[str, ...]] = get_args(Wanted)


@dataclass(frozen=True)
class Intervention:
    """Experimenter command: discard a trial, skip the block, take a break, or end.

    `trial` is the discarded trial: block, number, attempt.
    """

    wanted: Wanted
    trial: Key | None = None

    def __post_init__(self) -> None:
        one_of("Intervention.wanted", self.wanted, WANTED)


def left(wanted: Iterable[Intervention], carried: Iterable[Intervention]) -> tuple[Intervention, ...]:
    """Return the interventions that were not carried out, in order.

    >>> skip, rest = Intervention("skip"), Intervention("rest")
    >>> left([skip, rest, skip], [skip])
    (Intervention(wanted='rest', trial=None), Intervention(wanted='skip', trial=None))
    """
    known = Counter(carried)
    missing = []
    for each in wanted:
        if known[each]:
            known[each] -= 1
        else:
            missing.append(each)
    return tuple(missing)
