"""Files of the page, apart from what draws it: the server starts without the libraries of the analysis."""

from importlib.resources import files
from typing import Final

SERVED: Final = {"page.css": "text/css", "page.js": "text/javascript"}
"""Files that a browser requests, with their media types."""


def page_text(name: str) -> str:
    """Return a file of the page.

    >>> page_text("page.js").splitlines()[0]
    '"use strict";'
    """
    return (files(__package__) / name).read_text("utf-8")
