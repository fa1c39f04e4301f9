"""Guard of every driver, which plays only signals within the limits."""

import functools
import math
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

from ...errors import LimitExceeded
from ...position_dependent import FollowedSignal, PlayedPath
from ...safety.limits import Exposure, Limits
from ...safety.load import Load, PassedCharge
from ...signal import Signal
from .emission_ledger import Emissions, Ledger
from .output import LONGEST_WORD_S, Driver, check_format

OnSignal = Callable[[float, float, float], None]
"""Called at the beginning of a signal: onset, s on `time.perf_counter`, duration, s, and largest charge through the
leak, C."""
OnEnd = Callable[[float], None]
"""Called once after the end of each signal: the charge that it passed through the leak, C."""


@dataclass(frozen=True)
class _Playing:
    """Last signal, with times on the clock of the guard."""

    onset_s: float
    duration_s: float
    charge: PassedCharge | None

    def is_over(self, at_s: float) -> bool:
        return at_s >= self.onset_s + self.duration_s

    def passed_c(self, at_s: float, late_s: float) -> float:
        """Return the charge passed if the signal ends at `at_s`."""
        if self.charge is None:
            return 0.0
        return self.charge.net_c if self.is_over(at_s) else self.charge.stopped_c(at_s - self.onset_s, late_s)


@dataclass(eq=False)
class Guarded:
    """Output that checks its driver's final samples and its playing time.

    - `limits`: Limits of the output. With None nothing is played.
    - `load`: Connected load. None only for a driver that is not connected.
    - `clock`: Function that returns the time, s.
    - `ledger`: Earlier emissions of the output. With None, counting starts when the output is opened.
    """

    driver: Driver
    limits: Limits | None
    load: Load | None = None
    clock: Callable[[], float] = time.perf_counter
    ledger: Ledger | None = None

    def __post_init__(self) -> None:
        self._exposure = Exposure(self.clock())
        self._before: Exposure | None = None
        self._on_signal: OnSignal = lambda onset_s, duration_s, charge_c: None
        self._on_end: OnEnd = lambda charge_c: None
        self._playing: _Playing | None = None
        self._counting = threading.Lock()
        self._final = functools.lru_cache(maxsize=1)(self._keep_to_limits)

    @property
    def name(self) -> str:
        return self.driver.name

    @property
    def emits(self) -> bool:
        """False for a null output."""
        return self.driver.emits

    def count_on(self, before: Exposure) -> None:
        """Continue from an earlier exposure, on the clock of this guard."""
        self._before = before

    def subscribe(self, on_signal: OnSignal, on_end: OnEnd = lambda charge_c: None) -> None:
        """Report begin and end of each signal, in the thread that causes it."""
        self._on_signal, self._on_end = on_signal, on_end

    def open(self) -> None:
        """Open the device and the ledger.

        Raises `LimitExceeded` if a required limit is missing or a stop may take too long, `DeviceFailed` if the
        device or the ledger does not open. The device is closed then.
        """
        limits = self._require_limits()
        self.driver.open()
        try:  # checked now, because the open device has reported its buffer
            limits.check_stop(self.driver.stop_delay_s)
            if self.ledger is not None:
                self.ledger.open(self.driver.identity)
        except BaseException:
            self.driver.close()
            raise
        self._exposure = Exposure(self.clock()) if self._before is None else self._before
        self._counting = threading.Lock()

    def play(self, signal: Signal) -> float:
        """Check all limits on the final samples, play, and return the onset.

        Raises `LimitExceeded` or `DeviceFailed` before anything is played.
        """
        limits, final = self.check(signal)
        charge = None if self.load is None else self.load.passed_c(final, _rise_s(signal))
        largest_c = 0.0 if charge is None else charge.largest_c
        now_s = self.clock()
        if self._playing is not None and self._playing.is_over(now_s):
            self._end_playing(now_s)
        self._count(limits, now_s, final.duration_s, largest_c)
        self._end_playing(now_s)  # the new signal replaces it
        try:
            onset_s = self.driver.play(signal)
        except (KeyboardInterrupt, SystemExit):  # the signal may already have begun
            self._begin(time.perf_counter(), limits, final.duration_s, charge, largest_c)
            raise
        self._begin(onset_s, limits, final.duration_s, charge, largest_c)
        return onset_s

    def _begin(
        self, onset_s: float, limits: Limits, duration_s: float, charge: PassedCharge | None, largest_c: float
    ) -> None:
        """Count and report a signal that the driver has begun."""
        with self._counting:
            # read the clock again: a driver may first fade the previous signal
            now_s = self.clock()
            self._exposure = self._exposure.after(now_s, duration_s, limits.duty_window_s, largest_c)
            self._playing = _Playing(now_s + onset_s - time.perf_counter(), duration_s, charge)
        if self.emits:
            self._on_signal(onset_s, duration_s, largest_c)

    def _count(self, limits: Limits, now_s: float, duration_s: float, charge_c: float) -> None:
        """Check a signal against earlier emissions and enter it in the ledger."""

        def allow(emitted: Emissions) -> None:
            others_s = ((now_s - ago_s, now_s - ago_s + other_s) for ago_s, other_s in emitted)
            limits.check_exposure(self._exposure.with_others(others_s), now_s, duration_s, charge_c)

        if self.ledger is None or not self.ledger.is_open:  # a closed driver plays nothing
            allow(())
        else:
            self.ledger.add(duration_s, allow)

    def _end_playing(self, at_s: float) -> None:
        """Count the charge until `at_s`, or after gaps the largest possible charge."""
        with self._counting:
            playing, self._playing = self._playing, None
            if playing is None:
                return
            passed_c = playing.passed_c(at_s, min(self.driver.stop_delay_s, playing.duration_s))
            if self.driver.n_gaps(0.0):
                passed_c = self._exposure.playing_c
            self._exposure = self._exposure.passed(passed_c)
        if self.emits:
            self._on_end(passed_c)

    def check(self, signal: Signal) -> tuple[Limits, Signal]:
        """Return limits and final samples. Raises the same errors as `play`."""
        limits = self._require_limits()
        return limits, self._final(signal, limits)

    def _keep_to_limits(self, signal: Signal, limits: Limits) -> Signal:
        # check both the requested signal and its rounded and clipped version
        limits.check(signal)
        check_format(signal, self.driver)
        final = self.driver.final(signal)
        limits.check(final)
        if self.load is not None:
            limits.check_load(final, self.load, _rise_s(signal))
        if self.driver.reconstructs:
            limits.check_filtered(final, self.load, _rise_s(signal))
        return final

    def played_path(self) -> PlayedPath | None:
        """Return the path and signal played last, if it followed a finger."""
        return self.driver.played_path()

    def n_gaps(self, longest_wait_s: float = LONGEST_WORD_S) -> int | None:
        return self.driver.n_gaps(longest_wait_s)

    def stop(self) -> None:
        at_s = self.clock()  # reported before the driver stops, which may wait until the device is at zero
        self.driver.stop()
        if self.ledger is not None:
            self.ledger.end(self.driver.stop_delay_s)
        self._end_playing(at_s)
        with self._counting:
            self._exposure = self._exposure.stopped(self.clock())

    def close(self) -> None:
        self._end_playing(self.clock())
        self.driver.close()
        if self.ledger is not None:
            self.ledger.end(self.driver.stop_delay_s)
            self.ledger.close()

    def _require_limits(self) -> Limits:
        if self.limits is None:
            raise LimitExceeded(
                f"output {self.name!r}: found no limits, expected limits for the connected load; state them in the "
                "bench or study file; nothing was played"
            )
        if self.load is not None:
            self.limits.check_stated(self.load)
        elif self.driver.connected:
            raise LimitExceeded(
                f"output {self.name!r}: found no load, expected kind and capacitance_f of the connected load; state "
                "them in the bench file; nothing was played"
            )
        return self.limits


def _rise_s(signal: Signal) -> float:
    """Return the shortest rise time of a followed signal, or infinity."""
    return signal.stimulus.rise_s if isinstance(signal, FollowedSignal) else math.inf
