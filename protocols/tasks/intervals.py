"""Several stimuli, one after the other."""

from collections.abc import Sequence

from tactometry.session.answer import Touched
from tactometry.session.run import Course

from .touch import Touch


def feel_in_turn(touch: Touch, stimuli: Sequence[str], levels: Sequence[float | None]) -> Course[tuple[Touched, ...]]:
    """The touches of intervals 1, 2, ...; a touch that is not valid is the last."""
    touches: list[Touched] = []
    for interval, (stimulus, level) in enumerate(zip(stimuli, levels, strict=True), 1):
        touches.append((yield touch.request(stimulus, level, interval)))
        if not touches[-1].valid:
            break
    return tuple(touches)


def nth(touches: Sequence[Touched], interval: int) -> Touched | None:
    """The touch of an interval, if it came to it."""
    return touches[interval - 1] if interval <= len(touches) else None
