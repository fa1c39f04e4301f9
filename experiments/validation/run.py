"""Checks from start to end: chunks that any process makes, kept on the disk, and the tables of what they say."""

import io
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from time import process_time
from typing import Any, Final
from zlib import crc32

import pandas as pd

from tactometry.arguments.require import one_of, whole
from tactometry.files.durable import make_folder, write_atomically
from tactometry.files.json_file import prepare
from tactometry.protocols.order import stream

from ..workers import Spread, here
from .check import Check
from .checks import CHECKS, check_of
from .kinds import summary

OUTCOMES: Final = "outcomes"
SECONDS: Final = "processor_s"


@dataclass(frozen=True)
class Chunk:
    """Some sets of one setting of a check, by names and a number: whoever has them makes the same outcomes."""

    check: str
    setting: str
    number: int

    def simulated(self, seed: int) -> pd.DataFrame:
        """Its outcomes; its random numbers are its own, and no other check, setting or number changes them."""
        check = check_of(self.check)
        rng = stream(seed, *(crc32(name.encode()) for name in (self.check, self.setting)), self.number)
        return check.settings[self.setting](check.n_sets, rng)


@dataclass(frozen=True)
class Validation:
    """Which checks, in how many rounds (chunks of each setting), from which seed.

    Raises
    ------
    InvalidParameter
        For a check that there is not, or fewer than one round.
    """

    seed: int
    n_rounds: int = 1
    checks: tuple[str, ...] = tuple(CHECKS)

    def __post_init__(self) -> None:
        whole("Validation", lowest=1, n_rounds=self.n_rounds)
        whole("Validation", lowest=0, seed=self.seed)
        for name in self.checks:
            one_of("check", name, tuple(CHECKS))

    @property
    def chunks(self) -> list[Chunk]:
        """Round after round, so that what is kept of a run that was stopped is a smaller one of all."""
        settings = [(name, setting) for name in self.checks for setting in check_of(name).settings]
        return [Chunk(name, setting, number) for number in range(self.n_rounds) for name, setting in settings]

    @property
    def asked(self) -> dict[str, Any]:
        """What its outcomes follow from, but the versions; more rounds go on with those that are kept."""
        return {"seed": self.seed, "checks": list(self.checks)}


@dataclass(frozen=True)
class Validated:
    """The table of each check, by its name, and the processor time that all its chunks took (s)."""

    validation: Validation
    tables: Mapping[str, pd.DataFrame]
    seconds: Mapping[str, float]


def validate(
    validation: Validation,
    root: Path,
    *,
    resume: bool = False,
    spread: Spread = here,
    tell: Callable[[Iterator[Chunk], int], Iterator[Chunk]] = lambda chunks, n: chunks,
) -> Validated:
    """Make the outcomes of all chunks, in a folder that keeps them, and their tables.

    Parameters
    ----------
    resume : bool
        Go on with the folder of a run that was stopped, or of one with fewer rounds.
    tell : callable
        Is given the chunks, as they are whole, and their number.

    Raises
    ------
    InvalidFile
        If the folder holds a run already and `resume` is not given, or another one.
    """
    prepare(root, validation.asked, "validation", resume=resume)
    make_folder(root / OUTCOMES)
    chunks = validation.chunks
    left = [chunk for chunk in chunks if not path_of(root, chunk).exists()]
    jobs = [(chunk, validation.seed) for chunk in left]
    for _ in tell(_kept(root, left, spread(simulated, jobs)), len(left)):
        pass
    tables, seconds = {}, {}
    for name in validation.checks:
        tables[name], seconds[name] = _gathered(root, check_of(name), [each for each in chunks if each.check == name])
        write_atomically(root / f"{name}.csv", tables[name].to_csv(index=False, float_format="%.9g").encode())
    return Validated(validation, tables, seconds)


def path_of(root: Path, chunk: Chunk) -> Path:
    """The file of a chunk."""
    place = list(check_of(chunk.check).settings).index(chunk.setting)
    return root / OUTCOMES / f"{chunk.check}_{place:02d}_{chunk.number:04d}.parquet"


def simulated(job: tuple[Chunk, int]) -> bytes:
    """The outcomes of a chunk as a Parquet file, with the time that they took as an attribute."""
    chunk, seed = job
    began_s = process_time()
    outcomes = chunk.simulated(seed)
    outcomes.attrs[SECONDS] = process_time() - began_s
    content = io.BytesIO()
    outcomes.to_parquet(content, index=False)
    return content.getvalue()


def _kept(root: Path, chunks: Sequence[Chunk], made: Iterator[bytes]) -> Iterator[Chunk]:
    """Each chunk when its file is whole."""
    for chunk, content in zip(chunks, made, strict=True):
        write_atomically(path_of(root, chunk), content)
        yield chunk


def _gathered(root: Path, check: Check, chunks: Sequence[Chunk]) -> tuple[pd.DataFrame, float]:
    """The table of a check and the time of its chunks, setting after setting, whatever the order in which they came."""
    paths = sorted(path_of(root, chunk) for chunk in chunks)
    parts = [pd.read_parquet(path) for path in paths]
    seconds = sum(part.attrs.pop(SECONDS, 0.0) for part in parts)
    return summary(check.kind, pd.concat(parts, ignore_index=True), check.keys), seconds
