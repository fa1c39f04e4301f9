"""What libraries write to the terminal, past Python: heard, and told as lines of their own."""

import os
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager

from .terminal import available


@contextmanager
def heard(files: Sequence[int], tell: Callable[[str], None]) -> Iterator[None]:
    """In the body each line that is written to these files (numbers, as 2 for errors) is told instead; what was
    written last too, without an end of its line."""
    with ExitStack() as last_first:
        for file in files:
            last_first.enter_context(_heard(file, tell))
        yield


@contextmanager
def _heard(file: int, tell: Callable[[str], None]) -> Iterator[None]:
    before, (source, sink) = os.dup(file), os.pipe()
    listener = threading.Thread(target=_listen, args=(source, tell), name=f"messages {file}", daemon=True)
    os.dup2(sink, file)
    os.close(sink)
    listener.start()
    try:
        yield
    finally:
        os.dup2(before, file)  # the last end of the pipe to write to, so that the listener comes to its end
        os.close(before)
        listener.join(1.0)
        os.close(source)


def _listen(source: int, tell: Callable[[str], None]) -> None:
    rest = b""
    while data := available(source):
        *lines, rest = (rest + data).split(b"\n")
        for line in lines:
            _tell(line, tell)
    _tell(rest, tell)


def _tell(line: bytes, tell: Callable[[str], None]) -> None:
    words = "".join(letter for letter in line.decode("utf-8", "replace") if letter.isprintable() or letter == "\t")
    if words.strip():
        tell(words.rstrip())
