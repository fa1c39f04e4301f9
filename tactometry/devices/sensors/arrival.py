"""Stamps held against arrival: a sensor is believed of its time as far as our own clock bears it out."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

AHEAD_S: Final = 0.05
"""A sample is not taken later than it arrives, but for an error of the clocks' relation (unverified default)."""
LATE_S: Final = 0.1
"""A sample that is older when it arrives says nothing of now: a sensor that is silent for so long is lost, too."""
LATE_FOR_S: Final = 5.0
"""So long may all samples be late: what had waited while the computer was held up is through by then. No gate opens on
them meanwhile (unverified default)."""


@dataclass(frozen=True)
class Arrivals:
    """What the stamps of a sensor were like up to now.

    Parameters
    ----------
    last_s : float or None
        The last stamp, s.
    late_since_s : float or None
        When the first of the blocks came that were all late, s.
    n_steps_back : int
        How often a stamp was before the one before it.
    fault : str or None
        Why the last block is not believed: a stamp that is no number, lies in the future, or late for a while.

    Examples
    --------
    >>> arrivals = Arrivals().after(np.array([1.0, 1.1]), arrival_s=1.11)
    >>> arrivals.fault, arrivals.after(np.array([1.05]), arrival_s=1.12).n_steps_back
    (None, 1)
    >>> arrivals.after(np.array([1.3]), arrival_s=1.2).fault
    "found a stamp 0.1 s after its arrival, expected none later than that: its clock runs fast, has jumped, or is not \
related to this computer's"
    """

    last_s: float | None = None
    late_since_s: float | None = None
    n_steps_back: int = 0
    fault: str | None = None

    def after(self, times_s: NDArray[np.float64], arrival_s: float) -> "Arrivals":
        """With a block of at least one sample."""
        age_s = arrival_s - float(times_s.max())  # of the newest: a block is late if all of it is
        since_s = arrival_s if self.late_since_s is None else self.late_since_s
        late_since_s = since_s if age_s > LATE_S else None
        late_for_s = 0.0 if late_since_s is None else arrival_s - late_since_s
        before_s = times_s[0] if self.last_s is None else self.last_s
        steps_s = np.diff(times_s, prepend=before_s)
        n_steps_back = self.n_steps_back + int(np.count_nonzero(steps_s < 0))
        fault = _fault(times_s, age_s, late_for_s)
        return Arrivals(float(times_s[-1]), late_since_s, n_steps_back, fault)


def _fault(times_s: NDArray[np.float64], age_s: float, late_for_s: float) -> str | None:
    if not np.isfinite(times_s).all():
        return "found a stamp that is no finite number, expected seconds"
    if age_s < -AHEAD_S:
        return (
            f"found a stamp {-age_s:.3g} s after its arrival, expected none later than that: its clock runs fast, has "
            "jumped, or is not related to this computer's"
        )
    if late_for_s > LATE_FOR_S:
        return (
            f"found samples that are {age_s:.3g} s old when they come, expected at most {LATE_S:g} s: its clock runs "
            "slow, stands still or has jumped back, or its samples wait on their way"
        )
    return None
