"""Folder of a power analysis: inputs, batches of studies, results."""

import io
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, fields
from functools import partial
from pathlib import Path
from typing import Any, Final

from tactometry.errors import InvalidFile
from tactometry.files.durable import make_folder, read_file, write_atomically
from tactometry.files.json_file import prepare
from tactometry.files.rows import write_records
from tactometry.provenance import sha256

from ..harness import arrow
from ..workers import Spread
from .design import Case, PowerDesign
from .replicate import Row, studied
from .sampling import Batch, simulated
from .summary import PowerEstimate

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
