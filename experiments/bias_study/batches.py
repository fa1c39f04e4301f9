"""Simulated tracks and their fits, in batches."""

import hashlib
import io
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from tactometry.analysis.threshold.track_modes import TrackModes, fit_modes
from tactometry.arguments.require import whole
from tactometry.files.durable import make_folder
from tactometry.files.json_file import prepare
from tactometry.protocols.batch.answers import LevelTable, criteria
from tactometry.protocols.batch.tracks import tracks
from tactometry.protocols.order import stream
from tactometry.protocols.procedures.procedure import Rule
from tactometry.protocols.procedures.stepping import SteppingRule

from ..harness import arrow, keep_chunks
from ..workers import Spread, here

BATCH = 2000
"""Number of tracks in memory at a time, about 25 MB."""
TRACKS = "tracks"
COLUMNS: Final = {
    "true_threshold": "float64",
    "ending": "int8",
    "threshold": "float64",
    "standard_error": "float64",
    "width": "float64",
    "regular": "bool_",
}
"""Columns of the files with their Arrow types."""


@dataclass(frozen=True)
class Respondents:
    """Simulated participants whose thresholds are normally distributed.

    Thresholds are in the unit of the felt level. All participants share the other parameters.
    """

    threshold: float
    threshold_sd: float
    width: float
    guess_rate: float
    lapse_rate: float
    shape: str = "gumbel"


@dataclass(frozen=True, eq=False)
class FittedTracks:
    """True thresholds (n_sets,), ending codes, and fits of tracks.

    `protocols.procedures.stepping` defines the ending codes.
    """

    thresholds: NDArray[np.float64]
    endings: NDArray[np.int8]
    modes: TrackModes


def fitted_tracks(
    rule: Rule[Any],
    respondents: Respondents,
    batches: Iterable[int],
    seed: int,
    *,
    n_trials: int,
    table: LevelTable | None = None,
    size: int = BATCH,
) -> Iterator[FittedTracks]:
    """Yield `size` fitted tracks for each batch number.

    Each batch has a separate random generator, so any process can compute any batch, in any order. A `table` maps the
    levels of the stimulus to felt levels. The fit uses the levels of the stimulus.

    >>> from tactometry.protocols import Staircase
    >>> people = Respondents(20.0, 3.0, 8.0, guess_rate=0.5, lapse_rate=0.02)
    >>> rule = Staircase(36.0, (8.0, 4.0, 2.0), 0.0, 40.0, n_trials=60, n_reversals=60)
    >>> one, two = fitted_tracks(rule, people, (0, 1), 1, n_trials=60)
    >>> (again,) = fitted_tracks(rule, people, (1,), 1, n_trials=60)
    >>> bool((two.modes.thresholds == again.modes.thresholds).all()), bool((one.thresholds == two.thresholds).any())
    (True, False)
    """
    shape, guess_rate, lapse_rate = respondents.shape, respondents.guess_rate, respondents.lapse_rate
    for number in batches:
        rng = stream(seed, number)
        thresholds = respondents.threshold + respondents.threshold_sd * rng.standard_normal(size)
        uniform = rng.random((size, n_trials))
        drawn = criteria(uniform, shape, thresholds[:, None], respondents.width, guess_rate, lapse_rate)
        orders = rule.orders(size, rng) if isinstance(rule, SteppingRule) else None
        made = tracks(rule, drawn, table, orders=orders)
        modes = fit_modes(made.levels, made.answers, shape=shape, guess_rate=guess_rate, lapse_rate=lapse_rate)
        yield FittedTracks(thresholds, made.endings, modes)


@dataclass(frozen=True, eq=False)
class TrackRun:
    """Run of `fitted_tracks` in batches of `size` tracks, written to files.

    Each file contains `n_together` batches.

    Raises `InvalidParameter` if a number is below 1.
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
        """Batch numbers in each file."""
        starts = range(0, self.n_batches, self.n_together)
        return [range(first, min(first + self.n_together, self.n_batches)) for first in starts]

    @property
    def asked(self) -> dict[str, Any]:
        """All inputs that determine the results, except versions."""
        numbers = {name: getattr(self, name) for name in ("seed", "n_trials", "n_batches", "size", "n_together")}
        content = b"" if self.table is None else self.table.levels.tobytes() + self.table.felt.tobytes()
        digest = hashlib.sha256(content).hexdigest() if content else None
        return {"rule": repr(self.rule), "respondents": asdict(self.respondents), **numbers, "table": digest}


def write_tracks(run: TrackRun, root: Path, *, resume: bool = False, spread: Spread = here) -> Iterator[Path]:
    """Write the files of a run, and yield the path of each.

    The same run gives the same bytes with any number of workers.

    Each row is a track: its true threshold, the code of its ending, and its fit. All files together are one data set:
    ``pandas.read_parquet(root / "tracks")``.

    Raises `InvalidFile` if the folder contains another run, or contains this run and `resume` is False. Raises
    `DeviceFailed` if pyarrow (extra: power) is not installed.

    - `root`: Output folder, created if missing.
    - `resume`: Continue an interrupted run and keep its complete files.
    """
    arrow("tracks")
    prepare(root, run.asked, "run of tracks", resume=resume)
    make_folder(root / TRACKS)
    paths = [root / TRACKS / f"{part.start:06d}-{part.stop - 1:06d}.parquet" for part in run.chunks]
    return keep_chunks(paths, [(run, part) for part in run.chunks], chunk_content, spread)


def chunk_content(job: tuple[TrackRun, range]) -> bytes:
    """Return the content of a file. Keeps one batch in memory at a time."""
    run, part = job
    content, pa = io.BytesIO(), arrow("tracks")
    schema = pa.schema([(name, getattr(pa, kind)()) for name, kind in COLUMNS.items()], {"simulated": "true"})
    options: dict[str, Any] = {"n_trials": run.n_trials, "table": run.table, "size": run.size}
    with pa.parquet.ParquetWriter(content, schema) as file:
        for made in fitted_tracks(run.rule, run.respondents, part, run.seed, **options):
            modes = made.modes
            fits = modes.thresholds, modes.standard_errors, modes.widths, modes.regular
            columns = [pa.array(each) for each in (made.thresholds, made.endings, *fits)]
            file.write_batch(pa.RecordBatch.from_arrays(columns, schema=schema))
    return content.getvalue()
