"""What may reach a finger, checked on the final samples by every rig."""

from dataclasses import dataclass

from tactometry.errors import InvalidParameter, LimitExceeded
from tactometry.signal import Signal


@dataclass(frozen=True)
class Limits:
    """The largest values that an output may emit.

    Parameters
    ----------
    voltage_peak_v : float
        Peak voltage on any channel, above 0.
    duration_s : float
        Longest single signal, above 0.
    """

    voltage_peak_v: float
    duration_s: float = 60.0

    def __post_init__(self) -> None:
        for name in ("voltage_peak_v", "duration_s"):
            value = getattr(self, name)
            if not 0 < value < float("inf"):
                raise InvalidParameter(f"Limits.{name}: found {value}, expected a finite number above 0")

    def check(self, signal: Signal) -> None:
        """Refuse a signal that passes a limit.

        Raises
        ------
        LimitExceeded
            If the unit is not volt, or the peak or the duration is above its limit. Rounding in the last digits
            (1e-12 relative) is not an excess.
        """
        if signal.unit != "V":
            raise LimitExceeded(f"limits: found a signal in {signal.unit!r}, expected volt ('V'); nothing was played")
        if signal.peak > self.voltage_peak_v * (1 + 1e-12):
            raise LimitExceeded(
                f"limits.voltage_peak_v: found a peak of {signal.peak:.6g} V, the limit is "
                f"{self.voltage_peak_v:.6g} V; lower the level; nothing was played"
            )
        if signal.duration_s > self.duration_s * (1 + 1e-12):
            raise LimitExceeded(
                f"limits.duration_s: found a signal of {signal.duration_s:.6g} s, the limit is "
                f"{self.duration_s:.6g} s; shorten it; nothing was played"
            )
