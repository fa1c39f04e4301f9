"""One thread per sensor: it takes samples as they come, so that drawing never starves it."""

import contextlib
import threading
import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...arguments.require import expect
from ...errors import DeviceFailed
from ..deadline import CLOSE_WITHIN_S, within
from .arrival import Arrivals

FloatArray = NDArray[np.float64]

RETRY_S = 0.2
"""A device that went away is looked for this often."""
POLL_S = 0.01
"""That nothing came is said this often."""
KEPT_S = 60.0
"""A listener that does not read loses what is older."""


@dataclass(frozen=True, eq=False)
class SampleBlock:
    """Samples: times (n_samples,) in s on `time.perf_counter`, values (n_samples, n_channels) as the device counts."""

    times_s: FloatArray
    values: FloatArray


class Source(ABC):
    """What a reader reads. All but `name` and `rate_hz` is called from one thread at a time.

    Parameters
    ----------
    name : str
    rate_hz : float
        The nominal rate.
    n_channels : int
    """

    def __init__(self, name: str, rate_hz: float, n_channels: int) -> None:
        self.name, self.rate_hz, self.n_channels = name, rate_hz, n_channels

    @abstractmethod
    def open(self) -> None:
        """Raises `DeviceFailed` if the device is not there."""

    @abstractmethod
    def receive(self) -> SampleBlock | None:
        """The next samples; waits for about `POLL_S`, then None. Raises `DeviceFailed` if the device went away."""

    @abstractmethod
    def close(self) -> None:
        """May be called more than once."""

    def facts(self) -> dict[str, str | int | float | None]:
        """Counts of what was damaged or lost, and the drift of the clock."""
        return {}


class Listener:
    """What one part of the program has not read yet."""

    def __init__(self, n_channels: int) -> None:
        self._n_channels = n_channels
        self._blocks: deque[SampleBlock] = deque()

    def put(self, block: SampleBlock) -> None:
        if block.times_s.size == 0:
            return
        self._blocks.append(block)
        while self._blocks[0].times_s[-1] < block.times_s[-1] - KEPT_S:
            self._blocks.popleft()

    def read(self) -> SampleBlock:
        """All samples since the last call, in order; never waits."""
        # as many as there are now: the reader's thread may add to them meanwhile
        blocks = [self._blocks.popleft() for _ in range(len(self._blocks))]
        if not blocks:
            return SampleBlock(np.empty(0), np.empty((0, self._n_channels)))
        times_s = np.concatenate([block.times_s for block in blocks])
        return SampleBlock(times_s, np.concatenate([block.values for block in blocks]))

    def blocks(self, end_s: float, pause_s: float = 0.01) -> Iterator[SampleBlock]:
        """What comes until `end_s`, as it comes; asked for at every pause."""
        while now_s() < end_s:
            block = self.read()
            if block.times_s.size:
                yield block
            time.sleep(pause_s)


class Reader:
    """Reads a source in a thread, for all listeners, from `open` to `close`; looks for it again when it goes away.

    Whatever a source raises, it went away. What comes with stamps that arrival does not bear out is not told: that is
    an outage, too. Stamps are moved back by `delay_s`, by which the source is known to be late.
    """

    def __init__(self, source: Source, delay_s: float = 0.0) -> None:
        self.source, self._delay_s = source, delay_s
        self._subscribers: tuple[Callable[[SampleBlock], None], ...] = ()
        self._n_open = 0
        self._ending = threading.Event()
        self._thread: threading.Thread | None = None
        self._n_samples = 0
        self._n_outages = self._n_steps_back = 0
        self._arrivals = Arrivals()
        self._failure: str | None = None

    @property
    def failure(self) -> str | None:
        """Why it tells nothing, since it last did."""
        return self._failure

    def facts(self) -> dict[str, str | int | float | None]:
        counts = {"n_samples": self._n_samples, "n_outages": self._n_outages, "failure": self._failure}
        n_steps_back = self._n_steps_back + self._arrivals.n_steps_back
        return {**self.source.facts(), **counts, "n_steps_back": n_steps_back}

    def check_channels(self, where: str, *channels: int) -> None:
        """Refuse a channel (from 0) that the source does not have.

        Raises
        ------
        InvalidParameter
            In one sentence that opens with `where`.
        """
        last = self.source.n_channels - 1
        for channel in channels:
            expect(0 <= channel <= last, where, channel, f"from 0 to {last}, a channel of {self.source.name}")

    def listen(self) -> Listener:
        """Another listener; it hears what comes from now on."""
        listener = Listener(self.source.n_channels)
        self.subscribe(listener.put)
        return listener

    def subscribe(self, on_block: Callable[[SampleBlock], None]) -> Callable[[], None]:
        """Call `on_block` in the reader's thread with each block from now on, an empty one where nothing came.

        It ends when the function that is returned is called.
        """
        # a new tuple, never a list that grows: the reader's thread goes through the old one undisturbed
        self._subscribers = (*self._subscribers, on_block)
        return lambda: self._unsubscribe(on_block)

    def _unsubscribe(self, on_block: Callable[[SampleBlock], None]) -> None:
        self._subscribers = tuple(other for other in self._subscribers if other is not on_block)

    def open(self) -> None:
        """Begin to read; the second of two that share a reader changes nothing.

        Raises
        ------
        DeviceFailed
            If the device is not there.
        """
        if self._n_open == 0:
            self._open_source()
            self._ending.clear()
            self._thread = threading.Thread(target=self._run, name=f"reader of {self.source.name}", daemon=True)
            self._thread.start()
        self._n_open += 1

    def close(self) -> None:
        """End the thread when the last of those who opened has closed."""
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
            except Exception as error:  # whatever it was, the device is looked for again
                self._failure = str(self._as_failure(error))
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
            raise self._as_failure(error) from None

    def _as_failure(self, error: Exception) -> DeviceFailed:
        if isinstance(error, DeviceFailed):
            return error
        words = f"{type(error).__name__}: {' '.join(str(error).split())}"
        return DeviceFailed(f"{self.source.name}: found a failure ({words}), expected samples")

    def _take(self, block: SampleBlock | None) -> None:
        if block is None or block.times_s.size == 0:
            self._publish(None)
            return
        self._arrivals = self._arrivals.after(block.times_s, now_s())
        if self._arrivals.fault is not None:
            self._n_outages += self._failure is None
            self._failure = f"{self.source.name}: {self._arrivals.fault}"
            self._publish(None)
            return
        self._n_samples += block.times_s.size
        self._failure = None
        # a copy only where stamps move: listeners share the block
        self._publish(SampleBlock(block.times_s - self._delay_s, block.values) if self._delay_s else block)

    def _publish(self, block: SampleBlock | None) -> None:
        nothing = SampleBlock(np.empty(0), np.empty((0, self.source.n_channels)))
        for on_block in self._subscribers:
            on_block(nothing if block is None else block)

    def _find_again(self) -> None:
        next_s = now_s() + RETRY_S
        while not self._ending.wait(POLL_S):
            self._publish(None)
            if now_s() < next_s:
                continue
            next_s = now_s() + RETRY_S
            try:
                self._open_source()
            except DeviceFailed as error:
                self._failure = str(error)
            else:
                return


def now_s() -> float:
    """Our clock."""
    return time.perf_counter()
