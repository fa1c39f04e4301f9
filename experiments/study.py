"""Study files: the numbers of one experiment, strictly read."""

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tactometry.columns import RESERVED
from tactometry.errors import InvalidFile, InvalidParameter, TactometryError, nearest
from tactometry.limits import Limits
from tactometry.observers.finger import SimulatedFinger
from tactometry.observers.signal_detection import SignalDetectionObserver
from tactometry.quantity import as_si
from tactometry.strict import build

FOLDER = Path(__file__).parent
NAME = re.compile(r"[a-z][a-z0-9]*(-[a-z0-9]+)*")


@dataclass(frozen=True)
class TaskTable:
    """What is asked in a trial; `catch_rate` is the part of presentations without stimulus (yes/no only)."""

    kind: str
    catch_rate: float = 0.0
    n_intervals: int = 2
    n_attempts: int = 5

    def __post_init__(self) -> None:
        kinds = ("yes_no", "forced_choice")
        if self.kind not in kinds:
            raise InvalidParameter(
                f"TaskTable.kind: found {self.kind!r}, expected one of {', '.join(kinds)}{nearest(self.kind, kinds)}"
            )
        if not 0 <= self.catch_rate <= 0.5:
            raise InvalidParameter(f"TaskTable.catch_rate: found {self.catch_rate:g}, expected from 0 to 0.5")
        if self.catch_rate > 0 and self.kind != "yes_no":
            raise InvalidParameter(
                f"TaskTable.catch_rate: found {self.catch_rate:g} with {self.kind}, expected 0: every trial of a "
                "forced choice holds a stimulus; remove the key"
            )
        if self.n_attempts < 1:
            raise InvalidParameter(f"TaskTable.n_attempts: found {self.n_attempts}, expected at least 1")


@dataclass(frozen=True)
class Study:
    """One experiment. Tables whose keys depend on their `kind` are kept as they stand and built in `wiring`."""

    name: str
    title: str
    description: str
    task: TaskTable
    factors: dict[str, tuple[float | str, ...]]
    stimulus: dict[str, Any]
    touch: dict[str, Any]
    procedure: dict[str, Any]
    limits: Limits
    counterbalance: tuple[str, ...] = ()
    trial_s: float = 5.0
    sensation: dict[str, Any] = field(default_factory=dict)
    observer: SignalDetectionObserver = field(default_factory=SignalDetectionObserver)
    finger: SimulatedFinger = field(default_factory=SimulatedFinger)
    texts: dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not NAME.fullmatch(self.name):
            raise InvalidParameter(
                f"name: found {self.name!r}, expected words of small letters and digits joined by hyphens"
            )
        if not 0 < self.trial_s < float("inf"):
            raise InvalidParameter(f"trial_s: found {self.trial_s:g}, expected above 0")
        _check_factors(self.factors)
        for n, name in enumerate(self.counterbalance):
            if name not in self.factors or name in self.counterbalance[:n]:
                raise InvalidParameter(
                    f"counterbalance[{n}]: found {name!r}, expected each factor at most once "
                    f"({', '.join(self.factors)}){nearest(name, self.factors)}"
                )


def _check_factors(factors: Mapping[str, tuple[float | str, ...]]) -> None:
    for name, levels in factors.items():
        if name in RESERVED:
            raise InvalidParameter(
                f"factors.{name}: found a name that is a column of every trials table, expected another"
            )
        if not levels:
            raise InvalidParameter(f"factors.{name}: found an empty list, expected at least one level")
        for n, level in enumerate(levels):
            if level in levels[:n]:
                raise InvalidParameter(f"factors.{name}[{n}]: found {level!r} twice, expected each level once")


def parse(content: bytes, where: str) -> Study:
    """A study from the bytes of its file; `where` opens every sentence.

    Raises
    ------
    InvalidFile
        If the bytes are no TOML in UTF-8, or the study holds anything unknown, missing or impossible: one sentence
        with the place, what was found, what was expected and the nearest valid name.
    """
    try:
        table = tomllib.loads(content.decode("utf-8"))
    except UnicodeDecodeError as error:
        raise InvalidFile(
            f"{where}, byte {error.start}: found a byte that is not UTF-8, expected a TOML file in UTF-8"
        ) from None
    except (tomllib.TOMLDecodeError, ValueError, RecursionError) as error:
        raise InvalidFile(f"{where}: found no valid TOML ({error}), expected a study file") from None
    try:
        return build(Study, as_si(table, ""), "")
    except TactometryError as error:
        raise InvalidFile(f"{where}, {str(error).removeprefix(': ')}") from None


def builtin() -> dict[str, Path]:
    """The built-in studies by name."""
    return {path.stem: path for path in sorted(FOLDER.glob("*.toml"))}


def locate(study: str) -> Path:
    """The file of a study that is named, or given as a path.

    Raises
    ------
    InvalidFile
        If there is neither a built-in study nor a file of that name.
    """
    path = builtin().get(study, Path(study))
    if path.is_file():
        return path
    raise InvalidFile(
        f"{study}: found no such file nor built-in study, expected a path to a study file or one of "
        f"{', '.join(builtin())}{nearest(study, builtin())}"
    )


def load(study: str) -> tuple[Study, bytes]:
    """A study, named or given as a path, with the bytes of its file."""
    path = locate(study)
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InvalidFile(f"{study}: cannot read the study file ({error.strerror}), expected a readable file") from None
    return parse(content, str(path) if study not in builtin() else study), content
