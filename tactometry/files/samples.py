"""Reading of samples from complete WAV and NPZ files of limited size.

A damaged file raises a `ValueError` that states what was found and what was expected.
"""

import io
import struct
import warnings
import zipfile
import zlib
from typing import Any, Final, NamedTuple, TextIO

import numpy as np
from numpy.typing import NDArray

from .durable import LARGEST_BYTES

LARGEST_WORDS: Final = 2**20
"""Largest text stored with the samples, bytes."""
_CHUNK: Final = struct.Struct("<4sI")
_FORMAT: Final = struct.Struct("<HHIIHH")
_WAV_DAMAGES: Final = (
    *(ValueError, TypeError, struct.error, EOFError, OverflowError, ZeroDivisionError, UnboundLocalError, MemoryError),
)
"""Errors that scipy raises for damaged bytes."""
_ENDLESS: Final = 2**32 - 1
_read_array: Final[Any] = np.lib.format.read_array


class Wav(NamedTuple):
    """Frames (n_frames, n_channels) as stored in the file, and their rate."""

    rate_hz: float
    frames: NDArray[Any]

    def parts(self) -> NDArray[np.float64]:
        """Convert frames to fractions of full scale.

        24-bit samples are stored in the upper 24 of 32 bits.

        >>> Wav(48_000.0, np.array([[0, 255]], np.uint8)).parts().tolist()
        [[-1.0, 0.9921875]]
        """
        kind = self.frames.dtype
        with np.errstate(invalid="ignore"):  # a damaged file may contain signalling NaN
            frames = self.frames.astype(np.float64)
        if kind.kind == "f":
            return frames
        return frames / 2.0 ** (8 * kind.itemsize - 1) - (1.0 if kind.kind == "u" else 0.0)


def wav_of(content: bytes) -> Wav:
    """Read a WAV file.

    Raises `ValueError` if it is not a WAV file, is incomplete, or has no samples.
    """
    from scipy.io import wavfile

    _check_wav(content)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # warnings about chunks other than samples
            rate, frames = wavfile.read(io.BytesIO(content))
    except _WAV_DAMAGES as error:
        words = " ".join(str(error).split())
        raise ValueError(f"found a damaged WAV file ({words}), expected a valid file") from None
    return Wav(float(rate), np.reshape(frames, (len(frames), -1)))


def _check_wav(content: bytes) -> None:
    """Raise `ValueError` if a file is not a complete WAV file."""
    if len(content) < 12 or content[:4] not in (b"RIFF", b"RF64") or content[8:12] != b"WAVE":
        raise ValueError("found no WAV file, expected a file that begins with RIFF and WAVE")
    frame_bytes, long_bytes, at = 0, 0, 12
    while at + _CHUNK.size <= len(content):
        name, size = _CHUNK.unpack_from(content, at)
        at += _CHUNK.size
        if name == b"ds64" and at + 16 <= len(content):
            long_bytes = int.from_bytes(content[at + 8 : at + 16], "little")
        if name == b"fmt ":
            frame_bytes = _frame_bytes(content[at : at + size])
        if name == b"data":
            n_there = len(content) - at
            n_said = long_bytes or size if size == _ENDLESS else size
            if not frame_bytes:
                raise ValueError("found samples before their format, expected a chunk 'fmt ' first")
            if n_said == 0:
                raise ValueError("found no samples, expected at least one sample")
            if n_said > n_there:
                raise ValueError(f"found {n_there} of {n_said} bytes of samples, expected all: the file is incomplete")
            if n_said % frame_bytes:
                raise ValueError(f"found {n_said} bytes of samples, expected whole frames of {frame_bytes} bytes")
            return
        at += size + size % 2
    raise ValueError("found no samples, expected a chunk 'data': the file is incomplete")


def _frame_bytes(form: bytes) -> int:
    if len(form) < _FORMAT.size:
        raise ValueError("found no complete chunk 'fmt ', expected a complete one: the file is incomplete")
    _, n_channels, rate_hz, _, frame_bytes, n_bits = _FORMAT.unpack_from(form)
    if not n_channels or not rate_hz or not n_bits or frame_bytes != n_channels * -(-n_bits // 8):
        raise ValueError(
            f"found {n_channels} channels of {n_bits} bits at {rate_hz} Hz in frames of {frame_bytes} bytes, expected "
            "consistent numbers"
        )
    return int(frame_bytes)


def table_of_numbers(lines: TextIO, n_columns: int | None = None) -> NDArray[np.float64]:
    """Parse rows (n_rows, n_columns) of comma-separated numbers.

    Raises `ValueError` if there are no rows, or not `n_columns` columns.

    >>> table_of_numbers(io.StringIO("1,2\\n3,4"), n_columns=2).tolist()
    [[1.0, 2.0], [3.0, 4.0]]
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # warning about missing rows, which are refused below
        try:
            table = np.asarray(np.loadtxt(lines, delimiter=",", ndmin=2), dtype=np.float64)
        except ValueError as error:  # numpy adds advice for programmers after the fault
            raise ValueError(str(error).split(";")[0].rstrip(".")) from None
    if table.size == 0:
        raise ValueError("found no rows of numbers, expected at least one row")
    if n_columns is not None and table.shape[1] != n_columns:
        raise ValueError(f"found {table.shape[1]} columns of numbers for {n_columns} names, expected equal numbers")
    return table


class Npz:
    """Arrays of an NPZ file by name, each read on demand.

    >>> file = io.BytesIO()
    >>> np.savez(file, samples=np.arange(3.0))
    >>> Npz(file.getvalue())["samples"].tolist(), "rate_hz" in Npz(file.getvalue())
    ([0.0, 1.0, 2.0], False)
    """

    def __init__(self, content: bytes) -> None:
        try:
            self._archive = zipfile.ZipFile(io.BytesIO(content))
            self._names = set(self._archive.namelist())
        except _DAMAGES as error:
            raise ValueError(f"found no complete NPZ archive ({error}), expected an archive of numpy.savez") from None

    def __contains__(self, name: str) -> bool:
        return f"{name}.npy" in self._names

    def __getitem__(self, name: str) -> NDArray[Any]:
        return self._array(name, LARGEST_BYTES)

    def words(self, name: str) -> str:
        """Return a text. Raises `ValueError` if the array is not one text."""
        return str(self._single(name, "U", "text"))

    def number(self, name: str) -> float:
        """Return a number. Raises `ValueError` if the array is not one number."""
        return float(self._single(name, "iuf", "number"))

    def _single(self, name: str, kinds: str, what: str) -> NDArray[Any]:
        array = self._array(name, LARGEST_WORDS)
        if array.ndim or array.dtype.kind not in kinds:
            raise ValueError(f"{name}: found an array of shape {array.shape}, expected a single {what}")
        return array

    def _array(self, name: str, largest: int) -> NDArray[Any]:
        if name not in self:
            raise ValueError(f"{name}: found no array with this name, expected one")
        size = self._archive.getinfo(f"{name}.npy").file_size
        if size > largest:
            raise ValueError(f"{name}: found {size} bytes, expected at most {largest}")
        try:
            with self._archive.open(f"{name}.npy") as member:
                array = _read_array(io.BytesIO(member.read(size)), allow_pickle=False)
        except _DAMAGES as error:
            raise ValueError(f"{name}: found a damaged array ({error}), expected a valid array") from None
        return np.asarray(array)


_DAMAGES: Final = (
    *(OSError, EOFError, ValueError, KeyError, TypeError, RuntimeError, NotImplementedError, OverflowError),
    *(SyntaxError, MemoryError, RecursionError, struct.error, zipfile.BadZipFile, zlib.error),
)
"""Errors that numpy and zipfile raise for damaged bytes."""
