"""Rectangular pulses of a polarity."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

from tactometry.arguments import require
from tactometry.errors import InvalidParameter

from .corners import Corners
from .level import LevelUnit
from .periodic import Periodic, check_periodic, check_width

PulsePolarity = Literal["positive", "negative", "biphasic", "alternating"]


def _single(width: float, value: float) -> Corners:
    return Corners((0.0, width, width, 1.0), (value, value, 0.0, 0.0))


def _biphasic(width: float) -> Corners:
    phases = (0.0, width, width, 2 * width, 2 * width, 1.0)
    return Corners(phases, (1.0, 1.0, -1.0, -1.0, 0.0, 0.0))


def _alternating(width: float) -> Corners:
    half = width / 2
    phases = (0.0, half, half, 0.5, 0.5, 0.5 + half, 0.5 + half, 1.0)
    return Corners(phases, (1.0, 1.0, 0.0, 0.0, -1.0, -1.0, 0.0, 0.0))


POLARITIES: Mapping[str, Callable[[float], Corners]] = {
    "positive": lambda width: _single(width, 1.0),
    "negative": lambda width: _single(width, -1.0),
    "biphasic": _biphasic,
    "alternating": _alternating,
}


@dataclass(frozen=True)
class PulseTrain(Periodic):
    """Pulses of `width_s` that start `frequency_hz` times per second.

    Parameters
    ----------
    frequency_hz, duration_s, ramp_s, rate_hz, level_unit
        As in `Sine`.
    width_s : float
        Length of one phase of a pulse; at most a period (half of one for ``biphasic``).
    polarity : {"positive", "negative", "biphasic", "alternating"}
        ``biphasic`` is a positive and then a negative phase; ``alternating`` changes the sign from pulse to
        pulse, so that the voltage has half the frequency of the pulses and the force that of the pulses.
        Positive pulses are reported to be less effective than the others, by an asymmetry that a force
        quadratic in the voltage does not have: see `Polarity`.
    band_limited : bool
        Sample the Fourier series below half of `rate_hz` instead of the corners, so that nothing aliases.

    Raises
    ------
    InvalidParameter
        If a value is outside of its domain.

    >>> train = PulseTrain(frequency_hz=5.0, width_s=0.05, ramp_s=0.0, rate_hz=20.0, duration_s=0.2)
    >>> train.at(0.0).samples.tolist()
    [[1.0, -1.0, 0.0, 0.0]]
    """

    frequency_hz: float
    width_s: float
    duration_s: float = 1.0
    ramp_s: float = 0.05
    rate_hz: float = 20_000.0
    polarity: PulsePolarity = "biphasic"
    band_limited: bool = False
    level_unit: LevelUnit = "dB re 1 V"

    def __post_init__(self) -> None:
        check_periodic(self)
        require.positive("PulseTrain", width_s=self.width_s)
        require.one_of("PulseTrain.polarity", self.polarity, POLARITIES)
        longest_s = 1 / ((2 if self.polarity == "biphasic" else 1) * self.frequency_hz)
        if self.width_s > longest_s:
            raise InvalidParameter(
                f"PulseTrain.width_s: found {self.width_s} s, expected at most {longest_s:.6g} s for "
                f"{self.polarity} pulses at {self.frequency_hz} Hz; shorten them or lower the frequency"
            )
        check_width(self, "width_s", self.width_s)
        pause_s = self._pause_s
        if pause_s > 1e-9 * longest_s:
            check_width(self, "width_s (the pause after it)", pause_s)

    @property
    def _pause_s(self) -> float:
        return 1 / self.frequency_hz - (2 if self.polarity == "biphasic" else 1) * self.width_s

    @property
    def corners(self) -> Corners:
        width = self.width_s * self.frequency_hz
        return POLARITIES[self.polarity](width)

    @property
    def voltage_frequency_hz(self) -> float:
        return self.frequency_hz / (2 if self.polarity == "alternating" else 1)
