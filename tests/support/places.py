"""Paths in the repository for tests in any folder."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
RECORDED = ROOT / "tests" / "recorded"
FOREIGN = ROOT / "tests" / "foreign"
SHARED = ROOT.parent / "shared"
"""Third-party data sets, absent on most machines."""
