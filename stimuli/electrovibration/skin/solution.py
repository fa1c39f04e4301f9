"""The exact answer of a circuit to a voltage in pieces: no step, no tolerance."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments.checked import checked
from tactometry.errors import InvalidParameter

from ...arrays import FloatArray, IndexArray
from ..waveforms.pieces import Pieces
from .relaxation import Relaxations, phi1, scan


@checked
@dataclass(frozen=True, eq=False)
class Solution:
    """The output of `relaxations` for the voltage `pieces`, from rest.

    In each piece a relaxation ``y' = -rate y + v'`` is its free decay, plus ``slope t phi1(rate t)`` for
    the line, plus ``c H exp(2 pi i f t)`` for each sinusoid.

    >>> from tactometry.stimuli.electrovibration import Skin, Step
    >>> solved = Solution(Step(duration_s=0.1).pieces(40.0), Skin().relaxations(1e-4))
    >>> solved.at([0.0, 1e-3]).round(6).tolist()
    [43.820225, 1.836016]
    """

    pieces: Pieces
    relaxations: Relaxations

    def at(self, t_s: ArrayLike) -> FloatArray:
        """The output, of the shape of `t_s` (0 to the end), from the right at a jump.

        Raises
        ------
        InvalidParameter
            If a time is before 0 or after the end.
        """
        t = self._times(t_s)
        total = self.relaxations.dc_gain * self.pieces.at(t) if self.relaxations.dc_gain else np.zeros_like(t)
        for order, gain in enumerate(self.relaxations.gains):
            total += gain * self.state_at(order, t)
        return np.asarray(total, dtype=np.float64)

    def slope_at(self, t_s: ArrayLike) -> FloatArray:
        """The time derivative of the output inside of the pieces, of the shape of `t_s`."""
        t = self._times(t_s)
        slope = voltage_slope(self.pieces, t)
        total = np.asarray(self.relaxations.dc_gain * slope)
        for order, (gain, rate) in enumerate(zip(self.relaxations.gains, self._rates, strict=True)):
            total += gain * (slope - rate * self.state_at(order, t))
        return np.asarray(total, dtype=np.float64)

    def state_at(self, order: int, t_s: FloatArray) -> FloatArray:
        """Relaxation number `order`, of gain 1, at the times."""
        rate = self._rates[order]
        if np.isinf(rate):
            return np.zeros_like(t_s)
        piece = self.pieces.index(t_s)
        elapsed = t_s - self.pieces.starts_s[piece]
        free = self.free_decays[order, piece] * np.exp(-rate * elapsed)
        return np.asarray(free + self._forced_response(order, piece, t_s))

    def _times(self, t_s: ArrayLike) -> FloatArray:
        t = np.asarray(t_s, dtype=np.float64)
        if t.size and not (t.min() >= 0 and t.max() <= self.pieces.end_s):
            raise InvalidParameter(
                f"Solution.t_s: found times from {t.min():.6g} to {t.max():.6g} s, expected 0 to the end of the "
                f"voltage ({self.pieces.end_s:.6g} s)"
            )
        return t

    @property
    def _rates(self) -> tuple[float, ...]:
        return self.relaxations.rates_per_s

    @cached_property
    def free_decays(self) -> FloatArray:
        """(n_relaxations, n_pieces): the amplitude of each free decay at the start of each piece."""
        chains = [self._chain(order) for order in range(len(self._rates))]
        return np.array(chains).reshape(len(chains), len(self.pieces.starts_s))

    def _chain(self, order: int) -> FloatArray:
        rate = self._rates[order]
        starts, index = self.pieces.starts_s, np.arange(len(self.pieces.starts_s))
        if np.isinf(rate):
            return np.zeros(len(starts))
        at_start = self._forced_response(order, index, starts)
        at_end = self._forced_response(order, index[:-1], starts[1:])
        # the free decay takes up what the forced parts of two neighbouring pieces lack to the jump between them
        gained = self.pieces.jumps_v() - at_start + np.r_[0.0, at_end]
        return scan(np.exp(-rate * np.diff(starts)), gained)

    def _forced_response(self, order: int, piece: IndexArray, t_s: FloatArray) -> FloatArray:
        rate = self._rates[order]
        elapsed = t_s - self.pieces.starts_s[piece]
        line = self.pieces.slopes_v_per_s[piece] * elapsed * phi1(rate * elapsed)
        response = Relaxations((1.0,), (rate,)).response(self.pieces.frequencies_hz)
        return line + self.pieces.sinusoids(t_s, response * self.pieces.harmonics_v[piece])


def voltage_slope(pieces: Pieces, t_s: FloatArray) -> FloatArray:
    """``dv/dt`` inside of the pieces, of the shape of `t_s`."""
    piece = pieces.index(t_s)
    omega = 2j * np.pi * pieces.frequencies_hz
    return np.asarray(pieces.slopes_v_per_s[piece] + pieces.sinusoids(t_s, omega * pieces.harmonics_v[piece]))
