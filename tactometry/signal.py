"""Samples with a rate and a unit, and the interface of stimuli."""

import hashlib
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from .arguments.require import as_array, expect, positive
from .errors import InvalidParameter, count_of

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Signal:
    """Samples that an output plays.

    - `samples`: Finite values in `unit`. Integers and booleans are converted. The array is made read-only.
    - `rate_hz`: Samples per second, above 0.
    - `unit`: Unit of the samples, such as ``"V"``.

    Raises `InvalidParameter` if the shape, the type of the values, a value or the rate is invalid.
    """

    samples: FloatArray
    rate_hz: float
    unit: str

    def __post_init__(self) -> None:
        samples = _real_numbers(self.samples)
        is_signal = samples.ndim == 2 and samples.shape[0] > 0
        expect(is_signal, "Signal.samples", f"shape {samples.shape}", "(n_channels, n_samples) with a channel")
        if not np.isfinite(samples).all():
            channel, sample = np.argwhere(~np.isfinite(samples))[0]
            where = f"Signal.samples[{channel}, {sample}]"
            raise InvalidParameter(f"{where}: found {samples[channel, sample]}, expected a finite number")
        positive("Signal", rate_hz=self.rate_hz)
        samples.setflags(write=False)
        object.__setattr__(self, "samples", samples)

    def __repr__(self) -> str:
        """Show the signal in one line.

        >>> Signal(np.ones((2, 500)), 1000.0, "V")
        Signal(2 channels x 500 samples at 1000 Hz (0.5 s), peak 1 V)
        """
        channels, samples = (
            count_of(n, what) for n, what in zip(self.samples.shape, ("channel", "sample"), strict=True)
        )
        times = f"at {self.rate_hz:g} Hz ({self.duration_s:g} s)"
        return f"Signal({channels} x {samples} {times}, peak {self.peak:g} {self.unit})"

    @property
    def duration_s(self) -> float:
        n_samples: int = self.samples.shape[1]
        return n_samples / self.rate_hz

    @property
    def peak(self) -> float:
        """Largest absolute sample in `unit`, or 0 for an empty signal."""
        return float(max(self.samples.max(initial=0.0), -self.samples.min(initial=0.0)))

    def __eq__(self, other: object) -> bool:
        """Compare what is played, so that a cache computes each waveform once.

        >>> volts, metres = (Signal(np.ones((1, 2)), 1000.0, unit) for unit in ("V", "m"))
        >>> volts == Signal(np.ones((1, 2)), 1000.0, "V"), volts == metres
        (True, False)
        """
        return isinstance(other, Signal) and self._digest == other._digest

    def __hash__(self) -> int:
        return hash(self._digest)

    def digest(self) -> str:
        """Return the first 16 digits of the SHA-256 of the signal."""
        return self._digest

    @cached_property
    def _digest(self) -> str:
        what = hashlib.sha256(f"{self.samples.shape} {self.rate_hz!r} {self.unit}\n".encode())
        what.update(self.samples.astype("<f8", copy=False).tobytes())
        return what.hexdigest()[:16]


def _real_numbers(values: object) -> FloatArray:
    """Copy values into an array of float, and refuse other types.

    >>> _real_numbers([[1, True]]).tolist()
    [[1.0, 1.0]]
    >>> _real_numbers(np.array([[1j]]))
    Traceback (most recent call last):
    tactometry.errors.InvalidParameter: Signal.samples: found values of type complex128, expected real numbers
    """
    expected = "real numbers"
    expect(not _is_masked(values), "Signal.samples", "a masked array", f"{expected}; fill the masked values")
    found = as_array(values)
    if found is None:
        raise InvalidParameter(f"Signal.samples: found rows that do not form an array, expected {expected}")
    expect(found.dtype.kind in "biuf", "Signal.samples", f"values of type {found.dtype!s:.60}", expected)
    with np.errstate(over="ignore"):  # a too large long double becomes infinite and is refused with its index
        return np.array(found, dtype=np.float64)


def _is_masked(values: object) -> bool:
    """Return True if values, or a part of a list, are a masked array."""
    if isinstance(values, list | tuple):
        return any(map(_is_masked, values))
    return isinstance(values, np.ma.MaskedArray)


class Stimulus(Protocol):
    """Family of signals ordered by level."""

    @property
    def level_unit(self) -> str:
        """Unit of a level, such as ``"dB re 1 V"``."""

    def at(self, level: float) -> Signal:
        """Return the signal of this level."""
