"""A modulated carrier by the width of pulses, for amplifiers that switch between their supply, its negative and off.

The attraction goes with the square of the voltage, and a finger feels its course, not the carrier. In each half period
of the carrier the supply is on for as long as gives the mean square of the voltage asked for, and the rest of a sample
goes on to the next half period, so that the error of the slow course does not add up.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from tactometry.errors import LimitExceeded
from tactometry.signal import Signal

from ...arrays import FloatArray, IntArray
from .amplitude_modulated import AmplitudeModulated

SHORTEST: Final = 1.0
"""Samples of the widest pulse: below it, the force is off by more than 1 dB (simulation; unverified default)."""


@dataclass(frozen=True)
class PulsedCarrier:
    """The waveform through one supply (V, above 0), sample by sample on, reversed or off; of the same level.

    Examples
    --------
    >>> pulsed = PulsedCarrier(AmplitudeModulated(120.0, rate_hz=250e3, ramp_s=0.0), supply_v=100.0)
    >>> asked, made = pulsed.waveform.at(34.0), pulsed.at(34.0)
    >>> np.unique(made.samples).tolist(), round(float(np.mean(made.samples**2) / np.mean(asked.samples**2)), 3)
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
        """(1, n_samples) volt.

        Raises
        ------
        LimitExceeded
            If a half period needs more than the supply throughout, or none a whole sample.
        """
        return pulses(self.waveform.at(level), self.supply_v)


def of_supply(waveform: AmplitudeModulated, rate_hz: float, supply_v: float) -> PulsedCarrier:
    """The same waveform at the clock and the supply of an amplifier."""
    return PulsedCarrier(replace(waveform, rate_hz=rate_hz), supply_v)


def pulses(signal: Signal, supply_v: float) -> Signal:
    """One channel as pulses of the supply, one in the middle of each run of samples of one sign.

    Raises
    ------
    LimitExceeded
        If the mean square of a run is above that of the supply, or no run needs a whole sample.
    """
    sign = np.sign(signal.samples[0])
    starts = np.concatenate([[0], np.flatnonzero(np.diff(sign)) + 1])
    lengths = np.diff(np.concatenate([starts, [sign.size]]))
    needed = np.add.reduceat((signal.samples[0] / supply_v) ** 2, starts)  # samples at the supply
    _check_reach(needed, lengths, signal.peak, supply_v)
    on = np.minimum(_carried(needed), lengths)
    edges = np.zeros(sign.size + 1)
    first = starts + (lengths - on) // 2
    np.add.at(edges, first, 1.0)
    np.add.at(edges, first + on, -1.0)
    return Signal(supply_v * (sign * np.cumsum(edges)[:-1])[None, :] + 0.0, signal.rate_hz, signal.unit)


def _carried(needed: FloatArray) -> IntArray:
    """Whole samples of each run, whose sum up to any run is that of `needed` to half a sample."""
    return np.diff(np.rint(np.cumsum(needed)), prepend=0.0).astype(np.int64)


def _check_reach(needed: FloatArray, lengths: IntArray, peak_v: float, supply_v: float) -> None:
    """Refuse a level above the supply, or one whose longest pulse is shorter than a sample."""
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
            "the board, or lower its supply"
        )
