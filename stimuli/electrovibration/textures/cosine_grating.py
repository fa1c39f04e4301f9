"""A sinusoidal grating whose voltage follows the finger exactly."""

from dataclasses import dataclass, replace
from math import pi
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from tactometry.contact import Contact
from tactometry.errors import InvalidParameter

from ...arrays import FloatArray
from ...composition.content import VoltageContent
from ...composition.effect import Effect, Stage, Surroundings
from ..waveforms.pieces import Pieces

if TYPE_CHECKING:
    from ..waveforms.pieces import VoltageRecord


@dataclass(frozen=True)
class CosineGrating(Effect):
    """A grating whose force is proportional to ``(1 + cos(2 pi x/period))/2`` and its voltage to the root of that.

    Parameters
    ----------
    period_m : float
        Spatial period of the grating.

    >>> CosineGrating(period_m=1e-3).force_share([0.0, 0.25e-3, 0.5e-3]).round(9).tolist()
    [1.0, 0.5, 0.0]
    """

    kind = "texture"
    positive = ("period_m",)
    requires = ("sliding contact",)
    assumes = ("the voltage follows the finger without delay",)

    period_m: float

    def force_share(self, x_m: ArrayLike) -> FloatArray:
        """Return the share (0..1) of the full force at `x_m` (m), in its shape."""
        return np.asarray((1 + np.cos(2 * pi * np.asarray(x_m, float) / self.period_m)) / 2)

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        return (self._stage("unit_voltage", "under_finger"),)

    def felt_stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        """Return the stages for a played voltage, sample by sample."""
        return (self._stage("record", "sampled_under_finger"),)

    def _stage(self, voltage: str, way: str) -> Stage:
        return Stage("texture", (voltage, "contact"), voltage, f"{__name__}:{way}", dict(vars(self)))

    def in_voltage(self, scene: Surroundings) -> VoltageContent:
        frequency_hz = scene.contacts[0].speed_m_per_s / self.period_m
        return VoltageContent(frequency_hz / 2, kinks_rad_per_s=pi * frequency_hz)


def under_finger(voltage: Pieces, contact: Contact, period_m: float) -> Pieces:
    """Modulate a voltage by the grating under a sliding finger."""
    return modulated(voltage, contact.speed_m_per_s / period_m)


def sampled_under_finger(record: "VoltageRecord", contact: Contact, period_m: float) -> "VoltageRecord":
    """Modulate samples by the grating under a sliding finger."""
    share = np.abs(np.cos(pi * contact.speed_m_per_s / period_m * record.t_s))
    return replace(record, voltage_v=share * record.voltage_v)


def modulated(voltage: Pieces, frequency_hz: float) -> Pieces:
    """Multiply a voltage by ``|cos(pi f t)|``: each sinusoid becomes two."""
    if voltage.slopes_v_per_s.any():
        raise InvalidParameter("texture: found a voltage with slopes, expected one of constants and sinusoids")
    zeros_s = (np.arange(np.ceil(voltage.end_s * frequency_hz - 0.5)) + 0.5) / frequency_hz
    split = voltage.split_at(zeros_s) if zeros_s.size else voltage
    half_turns = np.floor(split.starts_s * frequency_hz + 0.5 + 1e-9)
    sign = np.where(half_turns % 2, -1.0, 1.0)[:, None]
    turn_hz, f_hz = frequency_hz / 2, split.frequencies_hz
    low_hz = f_hz - turn_hz
    low = np.where(low_hz < 0, np.conj(split.harmonics_v), split.harmonics_v)
    both = np.hstack([split.harmonics_v / 2, low / 2, split.offsets_v[:, None]])
    return replace(
        split,
        offsets_v=np.zeros(len(split.starts_s)),
        frequencies_hz=np.r_[f_hz + turn_hz, np.abs(low_hz), turn_hz],
        amplitudes_v=sign * both,
    )
