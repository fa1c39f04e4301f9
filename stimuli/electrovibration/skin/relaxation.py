"""Sums of first-order high-passes, exact for piecewise-linear input."""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments import require
from tactometry.arguments.checked import Positive, checked
from tactometry.errors import InvalidParameter

from ...arrays import ComplexArray, FloatArray, IndexArray
from ..waveforms.pieces import Pieces

BLOCK = 32
AT_ONCE = 128
"""Blocks per matrix product: few enough that BLAS starts no threads."""


@dataclass(frozen=True)
class Relaxations:
    """The transfer function ``H(s) = dc_gain + sum_m gain_m s/(s + rate_m)`` of a stack of leaky capacitors.

    A rate of 0 passes everything, a rate of ``inf`` nothing.

    >>> Relaxations((0.5,), (100.0,)).response([0.0]).tolist()
    [0j]
    """

    gains: tuple[float, ...]
    rates_per_s: tuple[float, ...]
    dc_gain: float = 0.0

    def __post_init__(self) -> None:
        require.finite("Relaxations", dc_gain=self.dc_gain)
        gains = require.finite_array("Relaxations.gains", self.gains)
        rates = require.array("Relaxations.rates_per_s", self.rates_per_s)
        fit = gains.ndim == 1 and gains.shape == rates.shape and (rates >= 0).all()
        terms = f"the gains {self.gains!s:.60} and the rates {self.rates_per_s!s:.60}"
        require.expect(fit, "Relaxations", terms, "equal numbers, with rates of at least 0")

    @checked
    def response(self, frequency_hz: ArrayLike) -> ComplexArray:
        """Return ``H(2 pi i f)``, with the shape of `frequency_hz` (at least 0)."""
        f_hz = require.not_negative_array("Relaxations.response.frequency_hz", frequency_hz)
        s = np.asarray(2j * np.pi * f_hz, dtype=np.complex128)
        terms = (gain * _high_pass(s, rate) for gain, rate in zip(self.gains, self.rates_per_s, strict=True))
        return np.asarray(sum(terms, start=self.dc_gain + np.zeros_like(s)))

    @checked
    def sampled(self, voltage_v: FloatArray, rate_hz: Positive) -> FloatArray:
        """Return the output (..., n_samples) of an input of that shape, from rest.

        The input is linear between its samples and jumps from 0 to its first value at time 0.
        """
        steps_v = np.diff(voltage_v, prepend=0.0, axis=-1)
        terms = (
            gain * high_passed(steps_v, rate / rate_hz) for gain, rate in zip(self.gains, self.rates_per_s, strict=True)
        )
        return np.asarray(sum(terms, start=self.dc_gain * voltage_v))


def phi1(x: ArrayLike) -> FloatArray:
    """Return ``(1 - exp(-x))/x``, 1 at 0 and 0 at inf.

    >>> phi1([0.0, 1e-20, 1.0, float("inf")]).round(6).tolist()
    [1.0, 1.0, 0.632121, 0.0]
    """
    x = np.asarray(x, dtype=np.float64)
    safe = np.where(x == 0, 1.0, x)  # `where` computes both branches: avoid 0/0 in the unused one
    return np.where(x == 0, 1.0, -np.expm1(-safe) / safe)


def scan(decays: FloatArray, gained: FloatArray) -> FloatArray:
    """Return ``y_n = decays_(n-1) y_(n-1) + gained_n`` by doubling.

    >>> scan(np.array([0.5, 0.0]), np.array([1.0, 1.0, 7.0])).tolist()
    [1.0, 1.5, 7.0]
    """
    total, factor, reach = gained.copy(), np.r_[0.0, decays], 1
    # before each round total_n is the gain of the last `reach` steps, factor_n the product of their decays
    while reach < total.size and factor.any():
        total[reach:] += factor[reach:] * total[:-reach]
        factor[reach:] *= factor[:-reach]
        reach *= 2
    return total


def high_passed(steps_v: FloatArray, decay: float) -> FloatArray:
    """Solve ``y' = -rate y + v'`` for a piecewise-linear v.

    Parameters
    ----------
    steps_v : (..., n_samples) array
        Increments of v: the first is a jump, later ones are ramps over one sample.
    decay : float
        ``rate/rate_hz``, the exponent over one sample, 0 to inf.

    Notes
    -----
    ``y_n = exp(-decay) y_(n-1) + phi1(decay) step_n``.
    """
    weighted = steps_v * phi1(decay)
    # the first is a jump, which passes unchanged; an infinitely fast relaxation passes nothing
    weighted[..., :1] = steps_v[..., :1] * (0.0 if np.isinf(decay) else 1.0)
    return decaying_sum(weighted, decay)


def decaying_sum(values: FloatArray, decay: float) -> FloatArray:
    """Return ``y_n = exp(-decay) y_(n-1) + x_n`` along the last axis.

    The initial value of a block decays by exponentials, not by repeated products, in which the rounding of
    ``exp(-decay)`` near 1 would accumulate (1e-9 over 1e7 samples).

    >>> decaying_sum(np.array([1.0, 1.0, 0.0]), np.log(2)).tolist()
    [1.0, 1.5, 0.75]
    """
    *lead, n = values.shape
    stack = min(-(-n // BLOCK), AT_ONCE)
    n_blocks = stack * -(-n // max(stack * BLOCK, 1))
    padded = np.zeros((*lead, n_blocks * BLOCK))
    padded[..., :n] = values
    blocks = padded.reshape(*lead, n_blocks // max(stack, 1), stack, BLOCK) @ _decays(decay).T
    blocks = blocks.reshape(*lead, n_blocks, BLOCK)
    if n_blocks > 1:
        before = decaying_sum(blocks[..., -1], decay * BLOCK)[..., :-1, None]
        blocks[..., 1:, :] += before * np.exp(-decay * np.arange(1, BLOCK + 1))
    return blocks.reshape(*lead, n_blocks * BLOCK)[..., :n]


@lru_cache(maxsize=64)
def _decays(decay: float) -> FloatArray:
    """Return the weights (BLOCK, BLOCK) of earlier values at later ones."""
    later = np.subtract.outer(np.arange(BLOCK), np.arange(BLOCK))
    passed = np.multiply(decay, later, out=np.zeros(later.shape), where=later > 0)
    return np.tril(np.exp(-passed))


def _high_pass(s: ComplexArray, rate_per_s: float) -> ComplexArray:
    if rate_per_s == 0:
        return np.ones_like(s)
    if np.isinf(rate_per_s):
        return np.zeros_like(s)
    return s / (s + rate_per_s)


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
        """Return the output at `t_s` (0 to the end), after a jump if there is one.

        Raises `InvalidParameter` if a time is before 0 or after the end.
        """
        t = self._times(t_s)
        total = self.relaxations.dc_gain * self.pieces.at(t) if self.relaxations.dc_gain else np.zeros_like(t)
        for order, gain in enumerate(self.relaxations.gains):
            total += gain * self.state_at(order, t)
        return np.asarray(total, dtype=np.float64)

    def state_at(self, order: int, t_s: FloatArray) -> FloatArray:
        """Return relaxation number `order`, with gain 1, at the times."""
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
        """Return free decays at the piece starts, (n_relaxations, n_pieces)."""
        chains = [self._chain(order) for order in range(len(self._rates))]
        return np.array(chains).reshape(len(chains), len(self.pieces.starts_s))

    def _chain(self, order: int) -> FloatArray:
        rate = self._rates[order]
        starts, index = self.pieces.starts_s, np.arange(len(self.pieces.starts_s))
        if np.isinf(rate):
            return np.zeros(len(starts))
        at_start = self._forced_response(order, index, starts)
        at_end = self._forced_response(order, index[:-1], starts[1:])
        # the free decay absorbs the jump minus the difference of the forced parts of neighbouring pieces
        gained = self.pieces.jumps_v() - at_start + np.r_[0.0, at_end]
        return scan(np.exp(-rate * np.diff(starts)), gained)

    def _forced_response(self, order: int, piece: IndexArray, t_s: FloatArray) -> FloatArray:
        rate = self._rates[order]
        elapsed = t_s - self.pieces.starts_s[piece]
        line = self.pieces.slopes_v_per_s[piece] * elapsed * phi1(rate * elapsed)
        response = Relaxations((1.0,), (rate,)).response(self.pieces.frequencies_hz)
        return line + self.pieces.sinusoids(t_s, response * self.pieces.harmonics_v[piece])
