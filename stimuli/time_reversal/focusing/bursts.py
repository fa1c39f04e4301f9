"""Foci whose level is set by the length of their bursts.

A drive that starts shortly before its focus makes a smaller focus: the sum of supply times response over the samples
that are on. Channels are switched on one by one, so that one step is one sample of one channel. The foci of a train are
computed in order, and each accounts for the motion left by earlier ones at its place.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from tactometry.arguments.require import expect, positive
from tactometry.errors import InvalidParameter, LimitExceeded
from tactometry.signal import Signal

from ...arrays import FloatArray, IntArray
from ..responses.responses import Responses
from .quantiser import Analogue, Quantiser

RESOLVED: Final = 0.02
"""Largest error of a focus, as a part of the largest one: 0.17 dB (unverified default)."""


@dataclass(frozen=True, eq=False)
class Bursts:
    """Trains of bursts at one supply.

    Raises `InvalidParameter` if an emission begins before the previous one has ended.

    Parameters
    ----------
    bits : sequence of (n_channels, n_reversal) array
        The whole emission of each focus, as -1 and +1.
    starts : (n_foci,) array of int
        First sample of each emission; emissions must not overlap.
    heard : Responses
        Displacement at the focus points, m per V.
    rows : sequence of int
        Row of `heard` for each focus.
    supply_v : float
        Supply voltage, above 0.

    >>> h = Responses(np.array([[[1.0, 2.0, 4.0]]]), 1e3)
    >>> Bursts([np.ones((1, 3))], np.array([0]), h, [0], 30.0).drive(np.array([90.0])).samples
    array([[ 0., 30., 30.]])
    """

    bits: Sequence[FloatArray]
    starts: IntArray
    heard: Responses
    rows: Sequence[int]
    supply_v: float

    def __post_init__(self) -> None:
        n_reversal = self.bits[0].shape[1]
        apart = int(np.diff(self.starts).min(initial=n_reversal))
        apart_s, reversal_s = apart / self.heard.rate_hz, n_reversal / self.heard.rate_hz
        longest = f"at most the {apart_s:g} s between foci, as supply_v makes one after another; shorten it"
        expect(n_reversal <= apart, "TimeReversalStimulus.reversal_s", f"{reversal_s:g} s", longest)

    @property
    def reach_m(self) -> float:
        """Amplitude of the largest possible first focus."""
        return float(self._made_m(self.bits[0], self.heard.samples[self.rows[0]]).max())

    def drive(self, amplitudes_m: FloatArray) -> Signal:
        """Return the drive (V: the supply, its negative or 0) with these foci.

        Raises `LimitExceeded` if no burst makes a focus within `RESOLVED`.
        """
        n_channels, n = self.bits[0].shape
        nearest_m = RESOLVED * float(np.abs(amplitudes_m).max())
        on = np.zeros((n_channels, int(self.starts[-1]) + n))
        for bits, start, row, wanted_m in zip(self.bits, self.starts, self.rows, amplitudes_m, strict=True):
            response = self.heard.samples[row]
            # motion left by earlier emissions at the place and instant of a focus
            instant = int(start) + n - 1
            first = max(0, instant - response.shape[1] + 1)
            lags = instant - np.arange(first, start)
            left_m = self.supply_v * float(np.sum(on[:, first:start] * response[:, lags]))

            missing_m = float(wanted_m) - left_m
            on[:, start : start + n] = np.sign(missing_m) * self._burst(bits, response, abs(missing_m), nearest_m)
        return Signal(self.supply_v * on + 0.0, self.heard.rate_hz, "V")

    def _burst(self, bits: FloatArray, response: FloatArray, missing_m: float, nearest_m: float) -> FloatArray:
        """Return the bits that add `missing_m`, latest first, and 0 elsewhere."""
        made_m = self._made_m(bits, response)
        n_on = int(np.argmin(np.abs(made_m - missing_m)))
        if abs(made_m[n_on] - missing_m) > nearest_m:
            raise LimitExceeded(
                f"a focus of {1e6 * missing_m:.4g} um, expected one that a burst at the {self.supply_v:.4g} V of the "
                f"supply makes: the nearest has {1e6 * made_m[n_on]:.4g} um"
            )
        is_on = np.arange(bits.size) < n_on
        return np.asarray(bits * is_on.reshape(bits.T.shape).T[:, ::-1])

    def _made_m(self, bits: FloatArray, response: FloatArray) -> FloatArray:
        """Return the focus made by the last 0, 1, ... samples that are on."""
        latest_first = (bits[:, ::-1] * response[:, : bits.shape[1]]).T.ravel()
        return self.supply_v * np.concatenate([[0.0], np.cumsum(latest_first)])


def check_supply(owner: str, supply_v: float | None, quantiser: Quantiser | None) -> None:
    """Raise an error if a supply is not positive or the drive is analogue."""
    if supply_v is None:
        return
    positive(owner, supply_v=supply_v)
    if isinstance(quantiser, Analogue):
        raise InvalidParameter(
            f'{owner}.supply_v: found {supply_v:g} with an analogue drive, expected drive = "one_bit" or a '
            "sigma-delta, whose values a supply can switch"
        )
