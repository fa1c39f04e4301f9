"""Touch screen or mouse on Linux as a position sensor.

The kernel writes records of 24 bytes (``struct input_event`` of a 64-bit system: seconds, microseconds, type, code,
value). A record of type 0 and code 0 ends a sample. Absolute axes are the first contact of a touch screen, relative
axes the summed steps of a mouse. Tested with records through a pipe, not with a touch screen.
"""

import os
import select
import struct
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from ...arguments.constraints import Positive, constrained
from ...errors import DeviceFailed, attempt
from .reader import SampleBlock, SensorSettings, Source, now_s

EVENT: Final = struct.Struct("=qqHHi")
# names in the kernel's header linux/input.h: EV_SYN, EV_REL, EV_ABS
SYNC, RELATIVE, ABSOLUTE = 0, 2, 3
# ABS_X and ABS_Y, ABS_MT_POSITION_X and _Y, ABS_MT_PRESSURE
AXES: Final = {(ABSOLUTE, 0): 0, (ABSOLUTE, 1): 1, (ABSOLUTE, 53): 0, (ABSOLUTE, 54): 1, (ABSOLUTE, 58): 2}
# REL_X, REL_Y
STEPS: Final = {(RELATIVE, 0): 0, (RELATIVE, 1): 1}
# ABS_MT_TRACKING_ID: at least 0 when a finger lands, -1 when it lifts
TRACKING: Final = (ABSOLUTE, 57)
# EVIOCSCLOCKID, and CLOCK_MONOTONIC, which `time.perf_counter` reads on Linux
SET_CLOCK, MONOTONIC = 0x400445A0, 1
HELD_S = 0.01
"""Interval at which the position of a resting finger is repeated, as the device then sends nothing."""


@dataclass(frozen=True)
@constrained
class TouchSettings(SensorSettings):
    """Touch screen, whose channels are x, y and pressure.

    - `path`: Device file of the touch screen, such as ``/dev/input/event5``.
    - `rate_hz`: Report rate for a moving finger.
    """

    path: str
    rate_hz: Positive = 100.0

    def source(self) -> "TouchSource":
        return TouchSource(self)


@dataclass(frozen=True)
class TrackedFinger:
    """Position of a finger; `touching` is True from landing to lift."""

    values: tuple[float, float, float] = (0.0, 0.0, 0.0)
    touching: bool = False

    def after(self, kind: int, code: int, value: int) -> "TrackedFinger":
        """Return the finger after an event.

        >>> TrackedFinger().after(ABSOLUTE, 53, 120).after(RELATIVE, 1, -3).values
        (120.0, -3.0, 0.0)
        >>> TrackedFinger().after(*TRACKING, 7).touching, TrackedFinger().after(*TRACKING, -1).touching
        (True, False)
        """
        if (kind, code) == TRACKING:
            return replace(self, touching=value >= 0)
        if (kind, code) in AXES:
            return self._with(AXES[kind, code], float(value))
        if (kind, code) in STEPS:
            axis = STEPS[kind, code]
            return replace(self._with(axis, self.values[axis] + value), touching=True)
        return self

    def _with(self, axis: int, value: float) -> "TrackedFinger":
        x, y, pressure = (value if n == axis else old for n, old in enumerate(self.values))
        return replace(self, values=(x, y, pressure))


class TouchSource(Source):
    """Samples at each report, repeated while a finger rests."""

    def __init__(self, settings: TouchSettings) -> None:
        super().__init__(f"touch {settings.path}", settings.rate_hz, n_channels=3)
        self._path = Path(settings.path)
        self._file: int | None = None
        self._stamped = False

    def facts(self) -> dict[str, str | int | float | None]:
        return {"stamped_by": "kernel" if self._stamped else "arrival"}

    def open(self) -> None:
        with attempt(self.name, "cannot open it", "a readable event device"):
            self._file = os.open(self._path, os.O_RDONLY | os.O_NONBLOCK)
        self._stamped = _set_clock(self._file)
        self._finger = self._reported = TrackedFinger()
        self._rest = b""

    def receive(self) -> SampleBlock | None:
        if self._file is None:
            raise DeviceFailed(f"{self.name}: the device is closed")
        try:
            ready, _, _ = select.select([self._file], [], [], HELD_S)
            data = os.read(self._file, 64 * EVENT.size) if ready else b""
        except OSError as error:
            raise DeviceFailed(f"{self.name}: the device was disconnected ({error.strerror})") from None
        if ready and not data:
            raise DeviceFailed(f"{self.name}: the device was disconnected")
        if ready:
            return self._block(data)
        return SampleBlock(np.array([now_s()]), np.array([self._reported.values])) if self._reported.touching else None

    def _block(self, data: bytes) -> SampleBlock | None:
        stream, arrival_s = self._rest + data, now_s()
        whole = len(stream) // EVENT.size * EVENT.size
        self._rest = stream[whole:]
        samples = []
        for seconds, microseconds, kind, code, value in EVENT.iter_unpack(stream[:whole]):
            self._finger = self._finger.after(kind, code, value)
            if kind != SYNC:  # between two reports a position is partly old
                continue
            self._reported = self._finger
            if self._finger.touching:
                stamp_s = seconds + 1e-6 * microseconds if self._stamped else arrival_s
                samples.append((stamp_s, self._finger.values))
        if not samples:
            return None
        return SampleBlock(np.array([time_s for time_s, _ in samples]), np.array([values for _, values in samples]))

    def close(self) -> None:
        file, self._file = self._file, None
        if file is not None:
            os.close(file)


def _set_clock(file: int) -> bool:
    """Return True if the kernel stamps events on the local clock."""
    try:
        import fcntl

        fcntl.ioctl(file, SET_CLOCK, struct.pack("i", MONOTONIC))
    except (ImportError, OSError):
        return False
    return True
