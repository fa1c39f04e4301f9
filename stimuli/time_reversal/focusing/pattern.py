"""Trains of foci under an envelope, such as patterns P0 to P6.

P0 is one focus. P1-P3 repeat it at a low frequency under three envelopes, P4-P6 at a high frequency under the same
envelopes. The thesis's frequencies, envelopes and durations are not known: 200 and 500 Hz, rectangular,
exponential and sinc, 50 ms are documented choices (`pattern` in `stimuli/sources.toml`).
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal, Protocol, runtime_checkable

import numpy as np

from tactometry.arguments.checked import NotNegative, Positive, checked
from tactometry.arguments.require import at_most, one_of, within
from tactometry.errors import InvalidParameter
from tactometry.signal import Signal

from ...arrays import FloatArray, IntArray
from ...defaults import REPETITION_HZ, TRAIN_S
from ..responses.responses import MAX_SAMPLES, Responses
from .focusing import reversed_waveform
from .quantiser import Quantiser, one_bit

LOW_HZ: Final = REPETITION_HZ
HIGH_HZ: Final = 500.0
MAX_FOCI: Final = 1_000_000
MODULATIONS: Final = ("voltage", "burst")


@runtime_checkable
class Envelope(Protocol):
    """Interface of an envelope: weights over a pattern."""

    def at(self, position: FloatArray) -> FloatArray:
        """Return weights at positions from 0 (start) to 1 (end)."""


@checked
@dataclass(frozen=True)
class Rectangular:
    """A constant weight of 1."""

    def at(self, position: FloatArray) -> FloatArray:
        return np.ones_like(position)


@checked
@dataclass(frozen=True)
class RaisedCosine:
    """The weight (1 - cos 2 pi x) / 2."""

    def at(self, position: FloatArray) -> FloatArray:
        return np.asarray((1 - np.cos(2 * math.pi * position)) / 2)


@checked
@dataclass(frozen=True)
class Exponential:
    """The weight exp(-x / decay), with `decay` above 0 as a share of the duration."""

    decay: Positive = 0.25

    def at(self, position: FloatArray) -> FloatArray:
        return np.asarray(np.exp(-position / self.decay))


@checked
@dataclass(frozen=True)
class Sinc:
    """The weight sin(pi x) / (pi x) with `n_zeros` zeros on each side; `signed` keeps the sign of the lobes."""

    n_zeros: int = 3
    signed: bool = True

    def at(self, position: FloatArray) -> FloatArray:
        values = np.sinc(2 * self.n_zeros * (position - 0.5))
        return np.asarray(values if self.signed else np.abs(values))


@checked
@dataclass(frozen=True)
class Table:
    """Weights at equal steps from start to end, interpolated linearly."""

    values: tuple[float, ...]

    def __post_init__(self) -> None:
        if len(self.values) < 2 or not np.isfinite(self.values).all():
            raise InvalidParameter(f"Table.values: found {self.values}, expected at least two finite numbers")

    def at(self, position: FloatArray) -> FloatArray:
        return np.interp(position, np.linspace(0, 1, len(self.values)), self.values)


EnvelopeName = Literal["rectangular", "raised_cosine", "exponential", "sinc"]
ENVELOPES: Final[Mapping[str, Envelope]] = {
    "rectangular": Rectangular(),
    "raised_cosine": RaisedCosine(),
    "exponential": Exponential(),
    "sinc": Sinc(),
}
"""Envelopes by their name in study and scene files."""


@checked
@dataclass(frozen=True)
class Pattern:
    """Foci at a repetition frequency under an envelope.

    Parameters
    ----------
    repetition_hz, duration_s : float
        Repetition frequency and duration, above 0; their rounded product is the number of foci (at least 1).
    envelope : Envelope
        Weights of the foci, scaled to a largest weight of 1.

    >>> Pattern(200.0, 50e-3).n_foci
    10
    """

    repetition_hz: Positive
    duration_s: Positive
    envelope: Envelope = Rectangular()

    def __post_init__(self) -> None:
        at_most("Pattern.repetition_hz times duration_s", self.repetition_hz * self.duration_s, MAX_FOCI)

    @property
    def n_foci(self) -> int:
        return max(round(self.duration_s * self.repetition_hz), 1)

    @property
    def times_s(self) -> FloatArray:
        """Times of the foci after the first."""
        return np.arange(self.n_foci) / self.repetition_hz

    @property
    def weights(self) -> FloatArray:
        """Weight of each focus; the largest magnitude is 1."""
        if self.n_foci == 1:
            return np.ones(1)
        raw = self.envelope.at((np.arange(self.n_foci) + 0.5) / self.n_foci)
        largest = np.abs(raw).max()
        if largest == 0:
            raise InvalidParameter(f"Pattern.envelope: found {self.envelope}, zero at every focus")
        return np.asarray(raw / largest)


PATTERNS: Final[Mapping[str, Pattern]] = {
    "P0": Pattern(LOW_HZ, 1 / LOW_HZ),
    "P1": Pattern(LOW_HZ, TRAIN_S, Rectangular()),
    "P2": Pattern(LOW_HZ, TRAIN_S, Exponential()),
    "P3": Pattern(LOW_HZ, TRAIN_S, Sinc()),
    "P4": Pattern(HIGH_HZ, TRAIN_S, Rectangular()),
    "P5": Pattern(HIGH_HZ, TRAIN_S, Exponential()),
    "P6": Pattern(HIGH_HZ, TRAIN_S, Sinc()),
}


@checked
def pattern_drive(
    foci: Responses,
    pattern: Pattern,
    voltage_v: Positive,
    quantiser: Quantiser | None = None,
    *,
    reversal_s: float | None = None,
    path: Sequence[int] | None = None,
    modulation: str = "voltage",
    tau_s: float | None = None,
) -> Signal:
    """Return the drive of a pattern; focus k is at ``focus_samples(...)[k]``.

    Raises `InvalidParameter` if the path does not match, or burst modulation lacks tau.

    Parameters
    ----------
    foci : Responses
        One row per place.
    path : sequence of int, optional
        Row of each focus, for a moving focus. Default: row 0.
    modulation : str
        ``voltage`` scales the emitted values of each focus; ``burst`` keeps the voltage and shortens the emission to
        reach the weight by 1 - exp(-T / tau), which needs `tau_s`. Where drives overlap (T above the repetition time),
        the sum is quantised again at the voltage of the largest active weight, and the foci lose amplitude as in
        `closed_forms.repetition_amplitude_ratio`.
    """
    one_of("pattern_drive.modulation", modulation, MODULATIONS)
    rows = [0] * pattern.n_foci if path is None else list(path)
    if len(rows) != pattern.n_foci or any(not 0 <= row < foci.n_points for row in rows):
        raise InvalidParameter(
            f"path: found {path}, expected {pattern.n_foci} rows from 0 to {foci.n_points - 1}, one per focus"
        )
    rule = quantiser or one_bit()
    waves = reversed_waveforms(foci, rows, reversal_s)
    n = next(iter(waves.values())).shape[1]
    starts = focus_starts(pattern, foci.rate_hz)
    overlaps = len(starts) > 1 and int(np.min(np.diff(starts))) < n
    pieces = []
    for row, weight in zip(rows, pattern.weights, strict=True):
        piece = waves[row] if overlaps else rule.quantise(waves[row], foci.rate_hz)
        pieces.append(_modulate(piece, float(weight), modulation, tau_s, foci.rate_hz))
    total = _overlay(pieces, starts)
    if overlaps:
        scales = pattern.weights if modulation == "voltage" else np.ones(len(starts))
        supply = _supply(scales, starts, n)
        total = supply * rule.quantise(total / np.where(supply > 0, supply, 1.0), foci.rate_hz)
    return Signal(voltage_v * total, foci.rate_hz, "V")


@checked
def reversed_waveforms(foci: Responses, rows: Sequence[int], reversal_s: float | None) -> dict[int, FloatArray]:
    """Return the reversed waveform (n_channels, n_reversal) of each row."""
    return {row: reversed_waveform(foci.at_point(row), reversal_s=reversal_s) for row in set(rows)}


@checked
def focus_samples(pattern: Pattern, rate_hz: float, n_reversal: int) -> IntArray:
    """Return the sample of each focus in a drive, (n_foci,)."""
    return focus_starts(pattern, rate_hz) + n_reversal - 1


@checked
def burst_s(weight: float, reversal_s: NotNegative, tau_s: Positive) -> float:
    """Return -tau ln(1 - w (1 - exp(-T / tau))), the burst of weight w.

    The weight lies from 0 to 1, T is at least 0 and tau above 0.

    >>> round(burst_s(1.0, 7e-3, 3.5e-3) * 1e3, 9)
    7.0
    """
    within("burst_s", 0.0, 1.0, weight=weight)
    reached = -weight * math.expm1(-reversal_s / tau_s)
    return reversal_s if reached == 1 else -tau_s * math.log1p(-reached)


@checked
def focus_starts(pattern: Pattern, rate_hz: Positive) -> IntArray:
    """Return the first sample of the drive of each focus, (n_foci,)."""
    at_most("samples of the pattern", pattern.times_s[-1] * rate_hz, MAX_SAMPLES)
    return np.round(pattern.times_s * rate_hz).astype(np.int64)


def _modulate(piece: FloatArray, weight: float, modulation: str, tau_s: float | None, rate_hz: float) -> FloatArray:
    if modulation == "voltage":
        return weight * piece
    if tau_s is None:
        raise InvalidParameter("tau_s: found None, expected the attenuation constant for burst modulation")
    n_kept = round(burst_s(abs(weight), piece.shape[1] / rate_hz, tau_s) * rate_hz)
    kept = np.arange(piece.shape[1]) >= piece.shape[1] - n_kept  # the end of the emission, just before the focus
    return np.asarray(math.copysign(1.0, weight) * piece * kept)


def _supply(weights: FloatArray, starts: IntArray, n: int) -> FloatArray:
    """Return the largest weight of the active drives, (n_samples,)."""
    supply = np.zeros(int(starts[-1]) + n)
    for weight, start in zip(np.abs(weights), starts, strict=True):
        supply[start : start + n] = np.maximum(supply[start : start + n], weight)
    return supply


def _overlay(pieces: Sequence[FloatArray], starts: IntArray) -> FloatArray:
    n_channels, n = pieces[0].shape
    total = np.zeros((n_channels, int(starts[-1]) + n))
    for piece, start in zip(pieces, starts, strict=True):
        total[:, start : start + n] += piece
    return total
