"""Amplitude-modulated carriers.

They are also available by pulse width, for amplifiers that switch between their supply, its negative and off. The
attraction is quadratic in the voltage, and a finger feels its envelope, not the carrier. In each half period of the
carrier the supply is on until the mean square of the requested voltage is reached. The remaining fraction of a sample
is carried to the next half period, so that the error of the envelope does not accumulate.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np

from tactometry.arguments import require
from tactometry.errors import LimitExceeded
from tactometry.signal import Signal

from ...arrays import FloatArray, IntArray
from .pieces import Pieces, ramped as ramped_pieces
from .waveform import LevelUnit, Ramped, check_nyquist, peak_voltage_v, times_s

SHORTEST: Final = 1.0
"""Fewest samples of the widest pulse; with fewer, the force errs by more than 1 dB (simulation; unverified default)."""
Modulation = Literal["square_root", "full", "suppressed_carrier"]
FORCE_FREQUENCY_RATIO: Mapping[str, int] = {"square_root": 1, "full": 1, "suppressed_carrier": 2}

SIDEBANDS: Mapping[str, tuple[tuple[float, float], ...]] = {
    "square_root": ((0.5, 0.5), (-0.5, 0.5)),
    "full": ((0.0, 0.5), (1.0, 0.25), (-1.0, 0.25)),
    "suppressed_carrier": ((1.0, 0.5), (-1.0, 0.5)),
}


@dataclass(frozen=True)
class AmplitudeModulated(Ramped):
    """``V0 m(t) sin(2 pi f_c t)`` with a modulation m at the programmed frequency.

    With ``c = cos(2 pi f t)``:

    ======================  ======================  ============================================
    modulation              m(t)                    low-passed force in units of V0^2 (lossless)
    ======================  ======================  ============================================
    ``square_root``         ``sqrt((1 + c)/2)``     0.25 + 0.25 c: a pure tone at f
    ``full``                ``(1 + c)/2``           0.1875 + 0.25 c + 0.0625 cos(2 pi 2f t)
    ``suppressed_carrier``  ``c``                   0.25 + 0.25 cos(2 pi 2f t): a pure tone at 2f
    ======================  ======================  ============================================

    Parameters
    ----------
    frequency_hz : float
        Programmed frequency f, above 0.
    carrier_hz : float
        Carrier frequency f_c, at least ``2 f``, and its sideband ``f_c + f`` below half of `rate_hz`; the
        default of 2 kHz is a choice.
    duration_s, ramp_s, rate_hz, level_unit
        As in `Sine`.
    modulation : {"square_root", "full", "suppressed_carrier"}
        Shape of the envelope that modulates the carrier.

    >>> tone = AmplitudeModulated(frequency_hz=240.0)
    >>> tone.voltage_frequency_hz, tone.force_frequency_hz
    (2000.0, 240.0)
    >>> tone.at(14.0).samples.shape
    (1, 20000)
    """

    frequency_hz: float
    carrier_hz: float = 2_000.0
    duration_s: float = 1.0
    ramp_s: float = 0.05
    rate_hz: float = 20_000.0
    modulation: Modulation = "square_root"
    level_unit: LevelUnit = "dB re 1 V"

    def __post_init__(self) -> None:
        owner = "AmplitudeModulated"
        require.positive(owner, frequency_hz=self.frequency_hz, carrier_hz=self.carrier_hz)
        require.one_of(f"{owner}.modulation", self.modulation, FORCE_FREQUENCY_RATIO)
        super().__post_init__()
        check_nyquist(owner, "carrier_hz", self.carrier_hz, self.rate_hz)
        check_nyquist(owner, "carrier_hz + frequency_hz", self.carrier_hz + self.frequency_hz, self.rate_hz)
        require.expect(
            self.carrier_hz >= 2 * self.frequency_hz,
            f"{owner}.carrier_hz",
            f"{self.carrier_hz} Hz",
            f"at least twice the programmed frequency ({2 * self.frequency_hz} Hz); raise the carrier or lower "
            "frequency_hz",
        )

    @property
    def voltage_frequency_hz(self) -> float:
        return self.carrier_hz

    @property
    def force_frequency_hz(self) -> float:
        return FORCE_FREQUENCY_RATIO[self.modulation] * self.frequency_hz

    def _unit(self) -> FloatArray:
        t_s = times_s(self.duration_s, self.rate_hz)
        return np.asarray(self._envelope(t_s) * np.sin(2 * np.pi * self.carrier_hz * t_s))

    def _envelope(self, t_s: FloatArray) -> FloatArray:
        cosine = np.cos(2 * np.pi * self.frequency_hz * t_s)
        if self.modulation == "suppressed_carrier":
            return cosine
        full = (1 + cosine) / 2
        return np.sqrt(full) if self.modulation == "square_root" else full

    def pieces(self, level: float) -> Pieces:
        """Return the exact voltage as pieces, ramps included."""
        starts_s: FloatArray = np.zeros(1)
        signs: FloatArray = np.ones(1)
        if self.modulation == "square_root":
            n_zeros = int(np.ceil(self.duration_s * self.frequency_hz - 0.5))
            starts_s = np.r_[0.0, (np.arange(n_zeros) + 0.5) / self.frequency_hz]
            signs = np.where(np.arange(n_zeros + 1) % 2, -1.0, 1.0)
        sidebands = SIDEBANDS[self.modulation]
        f_hz = np.array([self.carrier_hz + shift * self.frequency_hz for shift, _ in sidebands])
        c = -1j * peak_voltage_v(level, self.level_unit) * np.array([height for _, height in sidebands])
        zeros = np.zeros(len(starts_s))
        return ramped_pieces(Pieces(starts_s, self.duration_s, zeros, zeros, f_hz, signs[:, None] * c), self.ramp_s)


@dataclass(frozen=True)
class PulsedCarrier:
    """A waveform of the same level from one supply (V, above 0): each sample is on, reversed or off.

    >>> pulsed = PulsedCarrier(AmplitudeModulated(120.0, rate_hz=250e3, ramp_s=0.0), supply_v=100.0)
    >>> requested, made = pulsed.waveform.at(34.0), pulsed.at(34.0)
    >>> np.unique(made.samples).tolist(), round(float(np.mean(made.samples**2) / np.mean(requested.samples**2)), 3)
    ([-100.0, 0.0, 100.0], 1.0)
    """

    waveform: AmplitudeModulated
    supply_v: float

    @property
    def duration_s(self) -> float:
        return self.waveform.duration_s

    @property
    def level_unit(self) -> str:
        return self.waveform.level_unit

    def at(self, level: float) -> Signal:
        """Return the samples (1, n_samples) in volt.

        Raises `LimitExceeded` if a half period needs more than the supply, or no half period needs a whole sample.
        """
        return pulses(self.waveform.at(level), self.supply_v)


def of_supply(waveform: AmplitudeModulated, rate_hz: float, supply_v: float) -> PulsedCarrier:
    """Return the waveform for the clock and supply of an amplifier."""
    return PulsedCarrier(replace(waveform, rate_hz=rate_hz), supply_v)


def pulses(signal: Signal, supply_v: float) -> Signal:
    """Return one pulse of the supply per run of samples with equal sign.

    Raises `LimitExceeded` if the mean square of a run is above that of the supply, or no run needs a whole sample.
    """
    sign = np.sign(signal.samples[0])
    starts = np.concatenate([[0], np.flatnonzero(np.diff(sign)) + 1])
    lengths = np.diff(np.concatenate([starts, [sign.size]]))
    needed = np.add.reduceat((signal.samples[0] / supply_v) ** 2, starts)  # number of samples at the supply
    _check_reach(needed, lengths, signal.peak, supply_v)
    whole = np.diff(np.rint(np.cumsum(needed)), prepend=0.0).astype(np.int64)  # the sum is exact to half a sample
    on = np.minimum(whole, lengths)
    edges = np.zeros(sign.size + 1)
    first = starts + (lengths - on) // 2
    np.add.at(edges, first, 1.0)
    np.add.at(edges, first + on, -1.0)
    return Signal(supply_v * (sign * np.cumsum(edges)[:-1])[None, :] + 0.0, signal.rate_hz, signal.unit)


def _check_reach(needed: FloatArray, lengths: IntArray, peak_v: float, supply_v: float) -> None:
    """Raise an error for a level above the supply or too low for a pulse."""
    share = float((needed / lengths).max(initial=0.0))
    if share > 1:
        raise LimitExceeded(
            f"level: found an effective voltage of {supply_v * np.sqrt(share):.4g} V, above the {supply_v:.4g} V of "
            "the supply; lower the level, or raise the supply"
        )
    longest = float(needed.max(initial=0.0))
    if 0 < longest < SHORTEST:
        raise LimitExceeded(
            f"level: found {peak_v:.4g} V, expected at least {peak_v * np.sqrt(SHORTEST / longest):.4g} V, which "
            f"pulses of {SHORTEST:g} sample at the {supply_v:.4g} V of the supply make; raise the level or the rate of "
            "the board, lower its supply, or let the session set the supply (lowest_supply_v of an output)"
        )
