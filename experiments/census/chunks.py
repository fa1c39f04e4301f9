"""Simulated tracks with their fits on the disk, a million of them in bounded memory: chunks that any process makes, in
Parquet files. A run that was killed goes on behind the whole chunks that it left."""

import hashlib
import io
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

from tactometry.arguments.require import whole
from tactometry.files.durable import make_folder, write_atomically
from tactometry.files.json_file import prepare
from tactometry.protocols.batch.answers import LevelTable
from tactometry.protocols.procedures.procedure import Rule

from ..parquet import arrow
from ..workers import Spread, here
from .batches import BATCH, FittedTracks, Respondents, fitted_tracks

TRACKS = "tracks"
COLUMNS: Final = {
    "true_threshold": "float64",
    "ending": "int8",
    "threshold": "float64",
    "standard_error": "float64",
    "width": "float64",
    "regular": "bool_",
}
"""Of the tables, with their types in Arrow."""


@dataclass(frozen=True, eq=False)
class TrackRun:
    """So many batches of `size` tracks, as `fitted_tracks` makes them, `n_together` of them in a chunk.

    Raises
    ------
    InvalidParameter
        If a number of things is below 1.
    """

    rule: Rule[Any]
    respondents: Respondents
    n_batches: int
    seed: int
    n_trials: int
    table: LevelTable | None = None
    size: int = BATCH
    n_together: int = 25

    def __post_init__(self) -> None:
        whole("TrackRun", lowest=1, n_batches=self.n_batches, n_trials=self.n_trials)
        whole("TrackRun", lowest=1, size=self.size, n_together=self.n_together)

    @property
    def chunks(self) -> list[range]:
        """The numbers of batches of each chunk."""
        starts = range(0, self.n_batches, self.n_together)
        return [range(first, min(first + self.n_together, self.n_batches)) for first in starts]

    @property
    def asked(self) -> dict[str, Any]:
        """All that the results follow from, but the versions."""
        return {
            "rule": repr(self.rule),
            "respondents": asdict(self.respondents),
            "seed": self.seed,
            "n_trials": self.n_trials,
            "n_batches": self.n_batches,
            "size": self.size,
            "n_together": self.n_together,
            "table": None if self.table is None else _digest(self.table),
        }


def _digest(table: LevelTable) -> str:
    return hashlib.sha256(table.levels.tobytes() + table.felt.tobytes()).hexdigest()


def write_tracks(run: TrackRun, root: Path, *, resume: bool = False, spread: Spread = here) -> Iterator[Path]:
    """The file of each chunk in their order, as it is whole; the same run gives the same bytes, on any workers.

    Each row is a track: the threshold that it had, the code of its ending, and its fit. All files together are one data
    set: ``pandas.read_parquet(root / "tracks")``.

    Parameters
    ----------
    root : Path
        A folder that is made.
    resume : bool
        Go on where an earlier run of the same was killed: whole chunks are kept.

    Raises
    ------
    InvalidFile
        If the folder holds this run already and `resume` is not given, or another one.
    DeviceFailed
        Without pyarrow (an extra: power).
    """
    arrow("tracks")
    prepare(root, run.asked, "run of tracks", resume=resume)
    make_folder(root / TRACKS)
    paths = [root / TRACKS / f"{part.start:06d}-{part.stop - 1:06d}.parquet" for part in run.chunks]
    left = [(run, part, path) for part, path in zip(run.chunks, paths, strict=True) if not path.exists()]
    made = iter(spread(write_chunk, left))
    kept = set(paths) - {path for _, _, path in left}
    return (path if path in kept else next(made) for path in paths)


def write_chunk(job: tuple[TrackRun, range, Path]) -> Path:
    """One file, whole or not at all; a batch of it at a time is in memory."""
    run, part, path = job
    content = io.BytesIO()
    pa = arrow("tracks")
    schema = pa.schema([(name, getattr(pa, kind)()) for name, kind in COLUMNS.items()], {"simulated": "true"})
    with pa.parquet.ParquetWriter(content, schema) as file:
        for made in fitted_tracks(
            run.rule, run.respondents, part, run.seed, n_trials=run.n_trials, table=run.table, size=run.size
        ):
            file.write_batch(pa.RecordBatch.from_arrays([pa.array(each) for each in _columns(made)], schema=schema))
    write_atomically(path, content.getvalue())
    return path


def _columns(made: FittedTracks) -> tuple[Any, ...]:
    modes = made.modes
    return made.thresholds, made.endings, modes.thresholds, modes.standard_errors, modes.widths, modes.regular
