"""State of a session after given rows."""

from tactometry.session.answer import Done
from tactometry.session.request import Record


def with_row(progress, row, aborted=None):
    return progress.after(Record(row, aborted), Done(progress.at_s + 1.0))
