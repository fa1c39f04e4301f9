"""Tables of data sets as rows of text."""

import csv


def rows_of(*paths):
    """Return the rows of CSV or TSV files, one after the other."""
    rows = []
    for path in paths:
        with path.open(newline="", encoding="utf-8") as text:
            rows += csv.DictReader(text, delimiter="\t" if path.suffix == ".tsv" else ",")
    return rows


def trial_rows(root):
    """Return the trials of a data set by session."""
    return rows_of(*sorted((root / "data").glob("*.csv")))


def event_rows(root):
    """Return the events of a data set's sessions."""
    return rows_of(*sorted((root / "journals").glob("*_events.tsv")))
