"""Start and stop of the stimulus in the sensor threads, independent of the display."""

import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from ...devices.clock_map import BEGIN_WITHIN_S
from ...devices.sensors.streamed import OnSamples, StreamedSensor
from ...signal import FloatArray

TURN_S = 0.002
"""Thread switch interval until the decision; Python's default is 5 ms."""


class Trigger:
    """Trigger that fires once when `opens` is true and stops when `breaks` is.

    Any thread calls `consider` after each block of samples. The call never waits for another one. `fire` returns the
    onset on `time.perf_counter`, s, or None if playback is not allowed now.
    """

    def __init__(
        self,
        opens: Callable[[], bool],
        breaks: Callable[[], bool],
        fire: Callable[[], float | None],
        stop: Callable[[], None],
    ) -> None:
        self._opens, self._breaks, self._fire, self._stop = opens, breaks, fire, stop
        self._lock = threading.Lock()
        self._step: Callable[[], None] | None = self._begin
        self._failure: BaseException | None = None
        self._begun: tuple[float, float] | None = None
        self._broken = False

    @property
    def begun(self) -> tuple[float, float] | None:
        """Return decision time and onset, or None. Raises errors of `fire` and `stop`."""
        self._raise_failure()
        return self._begun

    @property
    def broken(self) -> bool:
        """Return True if the stimulus was stopped. Raises like `begun`."""
        self._raise_failure()
        return self._broken

    def _raise_failure(self) -> None:
        if self._failure is not None:
            raise self._failure

    def consider(self) -> None:
        if self._lock.acquire(blocking=False):
            try:
                if self._step is not None:
                    self._step()
            except BaseException as error:  # raised later in the session's thread
                self._step, self._failure = None, error
            finally:
                self._lock.release()

    def _begin(self) -> None:
        if self._opens():
            decided_s = time.perf_counter()  # read before the output begins, so that `delay_s` excludes its start
            onset_s = self._fire()
            if onset_s is not None:
                self._begun, self._step = (decided_s, onset_s), self._watch

    def _watch(self) -> None:
        if self._breaks():
            self._step, self._broken = None, True
            self._stop()

    def disarm(self, longest_s: float = BEGIN_WITHIN_S) -> None:
        """Disable the trigger; wait for a running call, at most `longest_s`."""
        is_free = self._lock.acquire(timeout=longest_s)
        self._step = None  # even without the lock: a call that hangs has already fired
        if is_free:
            self._lock.release()


@contextmanager
def quick_turns() -> Iterator[None]:
    """Switch threads every `TURN_S`, so that drawing does not delay sensors."""
    usual_s = sys.getswitchinterval()
    sys.setswitchinterval(min(TURN_S, usual_s))
    try:
        yield
    finally:
        sys.setswitchinterval(usual_s)


@contextmanager
def receiving(
    sensor: StreamedSensor | None, on_samples: OnSamples, then: Callable[[], None] = lambda: None
) -> Iterator[None]:
    """Pass samples to `on_samples` and call `then`, in the sensor's thread."""
    if sensor is None:
        yield
        return

    def pass_on(times_s: FloatArray, values: FloatArray) -> None:
        on_samples(times_s, values)
        then()

    end = sensor.subscribe(pass_on)
    try:
        yield
    finally:
        end()
