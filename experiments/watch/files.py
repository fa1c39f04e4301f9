"""The files that the page is made of."""

from importlib.resources import files
from typing import Final

SERVED: Final = {"page.css": "text/css", "page.js": "text/javascript"}
"""Those that a browser asks for, with their types."""


def page_text(name: str) -> str:
    """A file of the page.

    >>> page_text("page.js").splitlines()[0]
    '"use strict";'
    """
    return (files(__package__) / name).read_text("utf-8")
