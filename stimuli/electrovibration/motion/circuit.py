"""The states of a circuit under a line and sinusoids, as one linear equation."""

from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray, IndexArray
from ..skin.relaxation import Relaxations


@dataclass(frozen=True)
class Circuit:
    """Which states the circuit has: relaxations, line, sinusoids; `active` says which relaxations still move.

    States in order: active relaxations; value of the line (if it counts); slope of the line (if any); for each
    frequency real and imaginary part of ``c exp(2 pi i f t)``.
    """

    relaxations: Relaxations
    frequencies_hz: tuple[float, ...]
    has_slope: bool
    active: tuple[bool, ...]

    @property
    def has_line(self) -> bool:
        return self.relaxations.dc_gain != 0

    def matrix(self) -> FloatArray:
        """(n_states, n_states) of their linear equation."""
        n_active, n = sum(self.active), self.n_states
        z = np.zeros((n, n))
        first = n - 2 * len(self.frequencies_hz)
        rates = [r for r, moves in zip(self.relaxations.rates_per_s, self.active, strict=True) if moves]
        z[range(n_active), range(n_active)] = np.negative(rates)
        if self.has_slope:
            z[: first - 1, first - 1] = 1.0  # the slope of the line drives the line and every relaxation
        for k, f_hz in enumerate(self.frequencies_hz):
            real, imag = first + 2 * k, first + 2 * k + 1
            omega = 2 * np.pi * f_hz
            z[real, imag], z[imag, real] = -omega, omega
            z[:n_active, imag] = -omega  # v' of the real part of a phasor is -omega times its imaginary part
        return z

    def output(self) -> FloatArray:
        """(n_states,) linear form that gives the voltage whose square is the force."""
        r = self.relaxations
        moving = [gain for gain, moves in zip(r.gains, self.active, strict=True) if moves]
        still = [(gain, rate) for gain, rate, m in zip(r.gains, r.rates_per_s, self.active, strict=True) if not m]
        # one that is still follows its input: a slope gives slope/rate, a sinusoid its response
        line = [r.dc_gain] if self.has_line else []
        slope = [sum(gain / rate for gain, rate in still)] if self.has_slope else []
        turns = Relaxations(tuple(g for g, _ in still), tuple(s for _, s in still), r.dc_gain)
        parts = [(h.real, -h.imag) for h in turns.response(self.frequencies_hz)]
        return np.array([*moving, *line, *slope, *(x for part in parts for x in part)])

    @property
    def n_states(self) -> int:
        return sum(self.active) + self.has_line + self.has_slope + 2 * len(self.frequencies_hz)

    def kept(self) -> IndexArray:
        """(n_states,) their places among the states of the circuit with all relaxations moving."""
        n_all = len(self.active) + self.n_states - sum(self.active)
        return np.flatnonzero([*self.active, *([True] * (n_all - len(self.active)))])
