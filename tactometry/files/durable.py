"""Reading within limits, and complete writing of private files."""

import fnmatch
import os
import re
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO, Final

from ..errors import DeviceFailed, InvalidFile, attempt

LARGEST_BYTES: Final = 2**30
"""Largest size of a file that is read at once, bytes (unverified default)."""
PRIVATE_FILE, PRIVATE_FOLDER = 0o600, 0o700
"""Modes of new files and folders, readable only by their owner. Existing files keep their modes."""
NO_LINK: Final = getattr(os, "O_NOFOLLOW", 0)
"""Flag of `open_private` that refuses links."""
_BINARY, _NOT_WAITING = getattr(os, "O_BINARY", 0), getattr(os, "O_NONBLOCK", 0)
_DRAFT = re.compile(r"\..+\.\d+")


@contextmanager
def private() -> Iterator[None]:
    """Create all files of the process for their owner only during the body."""
    before = os.umask(0o777 & ~PRIVATE_FOLDER)
    try:
        yield
    finally:
        os.umask(before)


def read_file(path: Path, what: str, largest: int = LARGEST_BYTES) -> bytes:
    """Return the bytes of a file. `what` describes the expected file.

    It does not wait for pipes.

    Raises `InvalidFile` if the file is missing, unreadable, not a regular file, or larger than `largest` bytes.
    """
    with _opened(path, what) as file:
        size = os.fstat(file.fileno()).st_size
        if size > largest:
            raise InvalidFile(f"{path}: found {size} bytes, expected {what} of at most {largest}")
        return file.read()


def whole_lines(content: bytes, beginning: bytes = b"") -> Iterator[bytes]:
    """Yield the complete lines with this beginning, one at a time.

    >>> list(whole_lines(b"a\\n\\nb")), list(whole_lines(b"a1\\nb\\na2\\na3", b"a"))
    ([b'a', b''], [b'a1', b'a2'])
    """
    start = 0
    if not content.startswith(beginning):
        start = content.find(b"\n" + beginning) + 1 or len(content)
    while (end := content.find(b"\n", start)) >= 0:
        yield content[start:end]
        start = content.find(b"\n" + beginning, end) + 1 or len(content)


def read_bytes(path: Path, what: str, first_byte: int, n_bytes: int) -> bytes:
    """Return at most `n_bytes` of a file. Raises like `read_file`."""
    with _opened(path, what) as file:
        file.seek(first_byte)
        return file.read(n_bytes)


@contextmanager
def _opened(path: Path, what: str) -> Iterator[BinaryIO]:
    try:
        file = os.open(path, os.O_RDONLY | _NOT_WAITING | _BINARY)
        _refuse_others(file, path, what)
        with os.fdopen(file, "rb") as opened:
            yield opened
    except OSError as failure:
        raise InvalidFile(f"{path}: cannot be read ({failure.strerror}), expected {what}") from None


def files_in(folder: Path, pattern: str = "*") -> list[Path]:
    """Return the visible files of a folder with this pattern, or none, sorted."""
    try:
        names = os.listdir(folder)  # noqa: PTH208 - a glob ignores unreadable folders
    except (FileNotFoundError, NotADirectoryError):
        return []
    except OSError as failure:
        raise InvalidFile(f"{folder}: cannot be read ({failure.strerror}), expected a readable folder") from None
    return sorted(folder / name for name in fnmatch.filter(names, pattern) if not name.startswith("."))


def open_private(path: Path, flags: int) -> int:
    """Open a file for writing, and create it for its owner only.

    Raises `DeviceFailed` if it cannot be opened. Raises `InvalidFile` if it is not a file, or if it is a link and
    the flags contain `NO_LINK`.
    """
    if flags & NO_LINK and path.is_symlink():
        raise InvalidFile(f"{path}: found a link, expected a file; replace the link by its target")
    with attempt(path, "cannot open", "a writable folder"):
        file = os.open(path, flags | os.O_CREAT | _NOT_WAITING | _BINARY, PRIVATE_FILE)
    _refuse_others(file, path, "a writable file")
    return file


def _refuse_others(file: int, path: Path, what: str) -> None:
    mode = os.fstat(file).st_mode
    if not stat.S_ISREG(mode):
        os.close(file)
        kind = "a folder" if stat.S_ISDIR(mode) else "a pipe or a device"
        raise InvalidFile(f"{path}: found {kind}, expected {what}")


def make_folder(path: Path) -> None:
    """Create a folder and its parents for their owner only.

    Raises `InvalidFile` if there is a file with this name, `DeviceFailed` if the folder cannot be created.
    """
    for folder in (*reversed(path.parents), path):
        try:
            folder.mkdir(mode=PRIVATE_FOLDER, exist_ok=True)
        except (FileExistsError, NotADirectoryError):
            expected = "a folder for the data set; choose another --out"
            raise InvalidFile(f"{folder}: found a file, expected {expected}") from None
        except OSError as error:
            if os.path.isdir(folder):  # noqa: PTH112 - Path.is_dir fails where a name is too long
                continue
            failure = f"cannot create the folder ({error.strerror})"
            raise DeviceFailed(f"{path}: {failure}, expected disk space and permission") from None


def write_whole(file: int, line: bytes, path: Path, *, durable: bool) -> None:
    """Append all of `line` to the file, or nothing.

    Raises `DeviceFailed` if the disk is full or fails. The file then ends with its last complete line.
    """
    start = os.lseek(file, 0, os.SEEK_CUR)
    try:
        n_written = 0
        while n_written < len(line):
            n_written += os.write(file, line[n_written:])
        if durable:
            os.fsync(file)
    except OSError as error:
        os.ftruncate(file, start)
        os.lseek(file, start, os.SEEK_SET)
        raise DeviceFailed(
            f"{path}: cannot write ({error.strerror}), expected free disk space; all earlier trials are safe; free "
            "some space, then continue with --resume"
        ) from None


def drafts(folder: Path, name: str = "*") -> list[Path]:
    """Return the drafts that killed processes left in a folder, sorted."""
    return sorted(path for path in folder.glob(f".{name}.*") if _DRAFT.fullmatch(path.name))


@contextmanager
def draft(path: Path, content: bytes) -> Iterator[tuple[int, Path]]:
    """Write a draft of a file, yield it open, and remove it at the end.

    The draft is in the same folder and has the same mode.

    Raises `DeviceFailed` if the disk is full or fails. The file itself is unchanged.
    """
    drafted = path.with_name(f".{path.name}.{os.getpid()}")
    with suppress(OSError):
        drafted.unlink()  # left by a killed process with the same number
    file = open_private(drafted, os.O_RDWR | os.O_EXCL)
    try:
        if path.exists() and hasattr(os, "fchmod"):
            os.fchmod(file, stat.S_IMODE(path.stat().st_mode))
        write_whole(file, content, path, durable=True)
        yield file, drafted
    except BaseException:
        os.close(file)
        raise
    finally:
        drafted.unlink(missing_ok=True)


def put_in_place(drafted: Path, path: Path) -> None:
    """Replace a file by its draft, atomically."""
    with attempt(path, "cannot write", "free disk space; free some space and try again"):
        drafted.replace(path)
        sync_folder(path.parent)


def replace_file(path: Path, content: bytes) -> int:
    """Replace a file atomically and return it open at its end.

    Raises `DeviceFailed` if the disk is full or fails. The old file is then unchanged.
    """
    with draft(path, content) as (file, drafted):
        put_in_place(drafted, path)
    return file


def write_atomically(path: Path, content: bytes) -> None:
    os.close(replace_file(path, content))


def write_first(path: Path, content: bytes) -> None:
    """Create a file unless it exists, even if other processes do so too."""
    if path.exists():
        return
    with draft(path, content) as (file, drafted):
        try:
            os.link(drafted, path)
        except FileExistsError:
            pass
        except OSError:
            _copy_first(path, content)
        sync_folder(path.parent)
    os.close(file)


def _copy_first(path: Path, content: bytes) -> None:
    """Create a file on a disk that does not support links."""
    with attempt(path, "cannot write", "room and permission"), suppress(FileExistsError):
        file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | _BINARY, PRIVATE_FILE)
        try:
            write_whole(file, content, path, durable=True)
        finally:
            os.close(file)


def sync_folder(path: Path) -> None:
    """Sync the names in a folder, if the system supports it."""
    if os.name == "posix":
        folder = os.open(path, os.O_RDONLY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)
