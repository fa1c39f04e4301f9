"""Each press of a key once, whatever the keyboard repeats."""

from collections import deque
from collections.abc import Iterable

N_REMEMBERED = 256


class FreshPresses:
    """Lets through each (name, time) pair once.

    PsychoPy tells of a press that is held when it begins and again, with the old time, when it ends; of a
    tap it tells only when it has ended. Asked for both, it tells of everything, some of it twice.

    >>> fresh = FreshPresses()
    >>> fresh.of([("y", 1.5)]), fresh.of([("y", 1.5), ("n", 2.0)])
    ([('y', 1.5)], [('n', 2.0)])
    """

    def __init__(self) -> None:
        self._seen: deque[tuple[str, float]] = deque(maxlen=N_REMEMBERED)

    def of(self, reported: Iterable[tuple[str, float]]) -> list[tuple[str, float]]:
        """The presses that were not reported before, in the order of their times."""
        fresh = sorted(set(reported) - set(self._seen), key=lambda press: press[1])
        self._seen.extend(fresh)
        return fresh
