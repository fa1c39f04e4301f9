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
"""Tolerated difference of volumes, because sound servers round them to whole per cent."""
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
    - `amplifier_gain`: Ratio of the voltage at the load to the voltage at the connector, above 0.
    - `measured_on`: Date of the measurement.
    - `measured_by`: Name of the person who measured it.
    - `max_age_days`: Largest age of the measurement, days.
    - `measured_with`: Output and format used for the measurement, written like `SignalChain.output`.
    - `system_volume`: Volume of the sound server during the measurement; 1 is 100 %.

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
'audio Interface, int16', the output in use; measure it with: tactometry calibrate gain; nothing was played
        """
        for name, expected in (("measured_on", "date"), ("measured_by", "author"), ("measured_with", "output")):
            if getattr(self, name) in (None, ""):
                raise DeviceFailed(f"{what}.{name}: found none, expected the {expected} of its measurement; {MEASURE}")
        if self.measured_with != chain.output:
            raise DeviceFailed(
                f"{what}.measured_with: found {self.measured_with!r}, expected {chain.output!r}, the output in use; "
                f"{MEASURE}"
            )
        system_volume = chain.system_volume
        known = [volume for volume in (self.system_volume, system_volume) if volume is not None]
        apart = max(known, default=0.0) - min(known, default=0.0)
        # volumes are compared only if both are known: the server may have been started or removed since
        if len(known) == 1 or apart > VOLUME_TOLERANCE:
            raise DeviceFailed(
                f"{what}.system_volume: found a measurement at {_volume(self.system_volume)}, expected "
                f"{_volume(system_volume)}, the current setting; reset the volume, or {MEASURE}"
            )
        self.check_age(what, today)

    def to_units(self, signal: Signal) -> FloatArray:
        """Convert samples to device units, (n_channels, n_samples).

        Raises `DeviceFailed` if a value is outside -1..1, where the device would clip.
        """
        units = signal.samples / self.load_volts_per_unit
        # 1e-12: rounding errors of the division are clipped below
        if np.max(np.abs(units), initial=0.0) > 1 + 1e-12:
            raise DeviceFailed(
                f"output: found a peak of {signal.peak:.6g} V, expected at most {self.load_volts_per_unit:.6g} V, the "
                "range of the device and its amplifier; lower the level; nothing was played"
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
    """Return the gain of a connected output, or raise `DeviceFailed`."""
    if gain is None:
        raise InvalidParameter(
            f"{what}: found none, expected volts_per_unit and amplifier_gain with date and author, which "
            f"determine the voltage at the load; {MEASURE}"
        )
    return gain


def _volume(volume: float | None) -> str:
    return "an unknown volume" if volume is None else f"a volume of {100 * volume:.0f} %"
