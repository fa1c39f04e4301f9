"""A polygon repeated: square, triangle, trapezoid, pulses."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import accumulate
from typing import TYPE_CHECKING, Literal

import numpy as np

from tactometry.arguments import require

from ...arrays import FloatArray
from .pieces import Corners, Pieces, ramped as ramped_pieces
from .waveform import LevelUnit, Ramped, check_nyquist, check_pulse, n_samples, peak_voltage_v

MOST_HARMONICS = 2**20


class Periodic(Ramped):
    """Base class of repeated polygons with raised-cosine ramps.

    A subclass defines its polygon, `corners`, and how many times per second it repeats.
    """

    band_limited: bool

    if TYPE_CHECKING:  # at run time the property would become the default of the field

        @property
        def frequency_hz(self) -> float: ...

    def __post_init__(self) -> None:
        """Check frequency, duration, ramp, rate and unit."""
        owner = type(self).__name__
        require.positive(owner, frequency_hz=self.frequency_hz)
        require.truth(owner, band_limited=self.band_limited)
        super().__post_init__()
        check_nyquist(owner, "frequency_hz", self.frequency_hz, self.rate_hz)
        n_harmonics = self.rate_hz / (2 * self.voltage_frequency_hz)
        require.expect(
            not self.band_limited or n_harmonics <= MOST_HARMONICS,
            f"{owner}.band_limited",
            f"{n_harmonics:.6g} harmonics below half of rate_hz",
            f"at most {MOST_HARMONICS}; raise frequency_hz or lower rate_hz",
        )

    @property
    def corners(self) -> Corners:
        raise NotImplementedError

    @property
    def voltage_frequency_hz(self) -> float:
        return self.frequency_hz

    @property
    def force_frequency_hz(self) -> float:
        """Frequency of the force, doubled if half periods have opposite signs."""
        return (2 if self.corners.is_antisymmetric else 1) * self.voltage_frequency_hz

    def pieces(self, level: float) -> Pieces:
        """Return the exact voltage as pieces. Raises for slopes with a ramp."""
        unit = ramped_pieces(self.corners.pieces(self.voltage_frequency_hz, self.duration_s), self.ramp_s)
        return unit.scaled(peak_voltage_v(level, self.level_unit))

    def _unit(self) -> FloatArray:
        f_hz = self.voltage_frequency_hz
        turned = np.mod(f_hz * np.arange(n_samples(self.duration_s, self.rate_hz)), self.rate_hz)
        phase = turned / self.rate_hz
        if not self.band_limited:
            return self.corners.at(np.round(phase, 12))
        return self.corners.band_limited(phase, int(np.ceil(self.rate_hz / (2 * f_hz))) - 1)

    def _check_width(self, name: str, width_s: float) -> None:
        """Raise an error if a pulse or pause is shorter than a sample."""
        if not self.band_limited:
            where = f"{type(self).__name__}.{name}"
            check_pulse(where, width_s, self.rate_hz, "lengthen it, raise rate_hz or set band_limited")


@dataclass(frozen=True)
class Square(Periodic):
    """A square wave: ``+V0`` for `duty` of a period, then ``-V0``. A duty of 1/2 doubles the force frequency.

    Parameters
    ----------
    frequency_hz : float
        Frequency of the voltage, above 0.
    duration_s, ramp_s, rate_hz, level_unit
        As in `Sine`.
    duty : float
        Share of the period at ``+V0``, between 0 and 1.
    band_limited : bool
        Sample the Fourier series below half of `rate_hz` instead of the edges, so that nothing aliases.

    >>> Square(frequency_hz=5.0, ramp_s=0.0, rate_hz=20.0, duration_s=0.2).at(0.0).samples.tolist()
    [[1.0, 1.0, -1.0, -1.0]]
    """

    frequency_hz: float
    duration_s: float = 1.0
    ramp_s: float = 0.05
    rate_hz: float = 20_000.0
    duty: float = 0.5
    band_limited: bool = False
    level_unit: LevelUnit = "dB re 1 V"

    def __post_init__(self) -> None:
        super().__post_init__()
        require.between("Square", 0, 1, duty=self.duty)
        self._check_width("duty", min(self.duty, 1 - self.duty) / self.frequency_hz)

    @property
    def corners(self) -> Corners:
        return Corners((0.0, self.duty, self.duty, 1.0), (1.0, 1.0, -1.0, -1.0))


@dataclass(frozen=True)
class Triangle(Periodic):
    """A triangle wave from ``V0`` to ``-V0``, which doubles the force frequency.

    Parameters
    ----------
    frequency_hz : float
        Frequency of the voltage, above 0.
    duration_s, ramp_s, rate_hz, level_unit
        As in `Sine`.
    band_limited : bool
        Sample the Fourier series below half of `rate_hz` instead of the corners, so that nothing aliases.

    >>> Triangle(frequency_hz=5.0, ramp_s=0.0, rate_hz=20.0, duration_s=0.2).at(0.0).samples.tolist()
    [[0.0, 1.0, 0.0, -1.0]]
    """

    frequency_hz: float
    duration_s: float = 1.0
    ramp_s: float = 0.05
    rate_hz: float = 20_000.0
    band_limited: bool = False
    level_unit: LevelUnit = "dB re 1 V"

    @property
    def corners(self) -> Corners:
        return Corners((0.0, 0.25, 0.75, 1.0), (0.0, 1.0, -1.0, 0.0))


@dataclass(frozen=True)
class Trapezoid(Periodic):
    """A trapezoid wave: rise to ``V0``, hold, fall to the low value, hold.

    Raises `InvalidParameter` if a value is outside of its domain, or the voltage stays for less than a sample above or
    below the middle of its two values, so that samples may miss it.

    Parameters
    ----------
    rise_s : float
        Duration of the rising line; 0 is a jump.
    high_s : float
        Duration of the hold at the top; 0 omits it.
    fall_s : float
        Duration of the falling line; 0 is a jump.
    low_s : float
        Duration of the hold at the bottom; 0 omits it.
    low_ratio : float
        Low value over ``V0``, -1 to 1; 0 (unipolar) is an unverified default.
    duration_s, ramp_s, rate_hz, level_unit
        As in `Sine`, but without ramps by default, since the first rise acts as one.
    band_limited : bool
        Sample the Fourier series below half of `rate_hz` instead of the corners, so that nothing aliases.

    >>> lines = Trapezoid(rise_s=0.1, high_s=0.1, fall_s=0.1, low_s=0.1, rate_hz=10.0, duration_s=0.4)
    >>> lines.at(0.0).samples.round(12).tolist()
    [[0.0, 1.0, 1.0, 0.0]]
    """

    rise_s: float
    high_s: float
    fall_s: float
    low_s: float
    low_ratio: float = 0.0
    duration_s: float = 1.0
    ramp_s: float = 0.0
    rate_hz: float = 20_000.0
    band_limited: bool = False
    level_unit: LevelUnit = "dB re 1 V"

    def __post_init__(self) -> None:
        times = {name: getattr(self, name) for name in ("rise_s", "high_s", "fall_s", "low_s")}
        require.not_negative("Trapezoid", **times)
        require.expect(sum(times.values()) > 0, "Trapezoid", "four durations of 0 s", "a period longer than 0 s")
        require.finite("Trapezoid", low_ratio=self.low_ratio)
        require.expect(-1 <= self.low_ratio <= 1, "Trapezoid.low_ratio", repr(self.low_ratio), "-1 to 1")
        super().__post_init__()
        edges_s = (self.rise_s + self.fall_s) / 2
        self._check_width("high_s", self.high_s + edges_s)
        self._check_width("low_s", self.low_s + edges_s)

    @property
    def frequency_hz(self) -> float:
        return 1 / (self.rise_s + self.high_s + self.fall_s + self.low_s)

    @property
    def corners(self) -> Corners:
        ends = [0.0, *accumulate((self.rise_s, self.high_s, self.fall_s))]
        phases = (*(end * self.frequency_hz for end in ends), 1.0)
        return Corners(phases, (self.low_ratio, 1.0, 1.0, self.low_ratio, self.low_ratio))


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
    frequency_hz : float
        Pulses per second, above 0.
    duration_s, ramp_s, rate_hz, level_unit
        As in `Sine`.
    width_s : float
        Length of one phase of a pulse; at most a period (half of one for ``biphasic``).
    polarity : {"positive", "negative", "biphasic", "alternating"}
        ``biphasic`` is a positive and then a negative phase; ``alternating`` changes the sign from pulse to pulse,
        which halves the frequency of the voltage but not of the force. Positive pulses are reported to be less
        effective than the others. A force quadratic in the voltage does not show this asymmetry: see `Polarity`.
    band_limited : bool
        Sample the Fourier series below half of `rate_hz` instead of the corners, so that nothing aliases.

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
        super().__post_init__()
        require.positive("PulseTrain", width_s=self.width_s)
        require.one_of("PulseTrain.polarity", self.polarity, POLARITIES)
        n_phases = 2 if self.polarity == "biphasic" else 1
        longest_s = 1 / (n_phases * self.frequency_hz)
        require.expect(
            self.width_s <= longest_s,
            "PulseTrain.width_s",
            f"{self.width_s} s",
            f"at most {longest_s:.6g} s for {self.polarity} pulses at {self.frequency_hz} Hz; "
            "shorten them or lower the frequency",
        )
        self._check_width("width_s", self.width_s)
        pause_s = 1 / self.frequency_hz - n_phases * self.width_s
        if pause_s > 1e-9 * longest_s:
            self._check_width("width_s (the pause after it)", pause_s)

    @property
    def corners(self) -> Corners:
        width = self.width_s * self.frequency_hz
        return POLARITIES[self.polarity](width)

    @property
    def voltage_frequency_hz(self) -> float:
        return self.frequency_hz / (2 if self.polarity == "alternating" else 1)
