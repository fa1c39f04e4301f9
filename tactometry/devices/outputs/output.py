"""Interface of output drivers. Rigs use a driver only through its guard."""

import math
import time
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...arguments.require import not_negative
from ...errors import DeviceFailed
from ...position_dependent import FollowedSignal, PlayedPath
from ...signal import Signal
from .gain import Gain, SignalChain

RAMP_S = 0.005
"""Duration of the ramps of a signal that does not begin and end at zero (unverified default)."""
AT_REST_PART = 0.01
"""A signal that begins and ends below this fraction of its peak needs no ramp."""


LONGEST_WORD_S = 0.1
"""A device that requests no samples for longer plays none (unverified default)."""


class Driver(ABC):
    """Driver of one output, which emits zero unless it plays.

    - `connected`: True if the output leaves the computer.
    - `one_bit`: True if it emits only plus or minus one voltage, without ramps.
    - `emits`: False for a null output.
    - `full_scale_v`: Largest voltage that it can apply to the load.
    - `n_channels`, `rate_hz`: Required format of signals. None accepts any.
    - `follows`: True if it can play signals that follow a finger.
    """

    name: str
    connected: bool
    one_bit: bool = False
    emits: bool = True
    full_scale_v: float = math.inf
    n_channels: int | None = None
    rate_hz: float | None = None
    follows: bool = False

    @property
    def identity(self) -> str:
        """Name that identifies the output in the ledger, once it is open."""
        return self.name

    def facts(self) -> dict[str, str | int | float | None]:
        """Return facts on the open device and its failures for the journal."""
        return {}

    @property
    def reconstructs(self) -> bool:
        """True if a filter may raise the voltage between samples."""
        return self.connected and not self.one_bit

    @property
    def stop_delay_s(self) -> float:
        """Worst-case time from `stop` to zero, s. 0 if not connected."""
        return 0.0

    @property
    def fall_s(self) -> float:
        """Fall time of a stop, s. 0 for a single step."""
        return 0.0

    @abstractmethod
    def open(self) -> None:
        """Open the device with the output at zero. Raises `DeviceFailed`."""

    @abstractmethod
    def final(self, signal: Signal) -> Signal:
        """Return what `play` would emit on every channel, V at the load.

        Raises `DeviceFailed` if the driver cannot emit the signal.
        """

    @abstractmethod
    def play(self, signal: Signal) -> float:
        """Begin to play and return the onset on `time.perf_counter`, s.

        The signal is finite, and the output is at zero after it.
        """

    def played_path(self) -> PlayedPath | None:
        """Wait for the end of a signal that followed a finger, and return it."""
        return None

    def n_gaps(self, longest_wait_s: float = LONGEST_WORD_S) -> int | None:
        """Return the gaps of the last signal, or None if they are unknown.

        Waits at most `longest_wait_s` for the device to report a current gap.
        """
        del longest_wait_s
        return None

    @abstractmethod
    def stop(self) -> None:
        """Set the output to zero, even if it is idle or closed."""

    @abstractmethod
    def close(self) -> None:
        """Set the output to zero and release the device. May be repeated."""


class AmplifiedDriver(Driver):
    """Driver that leads to an amplifier, with known channels, rate and gain."""

    connected = True
    n_channels: int
    rate_hz: float

    def __init__(self, name: str, n_channels: int, rate_hz: float, gain: Gain) -> None:
        self.name, self.n_channels, self.rate_hz = name, n_channels, rate_hz
        self.full_scale_v, self._gain = gain.load_volts_per_unit, gain


class UnconnectedDriver(Driver):
    """Driver whose output is not connected and needs no stop."""

    connected = False

    def stop(self) -> None:
        pass

    def close(self) -> None:
        pass


class NullOutput(UnconnectedDriver):
    """Driver that emits nothing and accepts any channels and rate."""

    name = "null"
    emits = False

    def __init__(self, n_channels: int | None = None, rate_hz: float | None = None) -> None:
        self.n_channels, self.rate_hz = n_channels, rate_hz

    def open(self) -> None:
        pass

    def final(self, signal: Signal) -> Signal:
        return signal

    def play(self, signal: Signal) -> float:
        del signal
        return time.perf_counter()


@dataclass(frozen=True)
class NullSettings:
    """Null output, which plays nothing and has no settings."""

    connected: ClassVar[bool] = False

    def driver(self, gain: Gain | None) -> NullOutput:
        del gain
        return NullOutput()

    def chain(self) -> SignalChain:
        return SignalChain("null")


REMEDIES = {
    "n_channels": "name one output channel for each channel of the stimulus, and for kind = 'packed' the electrode",
    "rate_hz": "state this rate_hz in [stimulus] of the study (or its setup), or change it in [output]",
}


def check_format(signal: Signal, output: Driver) -> None:
    """Refuse a signal whose channels or rate differ from those of `output`."""
    if isinstance(signal, FollowedSignal):
        expect_following(output)
    of_signal = {"n_channels": signal.samples.shape[0], "rate_hz": signal.rate_hz}
    for name, value in of_signal.items():
        expected = getattr(output, name)
        if expected is not None and value != expected:
            raise DeviceFailed(
                f"output {output.name!r}: found a signal with {name} {value:g}, expected {expected:g}; "
                f"{REMEDIES[name]}; nothing was played"
            )


def expect_following(output: Driver) -> None:
    """Refuse a texture if the output cannot play signals that follow a finger."""
    if output.emits and not output.follows:
        raise DeviceFailed(
            f"output {output.name!r}: found a texture, whose signal follows the finger, expected a signal known "
            "at its onset; use kind = 'audio'; nothing was played"
        )


def with_ramps(signal: Signal, ramp_s: float) -> Signal:
    """Add raised-cosine ramps, unless a signal begins and ends near zero.

    A signal shorter than two ramps has ramps of half its length.

    >>> step = Signal(np.ones((1, 100)), rate_hz=1000.0, unit="V")
    >>> with_ramps(step, 0.01).samples[0, [0, 4, 50, 99]].round(3).tolist()
    [0.0, 0.345, 1.0, 0.0]
    >>> rising = with_ramps(step, 0.01)
    >>> with_ramps(rising, 0.01) is rising
    True
    """
    not_negative("with_ramps", ramp_s=ramp_s)
    n_samples = signal.samples.shape[1]
    n_ramp = min(round(ramp_s * signal.rate_hz), n_samples // 2)
    if n_ramp == 0:
        return signal
    ends = np.abs(signal.samples[:, [0, -1]])
    if np.max(ends) <= AT_REST_PART * signal.peak:
        return signal
    rise = 0.5 - 0.5 * np.cos(np.pi * np.arange(n_ramp) / n_ramp)
    envelope = np.ones(n_samples)
    envelope[:n_ramp], envelope[-n_ramp:] = rise, rise[::-1]
    return Signal(signal.samples * envelope, signal.rate_hz, signal.unit)
