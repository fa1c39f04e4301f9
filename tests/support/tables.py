"""Tables of data sets as rows of text, and the bytes of all files."""

import csv

from tactometry.experiments.data_sets.replaying import replay_data_set
from tactometry.experiments.data_sets.validation import validate


def rows_of(*paths):
    """Return the rows of CSV or TSV files, one after the other."""
    rows = []
    for path in paths:
        with path.open(newline="", encoding="utf-8") as text:
            rows += csv.DictReader(text, delimiter="\t" if path.suffix == ".tsv" else ",")
    return rows


def trial_rows(root):
    return rows_of(*sorted((root / "data").glob("*.csv")))


def event_rows(root):
    return rows_of(*sorted((root / "journals").glob("*_events.tsv")))


def contents(root):
    """Return the bytes of each file below a folder by its relative path."""
    return {path.relative_to(root): path.read_bytes() for path in root.rglob("*") if path.is_file()}


def is_sound(root):
    """Return True if a data set of one session has no defect and replays to its end."""
    return validate(root).defects == () and [session.complete for session in replay_data_set(root)] == [True]
