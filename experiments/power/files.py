"""Folder of a power analysis, filled by batches of studies until powers are precise."""

import io
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, fields
from functools import partial
from pathlib import Path
from typing import Any, Final

from tactometry.errors import InvalidFile
from tactometry.files.durable import make_folder, read_file, write_atomically
from tactometry.files.json_file import prepare
from tactometry.files.rows import write_records
from tactometry.provenance import sha256

from ..harness import arrow, share_interval
from ..workers import Spread
from .design import Case, PowerDesign
from .replicate import Row, replicate, studied
from .summary import PowerEstimate

EXCLUDED_AT: Final = 0.999
"""Sampling stops when an interval with this coverage excludes the target. An interval of 95 % would exclude it by
chance too often, as it is checked after every batch."""


def is_settled(n_yes: int, n: int, precision: float, target: float | None) -> bool:
    """Return True if a share is precise enough or excludes the target.

    >>> is_settled(40, 40, 0.05, 0.8), is_settled(32, 40, 0.05, 0.8), is_settled(10, 40, 0.05, 0.8)
    (True, False, True)
    """
    low, high = share_interval(n_yes, n)
    if (high - low) / 2 <= precision:
        return True
    if target is None:
        return False
    least, most = share_interval(n_yes, n, EXCLUDED_AT)
    return not least <= target <= most


@dataclass(frozen=True)
class Batch:
    """Studies of one case, numbered from `first` to below `end`."""

    case: Case
    first: int
    end: int

    @property
    def name(self) -> str:
        """Stem of the batch's file name. Names sort by number within a case."""
        return f"{self.case.name}_{self.first:07d}"


class Significances:
    """Numbers of simulated and of significant studies of a case."""

    def __init__(self, design: PowerDesign, case: Case) -> None:
        self._design, self._case = design, case
        self._n_yes: dict[int, int] = defaultdict(int)
        self.n = 0

    def add(self, rows: Iterable[Row], n: int) -> None:
        self.n += n
        for row in rows:
            self._n_yes[row.n_participants] += row.significant

    @property
    def are_settled(self) -> bool:
        """True if all shares are settled. False positives have no target."""
        if self.n >= self._design.most:
            return True
        target = self._design.target if self._case.has_effect else None
        precision = self._design.precision
        return self.n > 0 and all(
            is_settled(self._n_yes[n], self.n, precision, target) for n in self._design.participants
        )


Kept = Callable[[Batch], tuple[Row, ...] | None]
"""Function that returns the stored rows of a batch, or None."""
Keep = Callable[[Batch, Sequence[Row]], None]
Simulate = Callable[[PowerDesign, Batch, Spread], Iterable[Row]]


def sample(
    design: PowerDesign,
    spread: Spread,
    kept: Kept = lambda batch: None,
    keep: Keep = lambda batch, rows: None,
    simulate: Simulate | None = None,
) -> Iterator[tuple[Batch, tuple[Row, ...]]]:
    """Yield the batches of each case with their rows, reusing stored ones.

    The batches depend only on the design.
    """
    for case in design.cases:
        counts = Significances(design, case)
        while not counts.are_settled:
            batch = Batch(case, counts.n, min(counts.n + design.batch, design.most))
            rows = kept(batch)
            if rows is None:
                rows = tuple((simulate or simulated)(design, batch, spread))
                keep(batch, rows)
            counts.add(rows, batch.end - batch.first)
            yield batch, rows


def simulated(design: PowerDesign, batch: Batch, spread: Spread) -> Iterator[Row]:
    """Yield the rows of a batch."""
    for rows in spread(partial(replicate, design, batch.case), range(batch.first, batch.end)):
        yield from rows


STUDY, STUDIES, TABLE, DATA = "study.toml", "studies", "power.csv", "data"
PLACE = "power --out"
MARK = {b"simulated": b"true"}
OF_FILES = ["row", "source"]
"""Columns for the origin of a row, which simulated trials do not have."""
_TYPES: Final = {int: "int64", bool: "bool_", float: "float64", float | None: "float64"}


def asked(design: PowerDesign) -> dict[str, Any]:
    """Return all inputs that determine the results, except versions."""
    numbers = ("seed", "target", "alpha", "precision", "most", "batch", "dropout_share", "dependent")
    return {
        "study": design.where,
        "study_sha256": sha256(design.study_toml),
        "effect": design.effect.words(),
        "participants": list(design.participants),
        "trials": list(design.trials),
        **{name: getattr(design, name) for name in numbers},
    }


@dataclass(frozen=True)
class Folder:
    """Folder of one power analysis. With `keeps_data`, it stores all trials."""

    root: Path
    keeps_data: bool = False

    @classmethod
    def prepared(cls, root: Path, design: PowerDesign, *, resume: bool, keeps_data: bool = False) -> "Folder":
        """Prepare a new folder, or continue in one with `resume`.

        Raises `InvalidFile` if the folder contains another power analysis, or contains this one and `resume` is False.
        Raises `DeviceFailed` if pyarrow (extra: power) is not installed.
        """
        arrow(PLACE)
        prepare(root, asked(design), "power analysis", resume=resume)
        make_folder(root / STUDIES)
        if keeps_data:
            make_folder(root / DATA)
        write_atomically(root / STUDY, design.study_toml)
        return cls(root, keeps_data)

    def simulated(self, design: PowerDesign, batch: Batch, spread: Spread) -> Iterable[Row]:
        """Simulate a batch and return its rows. Stores its trials if requested."""
        if self.keeps_data:
            return simulated_and_kept(self.root, design, batch, spread)
        return simulated(design, batch, spread)

    def kept(self, batch: Batch) -> tuple[Row, ...] | None:
        """Return the rows of a stored batch, or None.

        Raises `InvalidFile` if the file of the batch is damaged.
        """
        path = self._path(batch)
        lacks_data = self.keeps_data and not all(file.exists() for file in paths_of(self.root, batch))
        if lacks_data or not path.exists():
            return None
        content = read_file(path, "a table of simulated studies")
        pa = arrow(PLACE)
        try:
            rows = pa.parquet.read_table(io.BytesIO(content), schema=_schema(pa)).to_pylist()
            return tuple(Row(**row) for row in rows)
        except (pa.ArrowException, TypeError, KeyError, OSError) as damage:
            reason = " ".join(str(damage).split())
            raise InvalidFile(
                f"{path}: cannot be read ({reason:.80}), expected a batch; remove it and use --resume"
            ) from None

    def keep(self, batch: Batch, rows: Sequence[Row]) -> None:
        """Write a batch atomically. The same rows give the same bytes."""
        content = io.BytesIO()
        pa = arrow(PLACE)
        pa.parquet.write_table(pa.Table.from_pylist([asdict(row) for row in rows], schema=_schema(pa)), content)
        write_atomically(self._path(batch), content.getvalue())

    def write_table(self, points: Sequence[PowerEstimate]) -> None:
        write_records(PowerEstimate, points, self.root / TABLE)

    def _path(self, batch: Batch) -> Path:
        return self.root / STUDIES / f"{batch.name}.parquet"


def _schema(pa: Any) -> Any:
    kinds = [(field.name, _TYPES[field.type]) for field in fields(Row)]  # type: ignore[index]
    return pa.schema([(name, getattr(pa, kind)()) for name, kind in kinds], MARK)


def paths_of(root: Path, batch: Batch) -> list[Path]:
    """Return the file of each study of a batch."""
    return [root / DATA / f"{batch.case.name}_{number:07d}.parquet" for number in range(batch.first, batch.end)]


def simulated_and_kept(root: Path, design: PowerDesign, batch: Batch, spread: Spread) -> Iterator[Row]:
    """Yield the rows of a batch, storing the trials of each study in turn."""
    made = spread(partial(_with_content, design, batch.case), range(batch.first, batch.end))
    for path, (rows, content) in zip(paths_of(root, batch), made, strict=True):
        write_atomically(path, content)
        yield from rows


def _with_content(design: PowerDesign, case: Case, number: int) -> tuple[tuple[Row, ...], bytes]:
    rows, trials = studied(design, case, number)
    pa = arrow(PLACE)
    table = pa.Table.from_pandas(trials.rows.drop(columns=OF_FILES), preserve_index=False)
    content = io.BytesIO()
    pa.parquet.write_table(table.replace_schema_metadata({**(table.schema.metadata or {}), **MARK}), content)
    return rows, content.getvalue()
