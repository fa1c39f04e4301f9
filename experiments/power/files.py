"""The folder of a power analysis: what was asked, what each simulated study gave, batch by batch, and the results."""

import io
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any, Final

from tactometry.errors import InvalidFile
from tactometry.files.durable import make_folder, read_file, write_atomically
from tactometry.files.json_file import prepare
from tactometry.files.rows import write_records
from tactometry.provenance import sha256

from ..parquet import arrow
from ..workers import Spread
from .data import DATA, MARK, PLACE, paths_of, simulated_and_kept
from .design import PowerDesign
from .replicate import Row
from .sampling import Batch, simulated
from .summary import PowerEstimate

STUDY, STUDIES, TABLE = "study.toml", "studies", "power.csv"
_TYPES: Final = {int: "int64", bool: "bool_", float: "float64", float | None: "float64"}


def asked(design: PowerDesign) -> dict[str, Any]:
    """Everything that the results follow from, beside the bytes of the study and the versions."""
    return {
        "study": design.where,
        "study_sha256": sha256(design.study_toml),
        "effect": design.effect.words(),
        "participants": list(design.participants),
        "trials": list(design.trials),
        "seed": design.seed,
        "target": design.target,
        "alpha": design.alpha,
        "precision": design.precision,
        "most": design.most,
        "batch": design.batch,
        "dropout_share": design.dropout_share,
        "dependent": design.dependent,
    }


@dataclass(frozen=True)
class Folder:
    """A folder of one power analysis; with `keeps_data` the trials of its studies are kept too."""

    root: Path
    keeps_data: bool = False

    @classmethod
    def prepared(cls, root: Path, design: PowerDesign, *, resume: bool, keeps_data: bool = False) -> "Folder":
        """The folder with what is asked; with `resume` one that an earlier run of the same left.

        Raises
        ------
        InvalidFile
            If it holds a power analysis already and `resume` is not given, or another one.
        DeviceFailed
            Without pyarrow (an extra: power).
        """
        arrow(PLACE)
        prepare(root, asked(design), "power analysis", resume=resume)
        make_folder(root / STUDIES)
        if keeps_data:
            make_folder(root / DATA)
        write_atomically(root / STUDY, design.study_toml)
        return cls(root, keeps_data)

    def simulated(self, design: PowerDesign, batch: Batch, spread: Spread) -> Iterable[Row]:
        """The rows of a batch, whose trials are kept where that is wanted."""
        if self.keeps_data:
            return simulated_and_kept(self.root, design, batch, spread)
        return simulated(design, batch, spread)

    def kept(self, batch: Batch) -> tuple[Row, ...] | None:
        """The rows of a batch, or None where there are none.

        Raises
        ------
        InvalidFile
            If its file is damaged.
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
                f"{path}: cannot be read ({reason:.80}), expected a batch; remove it, then --resume"
            ) from None

    def keep(self, batch: Batch, rows: Sequence[Row]) -> None:
        """Write a batch, whole or not at all; the same rows give the same bytes."""
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
