"""The trials of simulated studies, where they are kept: a Parquet file a study, which says that it is simulated."""

import io
from collections.abc import Iterator
from functools import partial
from pathlib import Path

from tactometry.analysis.reading.trials import Trials
from tactometry.files.durable import write_atomically

from ..parquet import arrow
from ..workers import Spread
from .design import Case, PowerDesign
from .replicate import Row, studied
from .sampling import Batch

PLACE = "power --out"
DATA = "data"
MARK = {b"simulated": b"true"}
OF_FILES = ["row", "source"]
"""Where trials stood in a file, which these never did."""


def paths_of(root: Path, batch: Batch) -> list[Path]:
    """A file for each study of a batch."""
    return [root / DATA / f"{batch.case.name}_{number:07d}.parquet" for number in range(batch.first, batch.end)]


def simulated_and_kept(root: Path, design: PowerDesign, batch: Batch, spread: Spread) -> Iterator[Row]:
    """The rows of a batch, whose studies are written one by one: no more than a few are in memory."""
    made = spread(partial(_with_content, design, batch.case), range(batch.first, batch.end))
    for path, (rows, content) in zip(paths_of(root, batch), made, strict=True):
        write_atomically(path, content)
        yield from rows


def _with_content(design: PowerDesign, case: Case, number: int) -> tuple[tuple[Row, ...], bytes]:
    rows, trials = studied(design, case, number)
    return rows, _content(trials)


def _content(trials: Trials) -> bytes:
    pa = arrow(PLACE)
    table = pa.Table.from_pandas(trials.rows.drop(columns=OF_FILES), preserve_index=False)
    content = io.BytesIO()
    pa.parquet.write_table(table.replace_schema_metadata({**(table.schema.metadata or {}), **MARK}), content)
    return content.getvalue()
