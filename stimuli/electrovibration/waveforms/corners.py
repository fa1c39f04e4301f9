"""One period of a polygon: sampled, in exact pieces, or band-limited."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments import require
from tactometry.arguments.annotations import Positive
from tactometry.arguments.checked import checked
from tactometry.errors import InvalidParameter

from ...arrays import ComplexArray, FloatArray
from .pieces import Pieces, straight
from .waveform import MOST_SAMPLES

NODES = range(-5, 7)


@checked
@dataclass(frozen=True)
class Corners:
    """Straight lines between corners (phase in 0..1, value); two corners of one phase are a jump.

    >>> Corners((0, 0.5, 0.5, 1), (1, 1, -1, -1)).at([0.0, 0.5, 0.75]).tolist()
    [1.0, -1.0, -1.0]
    """

    phases: tuple[float, ...]
    values: tuple[float, ...]

    def __post_init__(self) -> None:
        ends = (self.phases[:1], self.phases[-1:]) == ((0.0,), (1.0,))
        fit = ends and len(self.phases) == len(self.values) and (np.diff(self.phases) >= 0).all()
        found = f"{self.phases!s:.60} with {len(self.values)} values"
        require.expect(fit, "Corners.phases", found, "a tuple that ascends from 0 to 1, and as many values")

    def at(self, phase: ArrayLike) -> FloatArray:
        """Values at phases in periods, of any size; from the right at a jump."""
        p = np.mod(np.asarray(phase, dtype=np.float64), 1.0)
        left = np.searchsorted(self.phases, p, side="right") - 1
        left = np.minimum(left, len(self.phases) - 2)
        x, y = np.asarray(self.phases, dtype=np.float64), np.asarray(self.values, dtype=np.float64)
        width = np.where(x[left + 1] > x[left], x[left + 1] - x[left], 1.0)
        return np.asarray(y[left] + (y[left + 1] - y[left]) * (p - x[left]) / width)

    def pieces(self, frequency_hz: Positive, duration_s: Positive) -> Pieces:
        """The periodic voltage (1 V) over a duration, exactly."""
        few = duration_s * frequency_hz <= MOST_SAMPLES
        require.expect(few, "Corners.pieces.duration_s", f"{duration_s} s", f"at most {MOST_SAMPLES} periods")
        n_periods = int(np.ceil(duration_s * frequency_hz * (1 - 1e-12)))
        periods = np.repeat(np.arange(n_periods), len(self.phases))
        t_s = (periods + np.tile(self.phases, n_periods)) / frequency_hz
        return _until(straight(t_s, np.tile(self.values, n_periods)), duration_s)

    def harmonics(self, n: ArrayLike) -> ComplexArray:
        """Fourier coefficients ``c_n`` of ``v = sum_n c_n exp(2 pi i n phase)`` for whole n other than 0.

        Integrated by parts on each line: jumps over ``2 pi i n`` and kinks over ``(2 pi i n)^2``.
        """
        n = np.asarray(n, dtype=np.float64)
        if (n == 0).any() or (n != np.round(n)).any():
            raise InvalidParameter(
                f"Corners.harmonics.n: found {n.tolist()!s:.60}, expected whole numbers other than 0"
            )
        x, y = np.asarray(self.phases, dtype=np.float64), np.asarray(self.values, dtype=np.float64)
        s = 2j * np.pi * n[..., None]
        rise, run = np.diff(y), np.diff(x)
        slope = np.divide(rise, run, out=np.zeros_like(rise), where=run > 0)
        turns = np.exp(-s * x)
        jumps = np.where(run > 0, 0.0, rise)
        edge = (turns[..., :-1] * jumps).sum(axis=-1) + y[0] - y[-1]
        kinks = (slope * (turns[..., :-1] - turns[..., 1:])).sum(axis=-1)
        return np.asarray(edge / s[..., 0] + kinks / s[..., 0] ** 2)

    @property
    def mean(self) -> float:
        return float(np.trapezoid(self.values, self.phases))

    @property
    def is_antisymmetric(self) -> bool:
        """Whether half a period later the value is the opposite one: the square has twice the frequency."""
        middles = np.concatenate([self.phases, np.mod(np.add(self.phases, 0.5), 1.0), [0.0, 1.0]])
        middles = np.unique(middles)
        probe = (middles[1:] + middles[:-1]) / 2
        return bool(np.allclose(self.at(probe), -self.at(probe + 0.5), atol=1e-12))

    def band_limited(self, phase: FloatArray, n_highest: int) -> FloatArray:
        """Values of the Fourier series up to harmonic `n_highest`, of peak at most 1 over a fine period.

        Cut short at an edge, the series overshoots (Gibbs, 9 % of a jump): it is scaled down to peak 1
        where it does. One FFT samples the series 16 times finer than its highest harmonic; a polynomial through the
        12 nearest values is exact to 1e-12 there, so the cost is that of the FFT and of 12 values per sample.
        """
        require.whole("Corners.band_limited", lowest=0, n_highest=n_highest)
        coefficients = self.harmonics(np.arange(1, n_highest + 1)) if n_highest else np.zeros(0, complex)
        table = np.fft.irfft(np.r_[self.mean, coefficients], n=_table_size(n_highest), norm="forward")
        series = _between(table, np.mod(phase, 1.0))
        peak = max(1.0, float(np.abs(table).max()), float(np.abs(series).max(initial=0.0)))
        return np.asarray(series / peak)


def _until(pieces: Pieces, end_s: float) -> Pieces:
    kept = pieces.starts_s < end_s * (1 - 1e-12)
    return Pieces(pieces.starts_s[kept], end_s, pieces.offsets_v[kept], pieces.slopes_v_per_s[kept])


def _between(table: FloatArray, phase: FloatArray) -> FloatArray:
    """Lagrange polynomial through the nearest `NODES` values of one period (n_table,), at phases in 0..1."""
    place = phase * table.size
    left = np.floor(place)
    u, first = np.maximum(place - left, 1e-300), left.astype(np.int64)
    total = np.zeros_like(u)
    for node in NODES:
        others = [float(node - other) for other in NODES if other != node]
        total += table[(first + node) % table.size] / (np.prod(others) * (u - node))
    return np.asarray(total * np.prod([u - node for node in NODES], axis=0))


def _table_size(n_highest: int) -> int:
    return 1 << int(np.ceil(np.log2(16 * (n_highest + 1))))
