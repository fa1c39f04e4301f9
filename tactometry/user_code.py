"""User code next to a study: allowed imports and guarded calls.

An exception, or an invalid answer, is reported in one sentence with file and line.
"""

import functools
import sys
import traceback
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, is_dataclass
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType
from typing import Any, Final

from .arguments.require import expect
from .errors import InvalidParameter, TactometryError, Terminated, reason, shorten
from .provenance import sha256

REMEDY: Final = "correct the code; recorded data are safe: continue with --resume"
MARK: Final = "_is_guarded"


@dataclass(frozen=True)
class Expected:
    """Valid answers of a method: description, test and conversion."""

    words: str
    fits: Callable[[Any, tuple[Any, ...]], bool]
    plain: Callable[[Any], Any]


def is_own(kind: object) -> bool:
    """Return True if a kind names a class of the user.

    >>> is_own("mine:Careful"), is_own("sine")
    (True, False)
    """
    return isinstance(kind, str) and ":" in kind


def not_allowed(where: str, target: str, what: str) -> InvalidParameter:
    """Return the error for code that may not run."""
    return InvalidParameter(
        f"{where}: found {target!r}, {what} whose code would run, expected --allow-code on the command line; use it "
        "only for code that you trust"
    )


def class_beside(target: str, folder: Path, where: str) -> type:
    """Return the dataclass ``module:Class`` of a file in `folder`.

    Raises `InvalidParameter`, with `where` at the beginning of the message, if the file or class is missing or its
    import fails.
    """
    module, _, name = target.partition(":")
    file = folder.joinpath(*module.split(".")).with_suffix(".py")
    parts = [*module.split("."), name]
    plain = f"{module.removesuffix('.py')}:{name or 'Class'}"
    expect(not module.endswith(".py"), where, repr(target), f"the module without '.py': {plain!r}")
    expect(all(map(str.isidentifier, parts)), where, repr(target), "module:Class, such as 'mine:Careful'")
    expect(file.is_file(), where, f"{target!r}, but no file {file.name} in {folder}", "the file next to the study file")
    kind = getattr(_module(file, where), name, None)
    if not (isinstance(kind, type) and is_dataclass(kind)):
        raise InvalidParameter(
            f"{where}: found no dataclass {name!r} in {file.name}, expected a dataclass with "
            "the keys of the table as fields"
        )
    return kind


def state_of(folder: Path) -> str:
    return sha256(b"".join(str(file).encode() + file.read_bytes() for file in sorted(folder.glob("*.py"))))


def _module(file: Path, where: str) -> ModuleType:
    """Import a file under a name unique to the file and its folder's state."""
    name = f"tactometry_own_{state_of(file.parent)[:12]}_{file.stem}"
    if name in sys.modules:
        return sys.modules[name]
    spec = spec_from_file_location(name, file)
    assert spec is not None  # every .py file has a loader
    assert spec.loader is not None
    made = module_from_spec(spec)
    sys.modules[name] = made
    try:
        with _beside(file.parent):
            spec.loader.exec_module(made)
    except BaseException as error:  # user code may raise any exception
        del sys.modules[name]
        if _is_end(error):
            raise
        place, words = place_of(error, file.parent) or file.name, f"{type(error).__name__}: {reason(error)}"
        raise InvalidParameter(
            f"{where}: the import of {file.name} failed at {place} ({words}), expected a module that can be imported"
        ) from None
    return made


@contextmanager
def _beside(folder: Path) -> Iterator[None]:
    """Allow imports from a folder only in the body."""
    known = set(sys.modules)
    sys.path.append(str(folder))
    try:
        yield
    finally:
        sys.path.remove(str(folder))
        for name in sys.modules.keys() - known:
            if (file := getattr(sys.modules[name], "__file__", None)) and Path(file).parent == folder:
                del sys.modules[name]


def guarded(kind: type, expected: Mapping[str, Expected | None]) -> type:
    """Return a class whose named calls return a plain answer or raise.

    These calls raise `InvalidParameter`, with file and line, the exception or the answer, and the expected answer.
    """
    made = type(kind.__name__, (kind,), {"__module__": kind.__module__, "__slots__": (), MARK: True})
    for name, answer in expected.items():
        if callable(getattr(kind, name, None)):
            setattr(made, name, _call(made, name, answer))
    return made


def _briefly(value: object) -> str:
    """Show a value on one line, without the middle of a long text.

    >>> _briefly(3.0), len(_briefly("a" * 4000)) < 150
    ('3.0', True)
    """
    return shorten(" ".join(repr(value).split()), 100)


def _call(made: type, name: str, expected: Expected | None) -> Callable[..., Any]:
    kind: Any = made.__base__
    folder = Path(sys.modules[kind.__module__].__file__ or "").parent

    @functools.wraps(getattr(kind, name))
    def call(self: object, *asked: Any, **named: Any) -> Any:
        try:
            value = getattr(super(made, self), name)(*asked, **named)
            if expected is None:
                return value
            if expected.fits(value, (*asked, *named.values())):
                return expected.plain(value)
            code = getattr(getattr(kind, name), "__code__", None)
            where = f"{code.co_filename}, line {code.co_firstlineno}" if code else str(getattr(kind, name))
            found = f"{_briefly(value)} as the answer of {name}"
        except TactometryError:
            raise
        except BaseException as error:  # user code may raise any exception
            if _is_end(error):
                raise
            where = place_of(error, folder) or kind.__name__
            found = f"{type(error).__name__} ({reason(error)}) in {name}"
            raise InvalidParameter(f"{where}: found {found}, expected an answer; {REMEDY}") from None
        raise InvalidParameter(f"{where}: found {found}, expected {expected.words}; {REMEDY}")

    return call


def _is_end(error: BaseException) -> bool:
    """Return True for Ctrl-C and a signal that ends the process."""
    return type(error) in (KeyboardInterrupt, Terminated)


def place_of(error: BaseException, folder: Path) -> str:
    """Return the line of a file in the folder that raised an error, or nothing."""
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if Path(frame.filename).parent == folder]
    return f"{frames[-1].filename}, line {frames[-1].lineno}" if frames else ""
