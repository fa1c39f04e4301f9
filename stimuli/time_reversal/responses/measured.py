"""Measured impulse responses: read, align, trim and check.

Files
-----
WAV : one file per point, one channel per transducer. The rate is in the header; the caller states full scale in m (m/s,
m/s^2) per unit of the drive. 8-bit samples are unsigned around 128.
NPZ, HDF5 : ``samples`` (n_points, n_channels, n_samples), ``rate_hz``, and optionally ``quantity``.
CSV : first line ``# rate_hz=100000 quantity=displacement unit=um``, then a header row with one name per
    transducer and one column each; one file per point. ``scale`` is a factor on top of the unit.
"""

import io
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from tactometry.arguments.checked import Positive, Vector, checked
from tactometry.arguments.require import expect, one_of, shape, some, within
from tactometry.errors import InvalidFile, InvalidParameter
from tactometry.files.durable import LARGEST_BYTES, read_file
from tactometry.files.hdf5 import as_npz
from tactometry.files.samples import Npz, table_of_numbers, wav_of

from ...arrays import FloatArray, IndexArray, IntArray
from .responses import Responses

N_BLOCKS: Final = 32
LEAST_FALL_DB: Final = 10.0
FAINTEST: Final = 1e-7
"""A record ends at its last sample above this part of its peak (-140 dB)."""
LOWEST_LOG_FLOOR: Final = -69.0
"""Logarithm of the lowest energy re the loudest block, -300 dB; lower energies count as this floor."""


@checked
def schroeder_db(response: FloatArray) -> FloatArray:
    """Return the remaining energy at each sample in dB (Schroeder)."""
    expect(np.any(response), "response", "zero everywhere", "an impulse response")
    to_come = np.cumsum(np.square(response)[..., ::-1], axis=-1)[..., ::-1]
    with np.errstate(divide="ignore"):
        return np.asarray(10 * np.log10(to_come / to_come[..., :1]))


@checked
@dataclass(frozen=True)
class Decay:
    """Fitted energy A (exp(-2 n_taus t) + floor), t from 0 to 1; `fall_db` is from the loudest block to the end."""

    n_taus: float
    floor: float
    fall_db: float


@checked
def tau_s(response: Vector, rate_hz: Positive) -> float:
    """Return the time constant of the amplitude of one response.

    Raises `InvalidParameter` if the response is silent, or falls by less than 10 dB before its end or noise floor.

    Parameters
    ----------
    response : (n_samples,) array

    >>> t = np.arange(10000) / 1e5
    >>> round(tau_s(np.exp(-t / 4e-3) * np.sin(1e4 * t), 1e5) * 1e3, 1)
    4.0
    """
    energy, length_s = _blocks(np.asarray(response, float)[None], rate_hz)
    return length_s / _clear_decay(energy[0]).n_taus


@checked
def decay_of(energy: Vector, kept: IndexArray | None = None) -> Decay:
    """Fit the log energy (`N_BLOCKS`,) of equal blocks."""
    if len(energy) != N_BLOCKS or energy.min() < 0 or not energy.any():
        raise InvalidParameter(f"energy: found {len(energy)} blocks, expected {N_BLOCKS} of at least 0, not all zero")
    first = _first(energy)
    kept = np.arange(first, N_BLOCKS) if kept is None else kept
    time = (kept + 0.5) / N_BLOCKS
    level = np.log(np.maximum(energy[kept], energy.max() * math.exp(LOWEST_LOG_FLOOR)))
    # start from a very low, a middle and a high floor, and keep the closest fit
    fits = [_fit(time, level, log_floor) for log_floor in (-60.0, -25.0, -3.0)]
    _, n_taus, log_floor = min(fits)[1]
    ends = np.exp(-2 * n_taus * np.array([first / N_BLOCKS, 1.0])) + math.exp(log_floor)
    return Decay(n_taus, math.exp(log_floor), float(10 * np.log10(ends[0] / ends[1])))


def _fit(time: FloatArray, level: FloatArray, log_floor: float) -> tuple[float, tuple[float, ...]]:
    """Return cost and (ln A, n_taus, ln floor) of a fit, given a first floor."""
    from scipy.optimize import least_squares

    def misfit(x: FloatArray) -> FloatArray:
        return np.asarray(x[0] + np.logaddexp(-2 * x[1] * time, x[2]) - level)

    def slopes(x: FloatArray) -> FloatArray:
        # share of the decay in the energy; the floor is the rest
        share = np.exp(-2 * x[1] * time - np.logaddexp(-2 * x[1] * time, x[2]))
        return np.stack([np.ones_like(time), -2 * time * share, 1 - share], axis=1)

    middle = len(time) // 2
    start = float(np.clip((level[0] - level[middle]) / (2 * (time[middle] - time[0])), 0.1, 400.0))
    limits = ([-np.inf, 1e-3, LOWEST_LOG_FLOOR], [np.inf, 500.0, 5.0])
    solution = least_squares(misfit, [level[0], start, log_floor], slopes, bounds=limits)
    return float(solution.cost), tuple(map(float, solution.x))


def _blocks(responses: FloatArray, rate_hz: float) -> tuple[FloatArray, float]:
    """Return the mean energy (n, `N_BLOCKS`) of blocks, and their length."""
    loudest = np.abs(responses).max(axis=0)
    sounding = np.flatnonzero(loudest > FAINTEST * loudest.max(initial=0.0))
    expect(len(sounding) > 0, "response", "zero everywhere", "an impulse response")
    size = (int(sounding[-1]) + 1) // N_BLOCKS
    expect(size >= 1, "response", f"{sounding[-1] + 1} samples", f"at least {N_BLOCKS}")
    cut = responses[:, : size * N_BLOCKS].reshape(-1, N_BLOCKS, size)
    return np.asarray(np.square(cut).mean(axis=2)), size * N_BLOCKS / rate_hz


def _first(energy: FloatArray) -> int:
    return max(1, int(np.argmax(energy)))


def _clear_decay(energy: FloatArray) -> Decay:
    expect(_first(energy) <= N_BLOCKS // 2, "response", "its loudest part in the second half", "a decay; learn longer")
    decay = decay_of(energy)
    found = f"a fall by {decay.fall_db:.1f} dB before its end or noise floor"
    expected = f"at least {LEAST_FALL_DB:.0f} dB; learn longer responses, or average more of them"
    expect(decay.fall_db >= LEAST_FALL_DB, "response", found, expected)
    return decay


CLIPPED_RUN: Final = 3
"""Number of equal samples at the extreme of a channel that indicate clipping."""

_PREFIXES: Final = {"": 1.0, "m": 1e-3, "u": 1e-6, "µ": 1e-6, "n": 1e-9}
_UNITS: Final = {"displacement": "m", "velocity": "m/s", "acceleration": "m/s2"}
_CSV_WORDS: Final = ("rate_hz", "quantity", "unit", "scale")


FLUCTUATION: Final = 20.0
"""Factor by which a tenth of one pair may exceed the common decay in power; unverified default."""


@checked
def read(paths: Sequence[Path], *, full_scale: Positive = 1.0, quantity: str = "displacement") -> Responses:
    """Read responses from files, one point per file or several in one.

    Raises `InvalidFile` if a file cannot be read in its format or the files do not match.

    Parameters
    ----------
    paths : sequence of Path
        ``.wav``, ``.npz``, ``.h5``, ``.hdf5`` or ``.csv``, all with the same rate, channels and length.
    full_scale : float
        Value of a WAV sample of 1.0, in the unit of `quantity` per unit of the drive.
    quantity : str
        Quantity of files that do not state it.
    """
    some("read.paths", paths)
    parts = [_read_one(Path(path), full_scale, quantity) for path in paths]
    for path, part in zip(paths, parts, strict=True):
        if _kind(part) != _kind(parts[0]):
            raise InvalidFile(
                f"{path}: found {part.samples.shape[1]} channels of {part.n_samples} samples at {part.rate_hz} Hz "
                f"({part.quantity}), expected the same as in {paths[0]}"
            )
    return replace(parts[0], samples=np.concatenate([part.samples for part in parts]))


@checked
def trimmed(responses: Responses, start_s: float, duration_s: float) -> Responses:
    first, n = round(start_s * responses.rate_hz), round(duration_s * responses.rate_hz)
    found, expected = f"{start_s} and {duration_s}", f"a piece of {responses.duration_s} s"
    expect(first >= 0 and n >= 1 and first + n <= responses.n_samples, "start_s, duration_s", found, expected)
    return replace(responses, samples=responses.samples[:, :, first : first + n])


@checked
def aligned(responses: Responses, delay_s: Sequence[float]) -> Responses:
    """Shift channels earlier by their delays, to fractions of a sample.

    Parameters
    ----------
    delay_s : sequence of float
        Delay of each channel: latency of output and trigger. Samples before time 0 are cut off.
    """
    expect(len(delay_s) == responses.n_channels, "delay_s", len(delay_s), f"{responses.n_channels}, one per channel")
    n_fft = 2 * responses.n_samples
    frequency_hz = np.fft.rfftfreq(n_fft, 1 / responses.rate_hz)
    ramp = np.exp(2j * np.pi * frequency_hz * np.asarray(delay_s, float)[:, None])
    moved = np.fft.irfft(np.fft.rfft(responses.samples, n_fft) * ramp, n_fft)
    return replace(responses, samples=moved[:, :, : responses.n_samples])


@checked
@dataclass(frozen=True)
class Findings:
    """Defects of measured responses as tuples of (point, channel).

    `clipped` responses repeat their largest value, `silent` ones are zero, and `noisy` ones end less than `snr_db`
    below their start.
    """

    clipped: tuple[tuple[int, int], ...]
    silent: tuple[tuple[int, int], ...]
    noisy: tuple[tuple[int, int], ...]

    @property
    def sound(self) -> bool:
        return not (self.clipped or self.silent or self.noisy)


@checked
def inspect(responses: Responses, snr_db: float = 20.0) -> Findings:
    """Check for clipping, silent channels and a high noise floor.

    The floor is the mean power of the last tenth, compared with that of the loudest tenth. In a short record, the end
    may be as loud as the common decay of the pairs predicts.
    """
    within("inspect", -300.0, 300.0, snr_db=snr_db)
    h = responses.samples
    silent = ~h.any(axis=2)
    tenth = max(h.shape[2] // 10, 1)
    whole_tenths = h[:, :, : tenth * (h.shape[2] // tenth)]
    power = np.square(whole_tenths).reshape(*h.shape[:2], -1, tenth).mean(axis=3)  # (n_points, n_channels, n_tenths)
    allowed = max(10 ** (-snr_db / 10), _left_of_decay(h[~silent]))
    noisy = ~silent & (power[:, :, -1] > power.max(axis=2) * allowed)
    clipped = ~silent & (_longest_run_at_peak(h) >= CLIPPED_RUN)
    return Findings(_pairs(clipped), _pairs(silent), _pairs(noisy))


def _pairs(bad: NDArray[np.bool_] | np.bool_) -> tuple[tuple[int, int], ...]:
    return tuple((int(point), int(channel)) for point, channel in np.argwhere(bad))


def _left_of_decay(pairs: FloatArray) -> float:
    """Return the part of its loudest tenth at which a pair may end, or 0."""
    size = pairs.shape[1] // N_BLOCKS if len(pairs) else 0
    if size == 0:
        return 0.0
    energy = np.square(pairs[:, : size * N_BLOCKS]).reshape(len(pairs), N_BLOCKS, size).mean(axis=2)
    share = np.maximum(energy / energy.max(axis=1, keepdims=True), 1e-30)
    decay = decay_of(np.exp(np.log(share).mean(axis=0)))
    if decay.fall_db < LEAST_FALL_DB:
        return 0.0
    return FLUCTUATION * math.exp(
        -1.8 * decay.n_taus
    )  # 0.9 of the record: from the middle of the first tenth to that of the last


@checked
def reciprocity_error(there: Vector, back: Vector) -> float:
    """Return the relative difference of p -> q and q -> p, ideally 0."""
    shape("reciprocity_error.back", back, np.shape(there))
    size = float(np.sqrt(np.mean(np.square(there)) * np.mean(np.square(back))))
    expect(size > 0, "there, back", "zero everywhere", "responses")
    return float(np.sqrt(np.mean(np.square(np.asarray(there) - back)) / size))


def _kind(responses: Responses) -> tuple[float, str, tuple[int, ...]]:
    return responses.rate_hz, responses.quantity, responses.samples.shape[1:]


def _longest_run_at_peak(h: FloatArray) -> IntArray:
    """Return the longest run at each channel's extreme value."""
    at_peak = np.abs(h) >= np.abs(h).max(axis=2, keepdims=True) * (1 - 1e-9)
    run = np.zeros(h.shape[:2], np.int64)
    longest = run.copy()
    for sample in np.moveaxis(at_peak, 2, 0):
        run = np.where(sample, run + 1, 0)
        longest = np.maximum(longest, run)
    return longest


def _read_one(path: Path, full_scale: float, quantity: str) -> Responses:
    suffix = path.suffix.lower()
    if suffix not in _READERS:
        raise InvalidFile(f"{path}: found {path.suffix!r}, expected one of {', '.join(_READERS)}")
    content = read_file(path, "impulse responses")
    try:
        content = as_npz(path, LARGEST_BYTES) if suffix in _HDF5 else content
        responses = _READERS[suffix](content, full_scale, quantity)
        if responses.n_samples == 0:
            raise ValueError("found no samples, expected at least one")
    except ImportError as error:
        raise InvalidFile(
            f"{path}: found no h5py, expected it for an HDF5 file: pip install tactometry[hdf5]"
        ) from error
    except (ValueError, OverflowError, MemoryError) as error:
        words = " ".join(str(error).split())
        raise InvalidFile(f"{path}: cannot be read as impulse responses: {words}") from error
    return responses


def _read_wav(content: bytes, full_scale: float, quantity: str) -> Responses:
    wav = wav_of(content)
    with np.errstate(all="ignore"):  # values that are not numbers raise an error below
        samples = wav.parts() * full_scale
    return Responses(samples.T[None], wav.rate_hz, quantity)


def _read_npz(content: bytes, full_scale: float, quantity: str) -> Responses:
    del full_scale
    file = Npz(content)
    kind = file.words("quantity") if "quantity" in file else quantity
    return Responses(_numbers("samples", file["samples"]), file.number("rate_hz"), kind)


def _numbers(name: str, values: NDArray[Any]) -> FloatArray:
    if values.dtype.kind not in "iuf":
        raise ValueError(f"{name}: found an array of {values.dtype}, expected numbers")
    return values.astype(np.float64, copy=False)


def _read_csv(content: bytes, full_scale: float, quantity: str) -> Responses:
    del full_scale
    file = io.StringIO(content.decode("utf-8-sig"))
    header = _first_line(file.readline())
    names = _header(file.readline())
    columns = table_of_numbers(file, n_columns=len(names))
    kind = header.get("quantity", quantity)
    scale = float(header.get("scale", "1")) * (_unit_scale(header["unit"], kind) if "unit" in header else 1.0)
    return Responses(columns.T[None] * scale, float(header["rate_hz"]), kind)


def _first_line(line: str) -> dict[str, str]:
    """Parse the first line of a CSV file into its keys and values."""
    words = [word.partition("=")[::2] for word in line.lstrip("#").split()]
    header = dict(words)
    for word in header:
        one_of("first line", word, _CSV_WORDS)
    if len(header) < len(words):
        raise ValueError(f"first line: found {line.strip()!r}, expected each key once")
    if "rate_hz" not in header:
        raise ValueError("'rate_hz' is not in the first line, expected '# rate_hz=100000' for instance")
    return header


def _header(line: str) -> list[str]:
    """Return the names in the second line. Raises if they are numbers."""
    names = line.split(",")
    if all(_is_number(cell) for cell in names):
        raise ValueError(f"line 2: found {line.strip()!r}, expected a header row with one name per transducer")
    return names


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _unit_scale(unit: str, quantity: str) -> float:
    """Return the factor from `unit` to SI units."""
    si = _UNITS.get(quantity, "")
    one_of("unit", unit, [prefix + si for prefix in _PREFIXES])
    return _PREFIXES[unit.removesuffix(si)]


_HDF5: Final = (".h5", ".hdf5")
_READERS: Final[Mapping[str, Callable[[bytes, float, str], Responses]]] = {
    ".wav": _read_wav,
    ".npz": _read_npz,
    ".h5": _read_npz,
    ".hdf5": _read_npz,
    ".csv": _read_csv,
}
