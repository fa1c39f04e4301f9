"""Rendering, checking and playing of stimuli by name and level."""

import functools
import threading
import time
from collections.abc import Mapping
from typing import Final

from ..arguments.require import expect, lookup
from ..devices.clock_map import BEGIN_WITHIN_S
from ..devices.outputs.guarded import Guarded
from ..devices.outputs.output import LONGEST_WORD_S, RAMP_S, with_ramps
from ..errors import DeviceFailed, InvalidParameter
from ..position_dependent import FingerPath, FollowedSignal, FollowsFinger, PlayedPath
from ..safety.limits import Limits
from ..signal import Signal, Stimulus

NO_POSITION: Final = (
    "position: found none, expected the sensor that tells where the finger is, as a texture follows it; state "
    "[position] in the bench file, with its sensor; nothing was played"
)


def render(bank: Mapping[str, Stimulus], name: str, level: float, limits: Limits | None, ramp_s: float = 0.0) -> Signal:
    """Return the final samples of a stimulus, with ramps if needed.

    A signal that begins and ends at zero gets no ramps. Raises `InvalidParameter` if the stimulus or level does not
    exist, `LimitExceeded` if the signal exceeds a limit of the study.
    """
    signal = with_ramps(lookup("stimulus", name, bank).at(level), ramp_s)
    if limits is not None:
        limits.check(signal)
    return signal


class Emitter:
    """Player of stimuli, which checks the limits of study and output."""

    def __init__(
        self,
        bank: Mapping[str, Stimulus],
        output: Guarded,
        limits: Limits | None,
        ramp_s: float = RAMP_S,
        path: FingerPath | None = None,
    ) -> None:
        self._bank, self._output, self._limits, self._ramp_s, self._path = bank, output, limits, ramp_s, path
        self._playing = threading.Lock()
        self._muted = False

    def final(self, name: str, level: float) -> Signal:
        """Return the final samples of a stimulus, checked against all limits.

        Raises `InvalidParameter` if the stimulus does not exist, `LimitExceeded` if it exceeds a limit,
        `DeviceFailed` if the output cannot play it.
        """
        signal = self._followed(name, render(self._bank, name, level, self._limits, self._ramp_s))
        # checked before the touch begins; the guard checks again during playback
        self._output.check(signal)
        return signal

    def _followed(self, name: str, signal: Signal) -> Signal:
        """Attach the finger's path to a texture that follows it, if it is emitted."""
        stimulus = self._bank[name]
        if not isinstance(stimulus, FollowsFinger) or not self._output.emits:
            return signal
        if self._path is None:
            raise InvalidParameter(NO_POSITION)
        return FollowedSignal(signal.samples, signal.rate_hz, signal.unit, stimulus, self._path)

    def played_path(self, signal: Signal | None) -> PlayedPath | None:
        """Return the path and signal played last, if it followed a finger."""
        return self._output.played_path() if isinstance(signal, FollowedSignal) else None

    def followed_signal(self, digest: str) -> Signal | None:
        """Return the last emitted signal if it followed a finger and has this digest."""
        path = self._output.played_path()
        return path.signal if path is not None and path.signal.digest() == digest else None

    def for_interval(self, name: str, level: float | None, duration_s: float) -> Signal | None:
        """Return the final samples for an interval, or None for a blank.

        Raises `InvalidParameter` if the signal is longer than its interval.
        """
        if level is None:
            return None
        signal = self.final(name, level)
        longest = f"at most the {duration_s:.6g} s of its interval; shorten the signal or extend the interval"
        fits = signal.duration_s <= duration_s + 1 / signal.rate_hz
        expect(fits, f"stimulus {name!r}", f"a signal of {signal.duration_s:.6g} s", longest)
        return signal

    def limit_facts(self) -> dict[str, float | str]:
        """Return the limits that apply: the tighter of the study's and the output's."""
        stated = [limits for limits in (self._limits, self._output.limits) if limits is not None]
        return functools.reduce(Limits.tighter, stated).facts() if stated else {}

    def level_delivered(self, level: float | None) -> float | None:
        """Return the delivered level, or None if the output emits nothing."""
        return level if self._output.emits else None

    def digest(self, signal: Signal | None) -> str | None:
        """Return the digest of the emitted signal, or None if there was none."""
        if signal is None or not self._output.emits:
            return None
        path = self.played_path(signal)
        return signal.digest() if path is None else path.signal.digest()

    def emit(self, signal: Signal | None) -> float:
        """Begin playback, if any, and return the onset on `time.perf_counter`, s."""
        return time.perf_counter() if signal is None else self._output.play(signal)

    def emit_if_allowed(self, signal: Signal | None) -> float | None:
        """Emit from any thread. Return None while muted."""
        with self._playing:
            return None if self._muted else self.emit(signal)

    def mute(self, *, on: bool) -> None:
        """Set the output to zero. While `on`, no thread can emit."""
        # stop at once; a thread that is just beginning to play is stopped again below
        self._output.stop()
        if not self._playing.acquire(timeout=BEGIN_WITHIN_S):
            raise DeviceFailed(
                f"output {self._output.name!r}: it hangs and did not begin within {BEGIN_WITHIN_S:g} s: switch its "
                "amplifier off"
            )
        try:
            self._muted = on
            self._output.stop()
        finally:
            self._playing.release()

    def n_gaps(self, signal: Signal | None, longest_wait_s: float = LONGEST_WORD_S) -> int | None:
        """Return the gaps in the last signal, or None if they are unknown."""
        return None if signal is None else self._output.n_gaps(longest_wait_s)

    def stop(self) -> None:
        self._output.stop()
