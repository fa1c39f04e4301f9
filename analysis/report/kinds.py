"""Kinds of results in the order of the page; each is a file in `sections`."""

from tactometry.loading import resolve

from .section import ResultKind

NAMES = (
    "outcomes",
    "standard",
    "questionnaires",
    "task_tables",
    "localisation",
    "measured",
    "touches",
    "quality",
    "course",
    "categories",
    "curves",
)
KINDS: tuple[ResultKind, ...] = tuple(resolve(f"{__package__}.sections.{name}:KIND") for name in NAMES)
