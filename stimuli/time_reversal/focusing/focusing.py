"""Time-reversal focusing: learn, reverse, emit.

Learn h[n], n = 0..K-1, of each channel at the wanted focus; emit V Q{ w h[L-1-n] } with L samples of reversal; at
sample L - 1 all channels add up at the focus. 1 bit: u = V sum |h|; analogue with gain g: u = V g sum h^2; both
identities are exact to rounding.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tactometry.arguments.checked import Positive, checked
from tactometry.arguments.require import expect
from tactometry.errors import InvalidParameter
from tactometry.signal import Signal

from ...arrays import FloatArray, fast_length
from ..filters import Band
from ..responses.load import Attached, loaded_responses
from ..responses.responses import Point, Responses, band_limited, samples_in
from ..screen.screen import Screen
from ..screen.transducer import VOLTAGE_V
from .quantiser import Quantiser, one_bit


@checked
def reversed_waveform(
    foci: Responses,
    *,
    reversal_s: float | None = None,
    weights: Sequence[float] | None = None,
    window: FloatArray | None = None,
) -> FloatArray:
    """Sum the reversed responses of the foci with weights.

    Raises `InvalidParameter` if T is longer than the responses, the number of weights or samples does not match, or all
    responses are zero.

    Parameters
    ----------
    foci : Responses
        One row per focus.
    reversal_s : float, optional
        T, at least 0 and at most the length of the responses (the default).
    weights : sequence of float, optional
        Weight of each focus, 1 by default; the sign is kept.
    window : (n_samples,) array, optional
        Factors for the learnt responses, from their start.

    Returns
    -------
    (n_channels, n_samples) array
    """
    n = foci.n_samples if reversal_s is None else samples_in("reversal_s", reversal_s, foci.rate_hz)
    if n > foci.n_samples:
        raise InvalidParameter(
            f"reversal_s: found {reversal_s}, longer than the responses of {foci.duration_s} s; "
            "learn longer responses or shorten T"
        )
    weight = np.ones(foci.n_points) if weights is None else np.asarray(weights, float)
    if weight.shape != (foci.n_points,) or not np.isfinite(weight).all():
        raise InvalidParameter(f"weights: found {weights}, expected {foci.n_points} finite numbers, one per focus")
    shape = np.ones(n) if window is None else np.asarray(window, float)
    expect(shape.shape == (n,), "window", f"shape {shape.shape}", f"({n},)")
    learnt = np.einsum("p,pqn->qn", weight, foci.samples[:, :, :n]) * shape
    if n and not learnt.any():
        raise InvalidParameter(
            "foci: found responses that are zero everywhere, expected a focus that some transducer can move "
            "(not on a supported edge or on the node lines of all modes)"
        )
    return np.asarray(learnt[:, ::-1])


@checked
def drive(
    foci: Responses,
    voltage_v: Positive,
    quantiser: Quantiser | None = None,
    *,
    reversal_s: float | None = None,
    weights: Sequence[float] | None = None,
    window: FloatArray | None = None,
) -> Signal:
    """Return the voltage that focuses at the last sample of the drive.

    Parameters
    ----------
    voltage_v : float
        Peak voltage, above 0.
    quantiser : Quantiser, optional
        Quantiser of the reversed responses; default one bit.

    >>> h = Responses(np.array([[[3.0, -2.0, 1.0]]]), 1e3)
    >>> drive(h, 30.0).samples
    array([[ 30., -30.,  30.]])
    >>> round(focus_amplitude(drive(h, 30.0), h), 9)
    180.0
    """
    waveform = reversed_waveform(foci, reversal_s=reversal_s, weights=weights, window=window)
    values = (quantiser or one_bit()).quantise(waveform, foci.rate_hz)
    return Signal(voltage_v * values, foci.rate_hz, "V")


@checked
def emitted(signal: Signal, responses: Responses) -> FloatArray:
    """Return the time signal at every point by fast convolution."""
    _same_channels(signal, responses)
    n = max(signal.samples.shape[1] + responses.n_samples - 1, 0)
    if signal.samples.shape[1] == 0 or responses.n_samples == 0:
        return np.zeros((responses.n_points, n))
    n_fft = fast_length(n)
    spectrum = np.einsum("qf,pqf->pf", np.fft.rfft(signal.samples, n_fft), np.fft.rfft(responses.samples, n_fft))
    return np.asarray(np.fft.irfft(spectrum, n_fft)[:, :n])


@checked
def focus_amplitudes(signal: Signal, responses: Responses) -> FloatArray:
    """Return every point's value (n_points,) at the focus instant."""
    _same_channels(signal, responses)
    n = signal.samples.shape[1]
    if n > responses.n_samples:
        raise InvalidParameter(
            f"signal: found {n} samples, more than the {responses.n_samples} of the responses; learn longer ones"
        )
    return np.asarray(np.einsum("qn,pqn->p", signal.samples[:, ::-1], responses.samples[:, :, :n]))


@checked
def focus_amplitude(signal: Signal, responses: Responses, point: int = 0) -> float:
    """Return the value of one point at the focus instant."""
    return float(focus_amplitudes(signal, responses.at_point(point))[0])


def _same_channels(signal: Signal, responses: Responses) -> None:
    if signal.samples.shape[0] != responses.n_channels or signal.rate_hz != responses.rate_hz:
        raise InvalidParameter(
            f"signal: found {signal.samples.shape[0]} channels at {signal.rate_hz} Hz, expected "
            f"{responses.n_channels} at {responses.rate_hz} Hz as in the responses"
        )


@checked
@dataclass(frozen=True)
class Emission:
    """Settings of an emission: band, T, rate and voltage, each above 0, quantiser, and highest frequency of a mode.

    The default of that frequency is a tenth above the band, limited by the Nyquist frequency.
    """

    band: Band
    reversal_s: Positive
    rate_hz: Positive
    voltage_v: Positive = VOLTAGE_V
    quantiser: Quantiser | None = None
    modes_to_hz: Positive | None = None

    def __post_init__(self) -> None:
        if samples_in("Emission.reversal_s", self.reversal_s, self.rate_hz) == 0:
            raise InvalidParameter(
                f"Emission.reversal_s: found {self.reversal_s}, expected at least half a sample of 1 / {self.rate_hz} s"
            )
        if 2 * self.band.f_max_hz > self.rate_hz:
            raise InvalidParameter(
                f"Emission.band: found {self.band.f_max_hz} Hz, above the Nyquist frequency {self.rate_hz / 2}; "
                "raise rate_hz or lower the band"
            )

    @property
    def f_max_hz(self) -> float:
        """The highest frequency of a mode."""
        return self.modes_to_hz or min(1.1 * self.band.f_max_hz, self.rate_hz / 2)

    def responses(self, screen: Screen, points: Sequence[Point], loads: Sequence[Attached] = ()) -> Responses:
        """Return the responses of the screen over T, within the band."""
        raw = loaded_responses(
            screen, points, loads, rate_hz=self.rate_hz, duration_s=self.reversal_s, f_max_hz=self.f_max_hz
        )
        return band_limited(raw, self.band)

    def drive(self, foci: Responses) -> Signal:
        """Return the drive that focuses at the points of these responses."""
        return drive(foci, self.voltage_v, self.quantiser)
