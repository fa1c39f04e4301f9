"""Reading of sensors, each in its own thread, independent of the display."""

import contextlib
import math
import threading
import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar, Final

import numpy as np

from ...arguments.require import expect
from ...errors import DeviceFailed
from ...signal import FloatArray
from ..clock_map import CLOSE_WITHIN_S, within

RETRY_S = 0.2
"""Interval of attempts to reopen a lost device."""
POLL_S = 0.01
"""Interval of empty blocks while no samples arrive."""
KEPT_S = 60.0
"""Number of blocks after which a listener that does not read loses its oldest samples."""
AHEAD_S: Final = 0.05
"""Largest time by which a stamp may precede its arrival, due to errors of the clock offset (unverified default)."""
LATE_S: Final = 0.1
"""Age on arrival above which samples are not current. A sensor silent for longer is lost."""
LATE_FOR_S: Final = 5.0
"""Longest time for which all samples may be late, as after a busy period of the computer. No gate opens on late
samples (unverified default)."""


@dataclass(frozen=True, eq=False)
class SampleBlock:
    """Times (n_samples,), s, and counts (n_samples, n_channels)."""

    times_s: FloatArray
    values: FloatArray


class Source(ABC):
    """Device that a reader reads, at the nominal rate `rate_hz`.

    Its methods are called from one thread at a time.
    """

    def __init__(self, name: str, rate_hz: float, n_channels: int) -> None:
        self.name, self.rate_hz, self.n_channels = name, rate_hz, n_channels
        self._opened = contextlib.ExitStack()

    def check(self) -> None:  # noqa: B027 - most sources read no file
        """Raise `DeviceFailed` if a required file cannot be read."""

    @abstractmethod
    def open(self) -> None:
        """Open the device. Raises `DeviceFailed`."""

    @abstractmethod
    def receive(self) -> SampleBlock | None:
        """Return the next samples, or None after about `POLL_S`."""

    def close(self) -> None:
        """Release everything on the stack `_opened`. May be repeated."""
        self._opened.close()

    def facts(self) -> dict[str, str | int | float | None]:
        """Return counts of damaged and lost samples, and the clock offset."""
        return {}


class SensorSettings(ABC):
    """Table of a sensor. `live` is True if its samples are current."""

    live: ClassVar[bool] = True

    @abstractmethod
    def source(self) -> Source:
        """Create the source without opening it."""


class Listener:
    """Samples that one part of the program has not read yet."""

    def __init__(self, n_channels: int) -> None:
        self._n_channels = n_channels
        self._blocks: deque[SampleBlock] = deque()

    def append(self, block: SampleBlock) -> None:
        if block.times_s.size == 0:
            return
        self._blocks.append(block)
        while self._blocks[0].times_s[-1] < block.times_s[-1] - KEPT_S:
            self._blocks.popleft()

    def read(self) -> SampleBlock:
        """Return all samples since the last call, without waiting."""
        # the current number, as the reader's thread may add more
        blocks = [self._blocks.popleft() for _ in range(len(self._blocks))]
        if not blocks:
            return SampleBlock(np.empty(0), np.empty((0, self._n_channels)))
        times_s = np.concatenate([block.times_s for block in blocks])
        return SampleBlock(times_s, np.concatenate([block.values for block in blocks]))

    def blocks(self, end_s: float, pause_s: float = 0.01) -> Iterator[SampleBlock]:
        """Yield blocks as they arrive, until `end_s`."""
        while now_s() < end_s:
            block = self.read()
            if block.times_s.size:
                yield block
            time.sleep(pause_s)


@dataclass(frozen=True)
class Arrivals:
    """State of a sensor's time stamps.

    - `last_s`: Last time stamp, s.
    - `late_since_s`: Arrival time of the first of the late blocks, s; None if the last block was current.
    - `n_steps_back`: Number of time stamps that precede the previous one.
    - `fault`: Reason why the last block is rejected: a time stamp that is not finite, in the future, or late for too
      long.

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

    def after(self, times_s: FloatArray, arrival_s: float) -> "Arrivals":
        """Add a block of at least one sample."""
        stamps_s = times_s.tolist()
        age_s = arrival_s - max(stamps_s)  # age of the newest sample: a block is late if all its samples are
        since_s = arrival_s if self.late_since_s is None else self.late_since_s
        late_since_s = since_s if age_s > LATE_S else None
        late_for_s = 0.0 if late_since_s is None else arrival_s - late_since_s
        before_s = stamps_s[0] if self.last_s is None else self.last_s
        n_steps_back = self.n_steps_back + sum(late < early for early, late in pairwise((before_s, *stamps_s)))
        return Arrivals(stamps_s[-1], late_since_s, n_steps_back, _fault(stamps_s, age_s, late_for_s))


def _fault(stamps_s: list[float], age_s: float, late_for_s: float) -> str | None:
    if not all(map(math.isfinite, stamps_s)):
        return "found a stamp that is not finite, expected seconds"
    if age_s < -AHEAD_S:
        return (
            f"found a stamp {-age_s:.3g} s after its arrival, expected none later than that: its clock runs fast, has "
            "jumped, or is not related to this computer's"
        )
    if late_for_s > LATE_FOR_S:
        return (
            f"found samples that are {age_s:.3g} s old on arrival, expected at most {LATE_S:g} s: its clock runs "
            "slow, has stopped or has jumped back, or its samples are buffered"
        )
    return None


class Reader:
    """Reader of a source, in a thread that reopens it after an outage.

    Any exception of the source is an outage, and so are time stamps that contradict their arrival. The affected
    samples are dropped. The known delay `delay_s` is subtracted from time stamps.
    """

    def __init__(self, source: Source, delay_s: float = 0.0) -> None:
        self.source, self._delay_s = source, delay_s
        self._subscribers: tuple[Callable[[SampleBlock], None], ...] = ()
        self._nothing = SampleBlock(np.empty(0), np.empty((0, source.n_channels)))
        self._n_open = 0
        self._ending = threading.Event()
        self._thread: threading.Thread | None = None
        self._n_samples = 0
        self._n_outages = self._n_steps_back = 0
        self._arrivals = Arrivals()
        self.failure: str | None = None
        """Reason why no samples have arrived since the last ones."""

    def facts(self) -> dict[str, str | int | float | None]:
        counts = {"n_samples": self._n_samples, "n_outages": self._n_outages, "failure": self.failure}
        n_steps_back = self._n_steps_back + self._arrivals.n_steps_back
        return {**self.source.facts(), **counts, "n_steps_back": n_steps_back}

    def check_channels(self, where: str, *channels: int) -> None:
        """Refuse a channel that the source lacks. `where` begins the message."""
        last = self.source.n_channels - 1
        for channel in channels:
            expect(0 <= channel <= last, where, channel, f"a channel of {self.source.name}, from 0 to {last}")

    def listen(self) -> Listener:
        """Return a new listener, which receives samples from now on."""
        listener = Listener(self.source.n_channels)
        self.subscribe(listener.append)
        return listener

    def subscribe(self, on_block: Callable[[SampleBlock], None]) -> Callable[[], None]:
        """Call `on_block` in the reader's thread with each block.

        Returns the function that ends the subscription.
        """
        # a new tuple, as the reader's thread may be iterating over the old one
        self._subscribers = (*self._subscribers, on_block)

        def unsubscribe() -> None:
            self._subscribers = tuple(other for other in self._subscribers if other is not on_block)

        return unsubscribe

    def open(self) -> None:
        """Begin to read, unless the reader is already open. Raises `DeviceFailed`."""
        if self._n_open == 0:
            self._open_source()
            self._ending.clear()
            self._thread = threading.Thread(target=self._run, name=f"reader of {self.source.name}", daemon=True)
            self._thread.start()
        self._n_open += 1

    def close(self) -> None:
        """End the thread after the last user of the reader has closed it."""
        self._n_open = max(0, self._n_open - 1)
        if self._n_open == 0 and self._thread is not None:
            self._ending.set()
            self._thread.join(CLOSE_WITHIN_S)
            self._thread = None
            within(CLOSE_WITHIN_S, self.source.name, self.source.close, cure="unplug it")

    def _run(self) -> None:
        while not self._ending.is_set():
            try:
                self._take(self.source.receive())
            except Exception as error:  # the device is reopened after any error
                self.failure = str(self._as_failure(error))
                self._n_outages += 1
                with contextlib.suppress(Exception):
                    self.source.close()
                self._find_again()

    def _open_source(self) -> None:
        self._n_steps_back += self._arrivals.n_steps_back
        self._arrivals = Arrivals()
        try:
            self.source.open()
        except Exception as error:
            with contextlib.suppress(Exception):  # release a partly opened device
                self.source.close()
            raise self._as_failure(error) from None

    def _as_failure(self, error: Exception) -> DeviceFailed:
        if isinstance(error, DeviceFailed):
            return error
        words = f"{type(error).__name__}: {' '.join(str(error).split())}"
        return DeviceFailed(f"{self.source.name}: found a failure ({words}), expected samples")

    def _take(self, block: SampleBlock | None) -> None:
        if block is None or block.times_s.size == 0:
            self._publish(self._nothing)
            return
        self._arrivals = self._arrivals.after(block.times_s, now_s())
        if self._arrivals.fault is not None:
            self._n_outages += self.failure is None
            self.failure = f"{self.source.name}: {self._arrivals.fault}"
            self._publish(self._nothing)
            return
        self._n_samples += block.times_s.size
        self.failure = None
        # copied only if stamps are shifted, as listeners share the block
        self._publish(SampleBlock(block.times_s - self._delay_s, block.values) if self._delay_s else block)

    def _publish(self, block: SampleBlock) -> None:
        for on_block in self._subscribers:
            on_block(block)

    def _find_again(self) -> None:
        next_s = now_s() + RETRY_S
        while not self._ending.wait(POLL_S):
            self._publish(self._nothing)
            if now_s() < next_s:
                continue
            next_s = now_s() + RETRY_S
            try:
                self._open_source()
            except DeviceFailed as error:
                self.failure = str(error)
            else:
                return


def now_s() -> float:
    return time.perf_counter()
