"""What a sensor told during one touch."""

import numpy as np

from tactometry.devices.position_sensor import mean_speed_m_per_s
from tactometry.devices.reader import FloatArray


class Trace:
    """Collects blocks in one thread, and gives them to another."""

    def __init__(self) -> None:
        self._blocks: list[tuple[FloatArray, FloatArray]] = []

    def hear(self, times_s: FloatArray, values: FloatArray) -> None:
        if times_s.size:
            self._blocks.append((times_s, values))

    def between(self, begin_s: float, end_s: float) -> tuple[FloatArray, FloatArray]:
        """Times and values of the finite samples of an interval; none where a stamp goes back."""
        blocks = self._blocks.copy()
        if not blocks:
            return np.empty(0), np.empty(0)
        times_s, values = (np.concatenate(parts) for parts in zip(*blocks, strict=True))
        finite = np.isfinite(values.reshape(len(values), -1)).all(axis=1)
        kept = (times_s >= begin_s) & (times_s <= end_s) & finite
        sound = bool(np.all(np.diff(times_s[kept]) >= 0))
        return (times_s[kept], values[kept]) if sound else (times_s[:0], values[:0])


def speed_m_per_s(places: Trace, begin_s: float, end_s: float) -> float | None:
    """The mean speed of positions; None where it was not measured."""
    times_s, positions_m = places.between(begin_s, end_s)
    return mean_speed_m_per_s(times_s, positions_m) if times_s.size else None
