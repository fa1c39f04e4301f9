"""The guard before every driver: nothing reaches a load that its limits do not allow."""

import functools
import math
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

from ...errors import LimitExceeded
from ...followed import Course, FollowedSignal
from ...safety.limits import Exposure, Limits
from ...safety.load import Load
from ...signal import Signal
from .output import LONGEST_WORD_S, Driver, check_format

OnSignal = Callable[[float, float, float], None]
"""What is told of a signal: onset, s on `time.perf_counter`, duration, s, and net charge through the leak, C."""


@dataclass(eq=False)
class Guarded:
    """An output that checks the final samples of its driver, and how often and how long it played.

    Parameters
    ----------
    driver : Driver
    limits : Limits or None
        None: nothing is played.
    load : Load or None
        What is connected; None only for a driver that is not connected to anything.
    clock : callable
        Seconds; by default `time.perf_counter`.
    """

    driver: Driver
    limits: Limits | None
    load: Load | None = None
    clock: Callable[[], float] = time.perf_counter

    def __post_init__(self) -> None:
        self._exposure = Exposure(self.clock())
        self._before: Exposure | None = None
        self._on_signal: OnSignal = lambda onset_s, duration_s, charge_c: None
        self._counting = threading.Lock()
        self._final = functools.lru_cache(maxsize=1)(self._keep_to_limits)

    @property
    def name(self) -> str:
        return self.driver.name

    @property
    def emits(self) -> bool:
        """Whether anything comes of what is played: nothing does of a null output."""
        return self.driver.emits

    def count_on(self, before: Exposure) -> None:
        """Count on from what was emitted before: `before` is on the clock of this guard."""
        self._before = before

    def subscribe(self, on_signal: OnSignal) -> None:
        """Call `on_signal` with whatever is emitted from now on, as it begins, in the thread that plays."""
        self._on_signal = on_signal

    def open(self) -> None:
        """Claim the device, if its limits are stated.

        Raises
        ------
        LimitExceeded
            If a limit that the load needs is missing, or a stop may take too long; the device is closed.
        """
        limits = self._require_limits()
        self.driver.open()
        try:  # now that the device has said how much it buffers
            limits.check_stop(self.driver.stop_delay_s)
        except LimitExceeded:
            self.driver.close()
            raise
        self._exposure = Exposure(self.clock()) if self._before is None else self._before
        self._counting = threading.Lock()

    def play(self, signal: Signal) -> float:
        """Check all limits on the final samples, then begin to emit.

        Raises
        ------
        LimitExceeded, DeviceFailed
            If the signal must not or cannot be played; nothing was.
        """
        limits, final = self.check(signal)
        charge_c = 0.0 if self.load is None else self.load.charge_net_c(final, _rise_s(signal))
        limits.check_exposure(self._exposure, self.clock(), final.duration_s, charge_c)
        onset_s = self.driver.play(signal)
        with self._counting:
            # the clock anew: a driver may let the signal before fall to zero first
            self._exposure = self._exposure.after(self.clock(), final.duration_s, limits.duty_window_s, charge_c)
        if self.emits:
            self._on_signal(onset_s, final.duration_s, charge_c)
        return onset_s

    def check(self, signal: Signal) -> tuple[Limits, Signal]:
        """The limits and the final samples of a signal that keeps them; `play` does not compute them again.

        Raises
        ------
        LimitExceeded, DeviceFailed
            If the signal must not or cannot be played.
        """
        limits = self._require_limits()
        return limits, self._final(signal, limits)

    def _keep_to_limits(self, signal: Signal, limits: Limits) -> Signal:
        # twice: what was asked for, and what rounding and clipping make of it
        limits.check(signal)
        check_format(signal, self.driver)
        final = self.driver.final(signal)
        limits.check(final)
        if self.load is not None:
            limits.check_load(final, self.load, _rise_s(signal))
        return final

    def course(self) -> Course | None:
        """What the last signal became, where it followed a finger."""
        return self.driver.course()

    def n_gaps(self, longest_wait_s: float = LONGEST_WORD_S) -> int | None:
        """Gaps of the last signal, as its driver tells them."""
        return self.driver.n_gaps(longest_wait_s)

    def stop(self) -> None:
        self.driver.stop()
        with self._counting:
            self._exposure = self._exposure.stopped(self.clock())

    def close(self) -> None:
        self.driver.close()

    def _require_limits(self) -> Limits:
        if self.limits is None:
            raise LimitExceeded(
                f"output {self.name!r}: found no limits, expected those of what is connected; state them in the bench "
                "or study file; nothing was played"
            )
        if self.load is not None:
            self.limits.check_stated(self.load)
        elif self.driver.connected:
            raise LimitExceeded(
                f"output {self.name!r}: found no load, expected what is connected to it, by kind and capacitance_f; "
                "state it in the bench file; nothing was played"
            )
        return self.limits


def _rise_s(signal: Signal) -> float:
    """How fast a signal that follows a finger may rise from nothing to all; infinite of another."""
    return signal.stimulus.rise_s if isinstance(signal, FollowedSignal) else math.inf
