"""A data set whose journal grows as a test says."""

from dataclasses import dataclass
from pathlib import Path

import pytest


@dataclass
class GrowingJournal:
    """It holds as many of the `lines` of a session as a test says; at first it is not there."""

    path: Path
    lines: list

    @property
    def root(self):
        return self.path.parents[1]

    def holds(self, n_lines=None, more=b""):
        """The first lines, or all, and what comes behind them."""
        self.path.write_bytes(b"".join(self.lines[:n_lines]) + more)


@pytest.fixture
def journal(whole, tmp_path):
    """That of a data set which has its study already."""
    (tmp_path / "journals").mkdir()
    (tmp_path / "study.toml").write_bytes((whole / "study.toml").read_bytes())
    [recorded] = (whole / "journals").glob("*.jsonl")
    return GrowingJournal(tmp_path / "journals" / recorded.name, recorded.read_bytes().splitlines(keepends=True))
