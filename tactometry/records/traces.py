"""Traces: sensor samples of each touch, and signals that followed a finger.

A session has a BIDS-like file for each kind of samples, with rows of text without a header, and a JSON file that
explains the columns. Each touch adds a gzip member. The journal states its file, position, length and digest with
the answer. A member that the journal does not mention belongs to an interrupted trial.
"""

import os
import zlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from ..errors import InvalidFile
from ..files.durable import (
    LARGEST_BYTES,
    make_folder,
    open_private,
    read_bytes,
    read_file,
    sync_folder,
    write_first,
    write_whole,
)
from ..files.json_file import json_object
from ..provenance import digest_of
from ..session.answer import TracePart
from ..session.event import TraceKind
from ..signal import FloatArray
from ..trials.columns import Column
from .data_set import TRACES, Session
from .description import pretty

FOLDER: Final = TRACES
MISSING: Final = "n/a"
"""Lost sample in BIDS notation."""
FILES: Final[Mapping[TraceKind, str]] = {
    "force": "recording-force_physio",
    "position": "tracksys-finger_motion",
    "emitted": "recording-output_stim",
}
"""Suffix of the file name of each kind, after the name of the session."""
_FORMS: Final[Mapping[TraceKind, tuple[str, str]]] = {
    "force": ("%.6f", "%.6g"),
    "position": ("%.6f", "%.9f"),
    "emitted": ("%.7g", "%.7g"),
}
"""Number formats of the first column and of the other columns: microseconds, nanometres, and voltages with the
resolution of a 24-bit card."""
HIGHEST_RATE_HZ: Final = 1e9
_LEVEL: Final = 4
"""Compression level."""
_GZIP: Final = zlib.MAX_WBITS + 16
_PIECE: Final = 2**16
_AXES: Final = "xyz"


def columns_of(kind: TraceKind, n_columns: int) -> tuple[Column, ...]:
    """Return the columns of a file of traces."""
    stamp = Column("time_s", "Stamp of the sample since the start of the session", "s")
    if kind == "emitted":
        return tuple(Column(f"channel_{n}", "What was emitted", "V") for n in range(1, n_columns + 1))
    if kind == "force":
        return stamp, Column("force_n", "Applied force", "N")
    axes = (Column(f"{axis}_m", f"Place of the finger on axis {axis} of its sensor", "m") for axis in _AXES)
    return stamp, *tuple(axes)[: n_columns - 1]


def encode_rows(kind: TraceKind, table: FloatArray) -> bytes:
    """Format rows (n_rows, n_columns). A lost sample is n/a.

    >>> encode_rows("force", np.array([[0.001, 1.0], [0.002, np.nan]]))
    b'0.001000\\t1\\n0.002000\\tn/a\\n'
    """
    first, rest = _FORMS[kind]
    row = "\t".join([first, *[rest] * (table.shape[1] - 1)]) + "\n"
    text = (row * len(table)) % tuple(table.ravel().tolist())
    return (text if np.isfinite(table).all() else text.replace("nan", MISSING)).encode()


def decode_rows(text: bytes) -> FloatArray:
    """Parse rows (n_rows, n_columns). A lost sample is NaN.

    Raises `ValueError` if the text is not a table of numbers.
    """
    n_columns = text[: text.find(b"\n")].count(b"\t") + 1
    numbers = text.replace(MISSING.encode(), b"nan").split()
    return np.array(list(map(float, numbers))).reshape(-1, n_columns)


def packed(text: bytes) -> bytes:
    """Compress a text as a gzip member without time and name."""
    packer = zlib.compressobj(_LEVEL, zlib.DEFLATED, _GZIP)
    return packer.compress(text) + packer.flush()


def whole_length(content: bytes) -> int:
    """Return the length without an incomplete last gzip member."""
    at = n_whole = 0
    unpacker = zlib.decompressobj(_GZIP)
    while at < len(content):
        piece = content[at : at + _PIECE]
        try:
            unpacker.decompress(piece)
        except zlib.error:  # damage within the file: keep the rest, as later parts are found by their offsets
            return len(content)
        at += len(piece) - len(unpacker.unused_data)
        if unpacker.eof:
            n_whole, unpacker = at, zlib.decompressobj(_GZIP)
    return n_whole


def read_text(root: Path, part: TracePart) -> bytes:
    """Read the rows of a part in the data set at `root` as text.

    Raises `InvalidFile` if the file is missing, or its content differs from what was stored.
    """
    held = _held(root, part)
    flaw = _flaw(held, part)
    if flaw is not None:
        raise InvalidFile(f"{root / part.file}: {flaw}")
    return zlib.decompressobj(_GZIP).decompress(held, LARGEST_BYTES)


def read_part(root: Path, part: TracePart) -> FloatArray:
    """Read the rows (n_rows, n_columns) of a part. Raises like `read_text`."""
    return decode_rows(read_text(root, part))


def part_flaw(root: Path, part: TracePart) -> str | None:
    """Describe what is wrong with a part, or return None."""
    return _flaw(_held(root, part), part)


def _held(root: Path, part: TracePart) -> bytes:
    return read_bytes(root / part.file, "traces", part.first_byte, part.n_bytes)


def _flaw(held: bytes, part: TracePart) -> str | None:
    if digest_of(held) == part.digest:
        return None
    found = "other samples than were stored" if len(held) == part.n_bytes else f"its end within the next {part.n_bytes}"
    return f"found {found} from byte {part.first_byte} on, expected complete samples; restore a copy"


def kind_of(part: TracePart) -> TraceKind | None:
    """Return the kind of samples in a part, or None if it is unknown."""
    return next((kind for kind, name in FILES.items() if part.file.endswith(f"_{name}.tsv.gz")), None)


class TraceFiles:
    """Trace files of a session, in the data set at `root`.

    An incomplete last member is removed first.
    """

    def __init__(self, root: Path, session: Session) -> None:
        self._root, self._session = root, session
        self._files: dict[TraceKind, int] = {}
        self._unsynced: set[TraceKind] = set()

    def keep(self, kind: TraceKind, table: FloatArray, rate_hz: float) -> TracePart:
        """Append rows (n_rows, n_columns) and return their place.

        Raises `DeviceFailed` if the disk is full or fails. Nothing is added then.
        """
        path = trace_file(self._root, self._session, kind)
        if kind not in self._files:
            self._files[kind] = self._opened(kind, path, table.shape[1], rate_hz)
        file, member = self._files[kind], packed(encode_rows(kind, table))
        first_byte = os.lseek(file, 0, os.SEEK_END)
        write_whole(file, member, path, durable=False)
        self._unsynced.add(kind)
        name = path.relative_to(self._root).as_posix()
        return TracePart(name, first_byte, len(member), digest_of(member), rate_hz if kind == "emitted" else None)

    def _opened(self, kind: TraceKind, path: Path, n_columns: int, rate_hz: float) -> int:
        make_folder(path.parent)
        write_first(sidecar_of(path), sidecar(columns_of(kind, n_columns), rate_hz))
        file = open_private(path, os.O_RDWR)
        content = read_file(path, "traces")
        n_whole = whole_length(content)
        if n_whole < len(content):
            os.ftruncate(file, n_whole)
        sync_folder(path.parent)
        return file

    def sync(self) -> None:
        """Sync the added rows before the journal refers to them."""
        while self._unsynced:
            os.fsync(self._files[self._unsynced.pop()])

    def close(self) -> None:
        self.sync()
        while self._files:
            os.close(self._files.popitem()[1])


def trace_file(root: Path, session: Session, kind: TraceKind) -> Path:
    return root / FOLDER / f"{session.stem}_{FILES[kind]}.tsv.gz"


def sidecar_of(path: Path) -> Path:
    return path.with_name(path.name.removesuffix(".tsv.gz") + ".json")


@dataclass(frozen=True)
class TraceDescription:
    """Sampling rate and columns of a file of traces."""

    rate_hz: float
    columns: tuple[Column, ...]

    @property
    def names(self) -> list[str]:
        return [column.name for column in self.columns]


def read_sidecar(path: Path) -> TraceDescription:
    """Read the JSON file that explains a file of traces.

    Raises `InvalidFile` if the sampling rate or the columns are missing.
    """
    content = json_object(path, "the sampling rate and the columns of its samples")
    rate_hz: Any = content.get("SamplingFrequency")
    names: Any = content.get("Columns")
    if type(rate_hz) not in (int, float) or not 0 < rate_hz <= HIGHEST_RATE_HZ:
        above = f"a number of Hz above 0 and at most {HIGHEST_RATE_HZ:g}"
        raise InvalidFile(f"{path}: SamplingFrequency: found {rate_hz!r:.60}, expected {above}")
    are_texts = isinstance(names, list) and bool(names) and all(isinstance(name, str) and name for name in names)
    if not are_texts or len(set(names)) != len(names):
        raise InvalidFile(f"{path}: Columns: found {names!r:.60}, expected a list of distinct names")
    return TraceDescription(float(rate_hz), tuple(_explained(path, name, content.get(name)) for name in names))


def _explained(path: Path, name: str, said: object) -> Column:
    texts = [said.get(key) for key in ("Description", "Units")] if isinstance(said, Mapping) else [None]
    if not all(isinstance(text, str) for text in texts):
        expected = "an object with the texts Description and Units"
        raise InvalidFile(f"{path}: {name!r:.60}: found {said!r:.60}, expected {expected}")
    return Column(name, *map(str, texts))


def sidecar(columns: Iterable[Column], rate_hz: float) -> bytes:
    """Encode sampling rate and columns of a file of traces as BIDS does."""
    named = {column.name: {"Description": column.description, "Units": column.unit} for column in columns}
    return pretty({"SamplingFrequency": rate_hz, "StartTime": 0, "Columns": list(named), **named})
