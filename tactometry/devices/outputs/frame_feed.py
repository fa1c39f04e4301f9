"""Frames requested by a sound card, and detection of its gaps."""

import math
import statistics
import threading
from collections import deque
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ...position_dependent import FollowedSignal
from ...signal import FloatArray
from ..clock_map import boot_clock_s

SCANT_S: Final = 0.01
"""A device with less buffered audio at a request has run dry (unverified default: a suspended sound server had 0 to
3 ms after each gap, and 24 ms or more without gaps)."""

SCANT_PART: Final = 0.6
"""A device that requests samples with less than this fraction of its usual buffer was blocked. Measured at a load of
10 to 15 on two cores: in nine touches with unreported gaps, 10 to 54 % of the latency was left. With real-time
priority for program and server, at least 87 % was left in 103 of 105 touches."""
N_LEADS: Final = 400
"""Number of blocks whose lead is stored: two seconds with the default `block_s`."""

BURST_S: Final = 0.05
"""Longest interval between requests of a device that refills its buffer (unverified default)."""
EARLY_S: Final = 0.03
"""A device may run dry this much earlier than its reported buffer ends (unverified default: the block of a sound
server's sink is 20 ms, and its report is inexact)."""

LONGEST_HOLD_UP_S: Final = 0.1
"""A device that requests the first frames later than this after they were ready was blocked (unverified default)."""


class FrameFeed:
    """Frames of one signal in order, until the last frame or a `stop`.

    The device's thread calls `take`, the playing thread all other methods. A stop fades over `n_fade` frames.
    """

    def __init__(self, frames: NDArray[Any], n_fade: int) -> None:
        self._frames, self._n_fade = frames, n_fade
        self._at = self._n_faded = 0
        self._made_s = boot_clock_s()
        self._zero_s = math.inf
        self._stopping = False
        self.onset_s = 0.0
        self.n_gaps = 0
        self.begun, self.ended = threading.Event(), threading.Event()

    @property
    def finished(self) -> bool:
        return self._at >= len(self._frames)

    def is_torn_by(self, dry_s: float, rate_hz: float) -> bool:
        """Return True if a device that ran dry at `dry_s` lost frames."""
        return self.begun.is_set() and dry_s - EARLY_S < self.onset_s + len(self._frames) / rate_hz

    def is_late(self, now_s: float, rate_hz: float) -> bool:
        """Return True if the device has not requested all frames in time."""
        ends_s = self.onset_s + len(self._frames) / rate_hz
        return self.begun.is_set() and not self._stopping and not self.finished and now_s > ends_s

    def begin(self, now_s: float, lead_s: float) -> None:
        """Set the onset, or end if the first request is too late."""
        self.onset_s, self._zero_s = now_s + lead_s, boot_clock_s() + lead_s
        if boot_clock_s() - self._made_s > LONGEST_HOLD_UP_S:
            self._give_up()
        self.begun.set()

    def give_up_if_late(self, rate_hz: float, allowed_s: float) -> None:
        """End without a fade if the next frame is more than `allowed_s` late.

        The process was blocked (SIGSTOP, suspend, debugger) and the device has fallen to zero. Further frames would
        be felt long after the touch.
        """
        late_s = boot_clock_s() - (self._zero_s + self._at / rate_hz)
        if not self.finished and late_s > allowed_s:
            self._give_up()

    def _give_up(self) -> None:
        self._at = len(self._frames)
        self.n_gaps = max(self.n_gaps, 1)  # the device may have reported the same delay
        self.ended.set()

    def stop(self) -> None:
        self._stopping = True

    def take(self, n_frames: int) -> NDArray[Any]:
        """Return the next frames, at most `n_frames`.

        >>> course = FrameFeed(np.full((6, 1), 8.0), n_fade=4)
        >>> course.take(2).ravel().tolist()
        [8.0, 8.0]
        >>> course.stop()
        >>> course.take(10).ravel().tolist(), course.take(10).ravel().tolist()
        ([8.0, 6.0, 4.0, 2.0], [])
        >>> small_blocks = FrameFeed(np.full((6, 1), 8.0), n_fade=4)
        >>> small_blocks.stop()
        >>> small_blocks.take(2).ravel().tolist(), small_blocks.take(2).ravel().tolist()
        ([8.0, 6.0], [4.0, 2.0])
        """
        stopping = self._stopping  # read once: the playing thread may set it meanwhile
        n_taken = min(n_frames, self._n_fade - self._n_faded) if stopping else n_frames
        begin, piece = self._at, self._frames[self._at : self._at + n_taken]
        self._at += n_taken
        if stopping:
            envelope = 1 - (self._n_faded + np.arange(len(piece))) / self._n_fade
            self._n_faded += len(piece)
            falling: NDArray[Any] = piece * envelope[:, None]
            piece = falling.astype(piece.dtype)  # integer samples are truncated towards zero
            if self._n_faded >= self._n_fade:
                self._at = len(self._frames)
        emitted = self._emitted(piece, begin)
        if self.finished:
            self.ended.set()
        return emitted

    def _emitted(self, piece: NDArray[Any], begin: int) -> NDArray[Any]:
        del begin
        return piece


class FollowingFeed(FrameFeed):
    """Frames weakened by the last known finger position `latency_s` earlier."""

    def __init__(self, frames: NDArray[Any], n_fade: int, signal: FollowedSignal, latency_s: float) -> None:
        super().__init__(frames, n_fade)
        self._signal, self.latency_s = signal, latency_s
        self._before: Any = None
        self._part: float | None = None
        self._pieces: list[NDArray[Any]] = []
        self._n_late = self._n_unknown = 0

    def _emitted(self, piece: NDArray[Any], begin: int) -> NDArray[Any]:
        if not len(piece):
            return piece
        path = self._signal.path
        times_s = self.onset_s - self.latency_s + np.arange(begin, begin + len(piece)) / self._signal.rate_hz
        last_s = path.last_s  # read before the positions, as the sensor's thread may add some
        places_m = path.at(times_s)
        self._n_late += len(piece) - int(np.searchsorted(times_s, last_s, side="right"))
        self._n_unknown += int(np.count_nonzero(np.isnan(places_m)))
        parts, self._before = self._signal.stimulus.parts(places_m, self._before)
        parts = self._as_checked(parts)
        emitted: NDArray[Any] = (piece * parts[:, None]).astype(piece.dtype)  # integers are truncated towards zero
        self._pieces.append(emitted)
        return emitted

    def _as_checked(self, parts: FloatArray) -> FloatArray:
        """Limit the factors to what the guard assumed: 0 to 1, no fast steps."""
        parts = np.clip(np.nan_to_num(parts, nan=0.0), 0.0, 1.0)
        step = (1 + 1e-9) / (self._signal.stimulus.rise_s * self._signal.rate_hz)
        last = float(parts[0]) if self._part is None else self._part
        if np.max(np.abs(np.diff(parts, prepend=last))) > step:
            for n, part in enumerate(parts.tolist()):
                last = parts[n] = min(max(part, last - step), last + step)
        self._part = float(parts[-1])
        return parts

    def frames(self) -> NDArray[Any]:
        """Return the emitted frames, (n_frames, n_channels)."""
        return np.concatenate(self._pieces) if self._pieces else self._frames[:0]

    @property
    def late(self) -> float:
        """Fraction (0..1) of the frames whose position was late."""
        return self._n_late / max(1, sum(map(len, self._pieces)))

    @property
    def unknown(self) -> float:
        """Fraction (0..1) of the frames without a known position."""
        return self._n_unknown / max(1, sum(map(len, self._pieces)))


def was_held_up(left_s: float, leads_s: Sequence[float], latency_s: float) -> bool:
    """Return True if a device may have skipped frames.

    A blocked sound server may run dry before its reported buffer ends, without reporting it. The usual buffer is the
    median of `leads_s`, but at most `latency_s`. All times are in s.

    >>> was_held_up(0.05, [0.1, 0.1, 0.11], latency_s=0.1), was_held_up(0.07, [0.1, 0.1, 0.11], latency_s=0.1)
    (True, False)
    >>> was_held_up(0.05, [0.06, 0.05, 0.05], latency_s=0.1)
    False
    """
    scant_s = SCANT_PART * latency_s
    return left_s < scant_s and bool(leads_s) and left_s < SCANT_PART * statistics.median(leads_s)


class DryRuns:
    """Detector of gaps in a stream, which examines each requested block.

    The stream ran dry if the device reports it, requests a block late, or has almost nothing buffered. A device that
    `was_held_up` also counts as dry, because an undetected gap is worse than a repeated touch. The reported buffer is
    trusted only after it reached half of `latency_s` once.

    >>> dry = DryRuns(latency_s=0.04)
    >>> dry.after(now_s=1.0, lead_s=0.05, block_s=0.01, underflow=False)
    >>> dry.after(now_s=1.4, lead_s=0.0, block_s=0.01, underflow=False), dry.is_dry
    (1.05, True)
    >>> dry.after(now_s=1.4, lead_s=0.01, block_s=0.01, underflow=True), dry.n_gaps
    (None, 1)
    """

    def __init__(self, latency_s: float) -> None:
        self.n_gaps = 0
        self.dry_s = math.inf
        """Time at which the buffer of the device runs out, s on `time.perf_counter`. Infinite if the device's report
        is not trusted."""
        self.is_dry = False
        """True if the device ran dry, or may have, before the last request."""
        self.leads_s: deque[float] = deque(maxlen=N_LEADS)
        self._latency_s, self._had_lead = latency_s, False
        self._last_s = self._last_dry_s = -math.inf
        self._heard_s = -math.inf
        """Time at which the first block of the last burst is emitted, as reported by the device."""

    @property
    def has_lead(self) -> bool:
        """True once the device has reported at least half of `latency_s` as buffered."""
        return self._had_lead

    def after(self, *, now_s: float, lead_s: float, block_s: float, underflow: bool) -> float | None:
        """Add a block and return when a gap before it may have begun, or None.

        A device reports one gap with several blocks of a burst, and up to the duration of its buffer too late.
        """
        held_up = was_held_up(self.dry_s - now_s, self.leads_s, self._latency_s)
        is_dry = underflow or held_up or now_s > self.dry_s or (self._had_lead and lead_s < SCANT_S)
        is_new = is_dry and not self.is_dry and (held_up or now_s - self._last_dry_s > BURST_S)
        began_s = min(self._heard_s, now_s - self._latency_s * underflow) if is_new else None
        self.n_gaps += is_new
        self.is_dry, self._last_dry_s = is_dry, now_s if is_dry else self._last_dry_s
        self._had_lead = self._had_lead or lead_s >= self._latency_s / 2
        self.dry_s = now_s + lead_s + block_s if self._had_lead else math.inf
        if now_s - self._last_s > block_s / 2:
            self._heard_s = now_s + lead_s
        self._last_s = now_s
        self.leads_s.append(lead_s)
        return began_s
