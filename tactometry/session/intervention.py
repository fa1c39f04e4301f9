"""What an experimenter may change in the course of a session, between two trials."""

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
    """That a recorded trial does not count, that the rest of a block is skipped, a rest, or the end of the session.

    `trial` is that which does not count: its block, its number, its attempt.
    """

    wanted: Wanted
    trial: Key | None = None

    def __post_init__(self) -> None:
        one_of("Intervention.wanted", self.wanted, WANTED)


def left(wanted: Iterable[Intervention], carried: Iterable[Intervention]) -> tuple[Intervention, ...]:
    """What was wanted and never reached the session, in the order in which it was wanted.

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
