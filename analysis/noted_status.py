"""Words for how a fit went, as files hold them, each with what it tells a reader."""

from enum import StrEnum
from typing import Self


class NotedStatus(StrEnum):
    """Members are written ``NAME = "word", "note"``: equal to the word, made from it, with the `note` beside."""

    note: str

    def __new__(cls, word: str, note: str = "") -> Self:
        status = str.__new__(cls, word)
        status._value_ = word
        status.note = note
        return status
