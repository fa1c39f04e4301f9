"""Voltage at the load per unit of an output, and its signal chain."""

from dataclasses import dataclass, replace
from datetime import date
from typing import Final

import numpy as np

from ...arguments.constraints import Positive
from ...errors import DeviceFailed, InvalidParameter
from ...signal import FloatArray, Signal
from ..measured import MaxAge, Measured

MAX_AGE_DAYS: Final = 365
"""Default largest age of a gain, days (unverified default)."""
VOLUME_TOLERANCE: Final = 0.005
"""Tolerated difference of volumes, as sound servers state them in whole per cent."""
MEASURE: Final = "measure it with: tactometry calibrate gain; nothing was played"


@dataclass(frozen=True)
class SignalChain:
    """Output with its format, and the volume (1 is 100 %) if known."""

    output: str
    system_volume: float | None = None


@dataclass(frozen=True)
class Gain(Measured):
    """Volts at the load per unit: connector voltage times amplifier gain.

    - `volts_per_unit`: Peak voltage at the connector for a sample of 1.0, V, above 0.
    - `amplifier_gain`: Voltage at the load over voltage at the connector, above 0.
    - `measured_on`: Date of the measurement.
    - `measured_by`: Who made the measurement.
    - `max_age_days`: How old the measurement may be.
    - `measured_with`: The output and format that it was measured with, in the words of `SignalChain.output`.
    - `system_volume`: The sound server's volume at which it was measured, 1 is 100 %.

    >>> gain = Gain(volts_per_unit=2.0, amplifier_gain=50.0)
    >>> gain.to_units(Signal(np.array([[-50.0, 25.0]]), 1e3, "V"))
    array([[-0.5 ,  0.25]])
    """

    volts_per_unit: Positive
    amplifier_gain: Positive
    measured_on: date | None = None
    measured_by: str | None = None
    max_age_days: MaxAge = MAX_AGE_DAYS
    measured_with: str | None = None
    system_volume: float | None = None

    @property
    def load_volts_per_unit(self) -> float:
        return self.volts_per_unit * self.amplifier_gain

    def check(self, what: str, chain: SignalChain, today: date) -> None:
        """Refuse a gain that is missing, too old or of another signal chain.

        >>> gain = Gain(2.0, 50.0, date(2026, 1, 2), "ZG", measured_with="audio Interface, int32")
        >>> gain.check("output.gain", SignalChain("audio Interface, int32"), date(2026, 3, 1))
        >>> gain.check("output.gain", SignalChain("audio Interface, int16"), date(2026, 3, 1))
        Traceback (most recent call last):
        tactometry.errors.DeviceFailed: output.gain.measured_with: found 'audio Interface, int32', expected \
'audio Interface, int16', which is to play; measure it with: tactometry calibrate gain; nothing was played
        """
        for name, expected in (("measured_on", "the day"), ("measured_by", "who did"), ("measured_with", "the output")):
            if getattr(self, name) in (None, ""):
                raise DeviceFailed(f"{what}.{name}: found none, expected {expected} of its measurement; {MEASURE}")
        if self.measured_with != chain.output:
            raise DeviceFailed(
                f"{what}.measured_with: found {self.measured_with!r}, expected {chain.output!r}, which is to play; "
                f"{MEASURE}"
            )
        system_volume = chain.system_volume
        known = [volume for volume in (self.system_volume, system_volume) if volume is not None]
        apart = max(known, default=0.0) - min(known, default=0.0)
        # volumes compare only if both are known: the server may have been started or removed since
        if len(known) == 1 or apart > VOLUME_TOLERANCE:
            raise DeviceFailed(
                f"{what}.system_volume: found a gain of {_volume(self.system_volume)}, expected one of "
                f"{_volume(system_volume)}, as it is now; set it back, or {MEASURE}"
            )
        self.check_age(what, today)

    def to_units(self, signal: Signal) -> FloatArray:
        """Convert samples to device units, (n_channels, n_samples).

        Raises `DeviceFailed` if one is beyond -1..1, where the device would clip.
        """
        units = signal.samples / self.load_volts_per_unit
        # 1e-12: rounding errors of the division are clipped below
        if np.max(np.abs(units), initial=0.0) > 1 + 1e-12:
            raise DeviceFailed(
                f"output: found a peak of {signal.peak:.6g} V, expected at most {self.load_volts_per_unit:.6g} V, what "
                "the device and its amplifier reach; lower the level; nothing was played"
            )
        return np.asarray(np.clip(units, -1.0, 1.0))

    def to_volts(self, units: FloatArray, rate_hz: float) -> Signal:
        return Signal(units * self.load_volts_per_unit, rate_hz, "V")


def measured_anew(gain: Gain, chain: SignalChain, today: date, by: str) -> Gain:
    """Return a gain as if it were measured now with this signal chain."""
    return replace(
        gain, measured_on=today, measured_by=by, measured_with=chain.output, system_volume=chain.system_volume
    )


def required_gain(gain: Gain | None, what: str) -> Gain:
    """Return the gain of a connected output, or raise."""
    if gain is None:
        raise InvalidParameter(
            f"{what}: found none, expected volts_per_unit and amplifier_gain with date and author: without them the "
            f"voltage at the load is unknown; {MEASURE}"
        )
    return gain


def _volume(volume: float | None) -> str:
    return "an unknown volume" if volume is None else f"a volume of {100 * volume:.0f} %"
