"""Which of the thesis's captions an item makes, and why no item makes the others."""

from collections.abc import Iterator, Mapping

from .items import REPRODUCTIONS

BESIDE: Mapping[str, tuple[str, ...]] = {
    "figure-3.9": ("figure-3.10",),
    "figure-3.11": ("figure-3.12",),
    "figure-3.16": ("figure-4.23",),
    "figure-3.18": ("figure-4.12",),
    "figure-3.21": ("figure-4.14",),
    "figure-4.15": tuple(f"figure-4.{n}" for n in range(16, 23)),
    "figure-4.25": ("figure-4.26", "figure-4.27"),
    "figure-4.33": ("figure-4.32",),
    "figure-5.4": ("figure-5.5",),
    "figure-6.8": ("figure-6.9", "figure-6.10"),
    "figure-B.1": ("figure-B.2",),
    "table-4.3": ("table-4.2",),
}
"""What the item of another caption makes too."""

NOT_MADE: Mapping[str, tuple[str, ...]] = {
    "a survey of others' devices, no result": (*(f"figure-2.{n}" for n in range(1, 38)), "table-2.2"),
    "a drawing of a principle, a set-up, a circuit or a model, or a photo; it holds no result": (
        *("figure-3.1", "figure-3.2", "figure-3.3", "figure-3.6", "figure-3.22"),
        *(f"figure-4.{n}" for n in (*range(1, 9), 10, 24)),
        *("figure-5.1", "figure-5.2", "figure-5.3", "figure-5.6"),
        *("figure-6.1", "figure-6.2", "figure-6.4", "figure-6.7", "figure-6.11", "figure-6.14"),
    ),
    "taken from others' work, on a prototype that our sources do not describe": ("figure-3.5", "figure-3.17"),
    "the gain of an amplifier, whose circuit and load our sources do not describe": ("figure-3.7",),
    "constants from data sheets that our sources do not quote: `tactometry design` has glasses with their sources": (
        "table-3.4",
    ),
    'called "Parameters"; of what, our sources do not say': ("table-3.5",),
    "the items of the survey, which our sources do not hold": ("table-5.1",),
}
"""By the reason."""


def item_of(caption: str) -> str:
    """The item that makes a caption, itself or beside another; of no caption, what was asked.

    >>> item_of("figure-4.26"), item_of("figure-4.28")
    ('figure-4.25', 'figure-4.28')
    """
    return next((item for item, others in BESIDE.items() if caption in others), caption)


def reason_for(caption: str) -> str | None:
    """Why none makes it."""
    return next((reason for reason, captions in NOT_MADE.items() if caption in captions), None)


def captions() -> Iterator[str]:
    """Each figure and table of the thesis that an item makes or a reason leaves out."""
    yield from (name for name in REPRODUCTIONS if not name.startswith("finding"))
    for known in (BESIDE, NOT_MADE):
        for names in known.values():
            yield from names
