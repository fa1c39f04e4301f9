"""What the numbers of an output become at its load."""

from dataclasses import dataclass
from datetime import date

import numpy as np
from numpy.typing import NDArray

from tactometry.devices.measured import Measured, check_age
from tactometry.errors import DeviceFailed
from tactometry.require import positive
from tactometry.signal import Signal

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Gain:
    """Volts at the load for each unit of a sample: those at the device's connector, times what the amplifier does.

    Parameters
    ----------
    volts_per_unit : float
        Peak voltage at the connector for a sample of 1.0, V, above 0.
    amplifier_gain : float
        Voltage at the load over voltage at the connector, above 0.
    measured_on, measured_by : date, str, optional
        When, and by whom.
    max_age_days : int, optional
        How old the measurement may be.

    Examples
    --------
    >>> gain = Gain(volts_per_unit=2.0, amplifier_gain=50.0)
    >>> gain.to_units(Signal(np.array([[-50.0, 25.0]]), 1e3, "V"))
    array([[-0.5 ,  0.25]])
    """

    volts_per_unit: float = 1.0
    amplifier_gain: float = 1.0
    measured_on: date | None = None
    measured_by: str | None = None
    max_age_days: int | None = None

    def __post_init__(self) -> None:
        positive("Gain", volts_per_unit=self.volts_per_unit, amplifier_gain=self.amplifier_gain)
        check_age("Gain", self.max_age_days)

    @property
    def measured(self) -> Measured:
        return Measured(self.measured_on, self.measured_by, self.max_age_days)

    @property
    def load_volts_per_unit(self) -> float:
        return self.volts_per_unit * self.amplifier_gain

    def to_units(self, signal: Signal) -> FloatArray:
        """The samples as numbers for the device, (n_channels, n_samples).

        Raises
        ------
        DeviceFailed
            If one is beyond -1..1, where the device would clip.
        """
        units = signal.samples / self.load_volts_per_unit
        if np.max(np.abs(units), initial=0.0) > 1 + 1e-12:
            raise DeviceFailed(
                f"output: found a peak of {signal.peak:.6g} V, expected at most {self.load_volts_per_unit:.6g} V, what "
                "the device and its amplifier reach; lower the level; nothing was played"
            )
        return np.asarray(np.clip(units, -1.0, 1.0))

    def to_volts(self, units: FloatArray, rate_hz: float) -> Signal:
        """What such numbers become at the load."""
        return Signal(units * self.load_volts_per_unit, rate_hz, "V")
