"""Validation runs: chunks of outcomes on disk, and tables of results.

Any process can compute any chunk.
"""

import io
from collections.abc import Callable, Iterator, Mapping
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

from ..harness import keep_chunks
from ..workers import Spread, here
from .check import summary
from .checks import CHECKS, check_of

OUTCOMES: Final = "outcomes"
SECONDS: Final = "processor_s"


@dataclass(frozen=True)
class Chunk:
    """Part of the sets of one setting of a check."""

    check: str
    setting: str
    number: int

    def simulated(self, seed: int) -> pd.DataFrame:
        """Simulate the outcomes, with a random generator for this chunk only."""
        check = check_of(self.check)
        rng = stream(seed, *(crc32(name.encode()) for name in (self.check, self.setting)), self.number)
        return check.settings[self.setting](check.n_sets, rng)

    def path(self, root: Path) -> Path:
        """Path of the file with the outcomes."""
        place = list(check_of(self.check).settings).index(self.setting)
        return root / OUTCOMES / f"{self.check}_{place:02d}_{self.number:04d}.parquet"


@dataclass(frozen=True)
class Validation:
    """Validation to run: checks, rounds (chunks per setting) and seed.

    Raises `InvalidParameter` for an unknown check, or fewer than one round.
    """

    seed: int
    n_rounds: int = 1
    checks: tuple[str, ...] = CHECKS

    def __post_init__(self) -> None:
        whole("Validation", lowest=1, n_rounds=self.n_rounds)
        whole("Validation", lowest=0, seed=self.seed)
        for name in self.checks:
            one_of("check", name, CHECKS)

    @property
    def chunks(self) -> list[Chunk]:
        """Chunks in order of rounds: an interrupted run has complete rounds."""
        settings = [(name, setting) for name in self.checks for setting in check_of(name).settings]
        return [Chunk(name, setting, number) for number in range(self.n_rounds) for name, setting in settings]

    @property
    def asked(self) -> dict[str, Any]:
        """Inputs that determine the outcomes, except versions and rounds."""
        return {"seed": self.seed, "checks": list(self.checks)}


@dataclass(frozen=True)
class Validated:
    """Results: table and processor time (s) of each check, by name."""

    validation: Validation
    tables: Mapping[str, pd.DataFrame]
    seconds: Mapping[str, float]


def validate(
    validation: Validation,
    root: Path,
    *,
    resume: bool = False,
    spread: Spread = here,
    tell: Callable[[Iterator[Path], int], Iterator[Path]] = lambda paths, n: paths,
) -> Validated:
    """Simulate all chunks into a folder, and return the tables.

    Raises `InvalidFile` if the folder contains another run, or contains a run and `resume` is False.

    - `resume`: Continue an interrupted run, or one with fewer rounds.
    - `tell`: Called with the iterator of completed files and their number.
    """
    prepare(root, validation.asked, "validation", resume=resume)
    make_folder(root / OUTCOMES)
    left = [chunk for chunk in validation.chunks if not chunk.path(root).exists()]
    paths, jobs = [chunk.path(root) for chunk in left], [(chunk, validation.seed) for chunk in left]
    for _ in tell(keep_chunks(paths, jobs, chunk_content, spread), len(left)):
        pass
    tables, seconds = {}, {}
    for name in validation.checks:
        tables[name], seconds[name] = _table(root, name, validation.chunks)
        write_atomically(root / f"{name}.csv", tables[name].to_csv(index=False, float_format="%.9g").encode())
    return Validated(validation, tables, seconds)


def chunk_content(job: tuple[Chunk, int]) -> bytes:
    """Return the outcomes of a chunk as Parquet."""
    chunk, seed = job
    began_s, content = process_time(), io.BytesIO()
    outcomes = chunk.simulated(seed)
    outcomes.attrs[SECONDS] = process_time() - began_s
    outcomes.to_parquet(content, index=False)
    return content.getvalue()


def _table(root: Path, name: str, chunks: list[Chunk]) -> tuple[pd.DataFrame, float]:
    """Return the table of a check and the processor time of its chunks."""
    check, paths = check_of(name), sorted(chunk.path(root) for chunk in chunks if chunk.check == name)
    parts = [pd.read_parquet(path) for path in paths]
    seconds = sum(part.attrs.pop(SECONDS, 0.0) for part in parts)
    return summary(check.kind, pd.concat(parts, ignore_index=True), check.keys), seconds
