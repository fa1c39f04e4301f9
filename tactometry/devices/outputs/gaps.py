"""Gaps in what a device plays, from what its callback hears."""

import math

LONGEST_WORD_S = 0.1
"""A device that asks for no samples for so long plays none (unverified default)."""


class DryRuns:
    """When a stream ran dry: fed with each block that the device asks for.

    It did where the device tells so, and where it asks for a block later than the ones before lasted: sound servers
    forget to tell. How long they last is believed of a device that has `least_lead_s` in hand; one that takes samples
    as fast as they come has not.

    Examples
    --------
    >>> dry = DryRuns(least_lead_s=0.02)
    >>> dry.after(now_s=1.0, lead_s=0.05, block_s=0.01, underflow=False)
    >>> dry.after(now_s=1.4, lead_s=0.0, block_s=0.01, underflow=False)
    1.06
    >>> dry.after(now_s=1.4, lead_s=0.01, block_s=0.01, underflow=True), dry.n_gaps
    (None, 1)
    """

    def __init__(self, least_lead_s: float) -> None:
        self.n_gaps = 0
        self.dry_s = math.inf
        """When what the device has runs out, s on `time.perf_counter`; infinite where that is not believed."""
        self._least_lead_s = least_lead_s
        self._was_dry = False

    def after(self, *, now_s: float, lead_s: float, block_s: float, underflow: bool) -> float | None:
        """When the gap before this block began, which leaves the device `lead_s` from now; None where there was none.

        A device tells of one gap with several blocks in a row.
        """
        is_dry = underflow or now_s > self.dry_s
        began_s = min(self.dry_s, now_s) if is_dry and not self._was_dry else None
        self.n_gaps += began_s is not None
        self._was_dry = is_dry
        self.dry_s = now_s + lead_s + block_s if lead_s >= self._least_lead_s else math.inf
        return began_s
