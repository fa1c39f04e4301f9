"""What plates that focus have in common, played on or not."""

from collections.abc import Mapping

from ...composition.effect import note

REFUSES: Mapping[str, str] = note(
    "'focus_detection' in its place: a focus is felt as one event, whose spectrum in the skin no source states, and a "
    "train of them by the Pacinian channel alone",
    "receptors",
    "sensitivity",
    "summation",
)
"""Thresholds by frequency."""
