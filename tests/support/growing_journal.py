"""A data set whose journal grows on request."""

from dataclasses import dataclass
from pathlib import Path

import pytest


@dataclass
class GrowingJournal:
    """A journal that contains as many of a session's lines as requested."""

    path: Path
    lines: list

    @property
    def root(self):
        return self.path.parents[1]

    def holds(self, n_lines=None, more=b""):
        """Write the first lines, or all, and any text after them."""
        self.path.write_bytes(b"".join(self.lines[:n_lines]) + more)


@pytest.fixture
def journal(whole, tmp_path):
    (tmp_path / "journals").mkdir()
    (tmp_path / "study.toml").write_bytes((whole / "study.toml").read_bytes())
    [recorded] = (whole / "journals").glob("*.jsonl")
    return GrowingJournal(tmp_path / "journals" / recorded.name, recorded.read_bytes().splitlines(keepends=True))
