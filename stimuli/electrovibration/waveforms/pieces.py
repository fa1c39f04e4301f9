"""Voltages in pieces, each a line plus sinusoids."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments import require
from tactometry.arguments.checked import Positive, checked
from tactometry.errors import InvalidParameter

from ...arrays import ComplexArray, FloatArray, IndexArray

MOST_SAMPLES = 2**28


@checked
@dataclass(frozen=True, eq=False)
class Pieces:
    """A voltage in pieces, each a line plus sinusoids.

    ``v(t) = offset + slope (t - start) + sum_k Re(c_k exp(2 pi i f_k t))`` in each piece, 0 before the first piece,
    constant after the last.

    Raises `InvalidParameter` if the shapes do not fit, the starts are not ascending from 0, or a value is not finite.

    Parameters
    ----------
    starts_s : (n_pieces,) array
        Starts of the pieces, ascending from 0; each piece lasts until the next start.
    end_s : float
        End of the last piece.
    offsets_v, slopes_v_per_s : (n_pieces,) arrays
        The straight line of each piece.
    frequencies_hz : (n_harmonics,) array
        Frequencies of the sinusoids, above 0.
    amplitudes_v : (n_pieces, n_harmonics) array of complex
        ``c_k``, whose modulus is the amplitude and whose argument is the phase of the cosine at time 0 of the signal.

    >>> saw = Pieces(np.array([0.0, 1.0]), 2.0, np.zeros(2), np.array([1.0, 3.0]))
    >>> saw.at([0.5, 1.5, 9.0]).tolist()
    [0.5, 1.5, 3.0]
    """

    starts_s: FloatArray
    end_s: Positive
    offsets_v: FloatArray
    slopes_v_per_s: FloatArray
    frequencies_hz: FloatArray = field(default_factory=lambda: np.zeros(0))
    amplitudes_v: ComplexArray | None = None

    def __post_init__(self) -> None:
        n_pieces, n_harmonics = np.size(self.starts_s), np.size(self.frequencies_hz)
        amplitudes = np.zeros((n_pieces, 0)) if self.amplitudes_v is None else self.amplitudes_v
        object.__setattr__(self, "amplitudes_v", np.asarray(amplitudes, dtype=np.complex128))
        for name in ("starts_s", "offsets_v", "slopes_v_per_s"):
            self._check_shape(name, (n_pieces,))
        self._check_shape("frequencies_hz", (n_harmonics,))
        self._check_shape("amplitudes_v", (n_pieces, n_harmonics))
        above = (self.frequencies_hz > 0).all()
        require.expect(above, "Pieces.frequencies_hz", self.frequencies_hz, "numbers above 0")
        ascend = n_pieces > 0 and (np.diff(self.starts_s) > 0).all() and self.starts_s[-1] < self.end_s
        if not ascend or self.starts_s[0] != 0:
            raise InvalidParameter(
                f"Pieces.starts_s: found {self.starts_s} and an end of {self.end_s}, expected ascending times from 0"
            )

    def _check_shape(self, name: str, shape: tuple[int, ...]) -> None:
        found = getattr(self, name).shape
        require.expect(found == shape, f"Pieces.{name}", f"shape {found}", f"{shape}")

    @property
    def harmonics_v(self) -> ComplexArray:
        """Complex amplitudes (n_pieces, n_harmonics), never None."""
        return np.asarray(self.amplitudes_v, dtype=np.complex128)

    def index(self, t_s: ArrayLike) -> IndexArray:
        """Return the index of the piece at each time, the last one after the end."""
        result = np.searchsorted(self.starts_s, np.asarray(t_s, dtype=np.float64), side="right") - 1
        return np.maximum(result, 0)

    def at(self, t_s: ArrayLike) -> FloatArray:
        """Return the voltage at times.

        It has the shape of `t_s`. At a jump it is the value after the jump. It is 0 before time 0 and constant after
        the end.
        """
        t = np.minimum(np.asarray(t_s, dtype=np.float64), self.end_s)
        return np.where(t < 0, 0.0, self.value_in(self.index(t), t))

    def value_in(self, piece: IndexArray, t_s: FloatArray) -> FloatArray:
        """Return the formula of each `piece` at each time, even outside it."""
        line = self.offsets_v[piece] + self.slopes_v_per_s[piece] * (t_s - self.starts_s[piece])
        return line + self.sinusoids(t_s, self.harmonics_v[piece])

    def sinusoids(self, t_s: FloatArray, amplitudes: ComplexArray) -> FloatArray:
        """Return ``Re sum_k amplitudes_k exp(2 pi i f_k t)``."""
        fit = amplitudes.shape[-1:] == self.frequencies_hz.shape
        expected = f"(..., {len(self.frequencies_hz)}), one for each frequency"
        require.expect(fit, "Pieces.sinusoids.amplitudes", f"shape {amplitudes.shape}", expected)
        phases = np.exp(2j * np.pi * np.multiply.outer(t_s, self.frequencies_hz))
        return np.asarray((phases * amplitudes).sum(axis=-1).real, dtype=np.float64)

    def jumps_v(self) -> FloatArray:
        """Return the jump at the start of each piece, the first one from 0 V."""
        index = np.arange(len(self.starts_s))
        after = self.value_in(index, self.starts_s)
        before = np.r_[0.0, self.value_in(index[:-1], self.starts_s[1:])]
        return np.asarray(after - before)

    def scaled(self, factor: float) -> "Pieces":
        """Return the pieces with the voltage multiplied by `factor`."""
        return replace(
            self,
            offsets_v=factor * self.offsets_v,
            slopes_v_per_s=factor * self.slopes_v_per_s,
            amplitudes_v=factor * self.harmonics_v,
        )

    def split_at(self, times_s: ArrayLike) -> "Pieces":
        """Return the same voltage, with pieces split at `times_s`."""
        times = np.asarray(times_s, dtype=np.float64)
        starts = np.unique(np.r_[self.starts_s, times[(times > 0) & (times < self.end_s)]])
        piece = self.index(starts)
        lines = self.offsets_v[piece] + self.slopes_v_per_s[piece] * (starts - self.starts_s[piece])
        return replace(
            self,
            starts_s=starts,
            offsets_v=lines,
            slopes_v_per_s=self.slopes_v_per_s[piece],
            amplitudes_v=self.harmonics_v[piece],
        )


@checked
def straight(times_s: ArrayLike, values_v: ArrayLike) -> Pieces:
    """Return straight lines between points; a repeated time makes a jump.

    >>> straight([0, 1, 1, 2], [0, 1, 5, 5]).at([0.5, 1.0, 2.0]).tolist()
    [0.5, 5.0, 5.0]
    """
    t = np.asarray(times_s, dtype=np.float64)
    v = np.asarray(values_v, dtype=np.float64)
    row = t.ndim == 1 and t.shape == v.shape and t.size >= 2
    require.expect(row, "straight", f"shapes {t.shape} and {v.shape}", "equal lengths")
    back = int(np.argmax(np.diff(t) < 0))
    step_back = f"{t[back + 1]} after {t[back]}"
    require.expect(t[back + 1] >= t[back], "straight.times_s", step_back, "times in ascending order")
    long = np.diff(t) > 0
    return Pieces(t[:-1][long], float(t[-1]), v[:-1][long], (np.diff(v)[long] / np.diff(t)[long]))


def ramped(pieces: Pieces, ramp_s: float) -> Pieces:
    """Multiply a voltage by raised-cosine onset and offset ramps, exactly.

    Raises `InvalidParameter` if the voltage has a slope: a line times a cosine is not a sum of a line and sinusoids.
    """
    if ramp_s == 0:
        return pieces
    if pieces.slopes_v_per_s.any():
        raise InvalidParameter(
            f"ramp_s: found {ramp_s} s for a voltage with slopes, expected 0: a raised cosine times a slope "
            "has no exact description; sample the signal instead"
        )
    split = pieces.split_at([ramp_s, pieces.end_s - ramp_s])
    middles = split.starts_s + np.diff(np.r_[split.starts_s, split.end_s]) / 2
    rising, falling = middles < ramp_s, middles > pieces.end_s - ramp_s
    turn = np.exp(-1j * np.pi * pieces.end_s / ramp_s)
    swing = np.where(rising, 1.0, 0.0) + np.where(falling, turn, 0.0)
    return _modulated(split, np.where(rising | falling, 0.5, 1.0), -swing / 2, 1 / (2 * ramp_s))


def _modulated(pieces: Pieces, mean: FloatArray, cosine: ComplexArray, frequency_hz: float) -> Pieces:
    """Return ``v (mean + Re(cosine exp(2 pi i f t)))`` of pieces."""
    f_hz, c = pieces.frequencies_hz, pieces.harmonics_v
    blocks = [
        (f_hz, mean[:, None] * c),
        (f_hz + frequency_hz, cosine[:, None] * c / 2),
        (f_hz - frequency_hz, np.conj(cosine)[:, None] * c / 2),
        (np.array([frequency_hz]), (cosine * pieces.offsets_v)[:, None]),
    ]
    return _merged(replace(pieces, offsets_v=mean * pieces.offsets_v), blocks)


def _merged(pieces: Pieces, blocks: list[tuple[FloatArray, ComplexArray]]) -> Pieces:
    """Return the pieces with these sinusoids only, at positive frequencies."""
    f_hz = np.concatenate([block[0] for block in blocks])
    c = np.concatenate([block[1] for block in blocks], axis=1)
    c = np.where(f_hz < 0, np.conj(c), c)
    constant = c[:, f_hz == 0].real.sum(axis=1)
    used = (f_hz != 0) & (c != 0).any(axis=0)
    return replace(
        pieces, offsets_v=pieces.offsets_v + constant, frequencies_hz=np.abs(f_hz[used]), amplitudes_v=c[:, used]
    )


NODES = range(-5, 7)


@checked
@dataclass(frozen=True)
class Corners:
    """Straight lines between corners (phase in 0..1, value); two corners at the same phase make a jump.

    >>> Corners((0, 0.5, 0.5, 1), (1, 1, -1, -1)).at([0.0, 0.5, 0.75]).tolist()
    [1.0, -1.0, -1.0]
    """

    phases: tuple[float, ...]
    values: tuple[float, ...]

    def __post_init__(self) -> None:
        ends = (self.phases[:1], self.phases[-1:]) == ((0.0,), (1.0,))
        fit = ends and len(self.phases) == len(self.values) and (np.diff(self.phases) >= 0).all()
        found = f"{self.phases!s:.60} with {len(self.values)} values"
        require.expect(fit, "Corners.phases", found, "a tuple that ascends from 0 to 1, with one value each")

    def at(self, phase: ArrayLike) -> FloatArray:
        """Return values at phases (in periods), after a jump if there is one."""
        p = np.mod(np.asarray(phase, dtype=np.float64), 1.0)
        left = np.searchsorted(self.phases, p, side="right") - 1
        left = np.minimum(left, len(self.phases) - 2)
        x, y = np.asarray(self.phases, dtype=np.float64), np.asarray(self.values, dtype=np.float64)
        width = np.where(x[left + 1] > x[left], x[left + 1] - x[left], 1.0)
        return np.asarray(y[left] + (y[left + 1] - y[left]) * (p - x[left]) / width)

    def pieces(self, frequency_hz: Positive, duration_s: Positive) -> Pieces:
        """Return the periodic voltage (1 V) over a duration, exactly."""
        few = duration_s * frequency_hz <= MOST_SAMPLES
        require.expect(few, "Corners.pieces.duration_s", f"{duration_s} s", f"at most {MOST_SAMPLES} periods")
        n_periods = int(np.ceil(duration_s * frequency_hz * (1 - 1e-12)))
        periods = np.repeat(np.arange(n_periods), len(self.phases))
        t_s = (periods + np.tile(self.phases, n_periods)) / frequency_hz
        pieces = straight(t_s, np.tile(self.values, n_periods))
        kept = pieces.starts_s < duration_s * (1 - 1e-12)
        return Pieces(pieces.starts_s[kept], duration_s, pieces.offsets_v[kept], pieces.slopes_v_per_s[kept])

    def harmonics(self, n: ArrayLike) -> ComplexArray:
        """Return Fourier coefficients ``c_n`` for whole n other than 0.

        Integration by parts on each line yields jumps over ``2 pi i n`` and kinks over ``(2 pi i n)^2``.
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
        """True if half periods have opposite signs, so that the force frequency doubles."""
        middles = np.concatenate([self.phases, np.mod(np.add(self.phases, 0.5), 1.0), [0.0, 1.0]])
        middles = np.unique(middles)
        probe = (middles[1:] + middles[:-1]) / 2
        return bool(np.allclose(self.at(probe), -self.at(probe + 0.5), atol=1e-12))

    def band_limited(self, phase: FloatArray, n_highest: int) -> FloatArray:
        """Return the Fourier series up to `n_highest`, with a peak of at most 1.

        A truncated series overshoots at a jump (Gibbs, 9 %); it is then scaled down to peak 1. One FFT samples the
        series 16 times finer than its highest harmonic; a polynomial through the 12 nearest values is exact to 1e-12
        there. The cost is one FFT and 12 products per sample.
        """
        require.whole("Corners.band_limited", lowest=0, n_highest=n_highest)
        coefficients = self.harmonics(np.arange(1, n_highest + 1)) if n_highest else np.zeros(0, complex)
        n_table = 1 << int(np.ceil(np.log2(16 * (n_highest + 1))))
        table = np.fft.irfft(np.r_[self.mean, coefficients], n=n_table, norm="forward")
        series = _between(table, np.mod(phase, 1.0))
        peak = max(1.0, float(np.abs(table).max()), float(np.abs(series).max(initial=0.0)))
        return np.asarray(series / peak)


def _between(table: FloatArray, phase: FloatArray) -> FloatArray:
    """Interpolate a table (n_table,) of one period by Lagrange polynomials."""
    place = phase * table.size
    left = np.floor(place)
    u, first = np.maximum(place - left, 1e-300), left.astype(np.int64)
    total = np.zeros_like(u)
    for node in NODES:
        others = [float(node - other) for other in NODES if other != node]
        total += table[(first + node) % table.size] / (np.prod(others) * (u - node))
    return np.asarray(total * np.prod([u - node for node in NODES], axis=0))


@dataclass(frozen=True, eq=False)
class VoltageRecord:
    """Samples (n_samples,) of a voltage and their rate."""

    voltage_v: FloatArray
    rate_hz: float

    @property
    def t_s(self) -> FloatArray:
        return np.arange(self.voltage_v.size) / self.rate_hz
