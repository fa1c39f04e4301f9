"""What makes samples into voltage: the seam of every output driver, which a rig reaches through its guard alone."""

import math
import time
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...arguments.require import not_negative
from ...errors import DeviceFailed
from ...followed import Course, FollowedSignal
from ...signal import Signal
from .gain import Gain, SignalChain

RAMP_S = 0.005
"""Ramps of a signal that does not begin and end at rest by itself (unverified default)."""
AT_REST_PART = 0.01
"""A signal that begins and ends below this part of its peak needs no ramp."""


LONGEST_WORD_S = 0.1
"""A device that asks for no samples for so long plays none (unverified default)."""


class Driver(ABC):
    """A driver of one output. It emits nothing but what `play` was given, and zero otherwise.

    - `connected`: Whether what it emits leaves the computer.
    - `one_bit`: Whether it emits nothing but plus or minus one voltage, without ramps.
    - `emits`: Whether anything comes of what is played.
    - `full_scale_v`: The largest voltage that it can put on the load.
    - `n_channels`, `rate_hz`: None for a driver that takes any.
    - `follows`: Whether it asks a signal that follows a finger where that is, sample by sample.
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
        """Name of the output on this computer, under which its exposure is counted; of a card, once it is open."""
        return self.name

    def facts(self) -> dict[str, str | int | float | None]:
        """What the journal says of the device after it was opened, and of what went wrong since."""
        return {}

    @property
    def reconstructs(self) -> bool:
        """Whether a filter makes a continuous voltage of the samples, which may be larger between them.

        True unless nothing is connected or the output switches between two voltages.
        """
        return self.connected and not self.one_bit

    @property
    def stop_delay_s(self) -> float:
        """Worst-case time from the call of `stop` to zero at the load, s; 0 where nothing is connected."""
        return 0.0

    @property
    def fall_s(self) -> float:
        """Time over which a stop falls from the signal to zero, s; 0 where it is one step of the device."""
        return 0.0

    @abstractmethod
    def open(self) -> None:
        """Claim the device, at zero. Raises `DeviceFailed`."""

    @abstractmethod
    def final(self, signal: Signal) -> Signal:
        """What `play` would emit, in volts at the load, sample by sample: rounded, clipped, on every channel.

        Raises `DeviceFailed` where the driver cannot emit the signal.
        """

    @abstractmethod
    def play(self, signal: Signal) -> float:
        """Begin to emit and return at once: the time of the first sample on `time.perf_counter`, s.

        The signal is finite: after its last sample the output is at zero without being told.
        """

    def course(self) -> Course | None:
        """What the last signal became, where it followed a finger; waited for until it is over."""
        return None

    def n_gaps(self, longest_wait_s: float = LONGEST_WORD_S) -> int | None:
        """Gaps since the last signal began, up to its end; None where the device cannot tell.

        It waits until the device has said whether there was one just now, `longest_wait_s` at most.
        """
        del longest_wait_s
        return None

    @abstractmethod
    def stop(self) -> None:
        """Zero now; not an error when nothing plays or the device is closed."""

    @abstractmethod
    def close(self) -> None:
        """Zero, and let go of the device; may be called more than once."""


class AmplifiedDriver(Driver):
    """A driver that leads out of the computer, to an amplifier: its channels, its rate and its gain are known."""

    connected = True
    n_channels: int
    rate_hz: float

    def __init__(self, name: str, n_channels: int, rate_hz: float, gain: Gain) -> None:
        self.name, self.n_channels, self.rate_hz = name, n_channels, rate_hz
        self.full_scale_v, self._gain = gain.load_volts_per_unit, gain


class UnconnectedDriver(Driver):
    """A driver to which nothing is connected that would have to be put to zero."""

    connected = False

    def stop(self) -> None:
        pass

    def close(self) -> None:
        pass


class NullOutput(UnconnectedDriver):
    """A driver of which nothing comes: any channels, any rate."""

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
    """No output: nothing is played, and there is nothing to set."""

    connected: ClassVar[bool] = False

    def driver(self, gain: Gain | None) -> NullOutput:
        del gain
        return NullOutput()

    def chain(self) -> SignalChain:
        return SignalChain("null")


REMEDIES = {
    "n_channels": "name one outlet of the output for each channel of the stimulus, and of a packed one the electrode",
    "rate_hz": "state that rate_hz in the study's [stimulus] (or its setup), or another one in [output]",
}


def check_format(signal: Signal, output: Driver) -> None:
    """Refuse a signal that is not of the channels or the rate that `output` has."""
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
    """Refuse a texture where the output takes no signal that follows a finger."""
    if output.emits and not output.follows:
        raise DeviceFailed(
            f"output {output.name!r}: found a texture, whose signal follows the finger, expected one that is known "
            "when it begins; play it through kind = 'audio'; nothing was played"
        )


def with_ramps(signal: Signal, ramp_s: float) -> Signal:
    """`signal` with raised-cosine ramps of `ramp_s`, unless each channel begins and ends at rest.

    At rest is below 1 % of the signal's peak. A signal shorter than two ramps has ramps of half its length.

    Raises `InvalidParameter` if `ramp_s` is not a finite number of at least 0.

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
