"""What measures the finger's force: the seam of every force sensor."""

from typing import Protocol

from .reader import Told


class ForceSensor(Told, Protocol):
    """A stream of forces, N, (n_samples,), each stamped where it was taken.

    A driver reads its device in a thread of its own, so that drawing never starves it. Stamps are seconds on
    `time.perf_counter`; a sample that the device knows to be lost is NaN.
    """

    @property
    def name(self) -> str: ...

    @property
    def rate_hz(self) -> float:
        """The nominal rate of the samples."""

    @property
    def failure(self) -> str | None:
        """Why it says nothing, where that is known."""

    def open(self) -> None:
        """Begin to collect. Raises `DeviceFailed`."""

    def close(self) -> None:
        """Let go of the device; may be called more than once."""
