"""Errors by cause, and their messages."""

import difflib
import re
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Final, TypeVar, cast

T = TypeVar("T")

LONGEST_WORD: Final = 300
"""Length above which values are shortened in messages to their two ends."""
LONGEST_SENTENCE: Final = 4000
SIGNALLED: Final = 128
"""Exit status of a process that a signal ended: this value plus the signal's number."""
_LONG_WORD = re.compile(rf"\S{{{LONGEST_WORD},}}")


def shorten(text: str, longest: int) -> str:
    """Remove the middle of a long text.

    >>> shorten("a" * 40, 10)
    'aaaaa... (30 letters) ...aaaaa'
    """
    end = longest // 2
    return text if len(text) <= longest else f"{text[:end]}... ({len(text) - 2 * end} letters) ...{text[-end:]}"


class TactometryError(Exception):
    """Error that a user can fix, with the exit status of the command."""

    exit_status = 2

    def __str__(self) -> str:
        words = _LONG_WORD.sub(lambda word: shorten(word[0], LONGEST_WORD // 2), super().__str__())
        return shorten(words, LONGEST_SENTENCE)


class InvalidParameter(TactometryError, ValueError):  # noqa: N818
    """Unusable argument, key of a file, or cell of a table."""


class InvalidFile(TactometryError):  # noqa: N818
    """Study file, data set or journal with invalid content."""


class Mistakes(InvalidFile, InvalidParameter):
    """Several errors in one file, each a separate error in `parts`."""

    def __init__(self, parts: Iterable[TactometryError]) -> None:
        self.parts = tuple(parts)
        super().__init__("; ".join(map(str, self.parts)))


def each_of(error: TactometryError) -> tuple[TactometryError, ...]:
    """Return the separate errors contained in an error."""
    return error.parts if isinstance(error, Mistakes) else (error,)


class Gathered:
    """Collector of the errors in a file, which are raised together.

    >>> result = Gathered()
    >>> for key in ("a", "b"):
    ...     with result.part():
    ...         raise InvalidParameter(f"{key}: found no such key")
    >>> result.end()
    Traceback (most recent call last):
    tactometry.errors.Mistakes: a: found no such key; b: found no such key
    """

    def __init__(self) -> None:
        self.errors: list[TactometryError] = []
        self._places: set[str] = set()

    @contextmanager
    def part(self) -> Iterator[None]:
        """Collect the errors of the body."""
        try:
            yield
        except (InvalidParameter, InvalidFile) as error:
            self.add(error)

    def made(self, make: Callable[[], T]) -> T:
        """Return the result of `make`, or collect its errors for `end`."""
        try:
            return make()
        except (InvalidParameter, InvalidFile) as error:
            self.add(error)
            return cast("T", None)

    def add(self, error: TactometryError) -> None:
        """Collect the errors contained in an error, the first at each place."""
        for part in each_of(error):
            place = str(part).partition(": found ")[0].removeprefix(": ")
            if place not in self._places:
                self._places.add(place)
                self.errors.append(part)

    def end(self) -> None:
        """Raise the collected errors: a single one, or `Mistakes`."""
        if self.errors:
            raise self.errors[0] if len(self.errors) == 1 else Mistakes(self.errors)


def reworded(error: TactometryError, kind: type[TactometryError], tell: Callable[[str], str]) -> TactometryError:
    """Return an error of class `kind` with each message converted by `tell`."""
    parts: list[TactometryError] = []
    for part in each_of(error):
        copy = kind(tell(str(part)))
        copy.__context__ = part
        parts.append(copy)
    return parts[0] if len(parts) == 1 else Mistakes(parts)


class LimitExceeded(TactometryError):  # noqa: N818
    """Signal that must not reach a finger."""

    exit_status = 3


class DeviceFailed(TactometryError):  # noqa: N818
    """Failure of a display, output, sensor or disk."""

    exit_status = 3


class SessionInUse(TactometryError):  # noqa: N818
    """Another process writes this session, or erases from this data set."""


class Diverged(TactometryError):  # noqa: N818
    """Replayed session that differs from its recording."""

    exit_status = 1


class Stopped(TactometryError):  # noqa: N818
    """End of a session by participant or experimenter, without data loss."""

    exit_status = 1


class Terminated(SystemExit):
    """End of the process by a signal. The code is 128 plus its number."""


def ended_by_signal(error: BaseException) -> bool:
    """Return True if a signal ends the process.

    >>> ended_by_signal(SystemExit(143)), ended_by_signal(SystemExit(0))
    (True, False)
    """
    return isinstance(error, SystemExit) and isinstance(error.code, int) and error.code > SIGNALLED


@contextmanager
def library_needed(refusal: str) -> Iterator[None]:
    """Raise `DeviceFailed` if the body cannot import a library.

    The message is `refusal`, in which ``{error}`` is replaced by the reason.

    >>> with library_needed("lamp: found no lamps ({error}); pip install 'tactometry[lamp]'"):
    ...     import lamps
    Traceback (most recent call last):
    tactometry.errors.DeviceFailed: lamp: found no lamps (No module named 'lamps'); pip install 'tactometry[lamp]'
    """
    try:
        yield
    except (ImportError, OSError, RuntimeError) as error:
        raise DeviceFailed(refusal.format(error=error)) from None


@contextmanager
def attempt(
    where: object, act: str, expected: str, errors: type[Exception] | tuple[type[Exception], ...] = OSError
) -> Iterator[None]:
    """Raise `DeviceFailed` with the reason if the body raises `errors`.

    >>> with attempt("/nowhere/f", "cannot write", "a place to write to"):
    ...     open("/nowhere/f", "xb")
    Traceback (most recent call last):
    tactometry.errors.DeviceFailed: /nowhere/f: cannot write (No such file or directory), expected a place to write to
    """
    try:
        yield
    except errors as error:
        raise DeviceFailed(f"{where}: {act} ({reason(error)}), expected {expected}") from None


def reason(error: BaseException) -> str:
    """Return the message of an error on one line.

    >>> reason(ValueError("no such   rate")), reason(OSError(2, "No such file or directory", "f"))
    ('no such rate', 'No such file or directory')
    """
    return getattr(error, "strerror", None) or " ".join(str(error).split())


@contextmanager
def rewording(tell: Callable[[str], str]) -> Iterator[None]:
    """Raise user errors of the body as `InvalidParameter`, reworded by `tell`.

    >>> with rewording(lambda words: f"procedure.{words}"):
    ...     raise LimitExceeded("level: found 90, expected at most 40")
    Traceback (most recent call last):
    tactometry.errors.InvalidParameter: procedure.level: found 90, expected at most 40
    """
    try:
        yield
    except TactometryError as error:
        raise reworded(error, InvalidParameter, tell) from None


def nearest(found: str, names: Iterable[str], n: int = 1) -> str:
    """Return a hint with at most `n` names similar to a mistyped name.

    >>> nearest("procedur", ["procedure", "task"])
    "; did you mean 'procedure'?"
    >>> nearest("hint_fil", ["hint_fill", "hint_end", "agree", "hint_fill_line"], 2)
    "; did you mean 'hint_fill' or 'hint_fill_line'?"
    >>> nearest("zzz", ["procedure", "task"])
    ''
    """
    known = list(names)
    other_case = [name for name in known if name.casefold() == found.casefold()]
    close = other_case[:n] or difflib.get_close_matches(found[:LONGEST_WORD], known, n=n)
    return f"; did you mean {' or '.join(map(repr, close))}?" if close else ""


def nearest_of(found: str, names: Iterable[str]) -> str:
    """Return the most similar name, or an empty text.

    >>> nearest_of("procedur", ["procedure", "task"])
    'procedure'
    """
    return next(iter(difflib.get_close_matches(found[:LONGEST_WORD], list(names), n=1)), "")


def count_of(n: int, noun: str) -> str:
    """Return a number with its noun.

    >>> count_of(1, "trial"), count_of(2, "trial")
    ('1 trial', '2 trials')
    """
    return f"{n} {noun}" if n == 1 else f"{n} {noun}s"
