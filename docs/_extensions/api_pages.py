"""Write the API pages from docstrings with autodoc. With the tag `quick` they stay empty."""

import re
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.domains import Domain

OF_VALUES = ("property", "attribute", "data")
AS_WRITTEN: dict[str, list[str]] = {}


def read(app: Sphinx, page: str, source: list[str]) -> None:
    if page.startswith("reference/api/") and app.tags.has("quick"):
        source[0] = re.sub(r"```{eval-rst}.*?```", "", source[0], flags=re.DOTALL)


def before(app: Sphinx, what: str, name: str, thing: object, options: object, lines: list[str]) -> None:
    """Insert a heading before an example that follows a section."""
    del app, thing, options
    if what in OF_VALUES:
        AS_WRITTEN[name] = list(lines)
    first = next((n for n, line in enumerate(lines) if line.startswith(">>>")), None)
    headed = [line for line in lines[:first] if re.fullmatch(r"-{3,}", line)]
    if first is not None and headed and "Examples" not in lines[:first]:
        lines[first:first] = ["Examples", "--------"]


def behind(app: Sphinx, what: str, name: str, thing: object, options: object, lines: list[str]) -> None:
    """Undo a wrong type of a property: napoleon takes the text before a colon for a type."""
    del app, thing, options
    if what in OF_VALUES:
        lines[:] = AS_WRITTEN.pop(name, lines)


def unresolved(app: Sphinx, domain: Domain | None, node: nodes.Element) -> bool | None:
    """Ignore unresolved links to Python names if no docstrings were read."""
    del node
    return True if app.tags.has("quick") and domain is not None and domain.name == "py" else None


def setup(app: Sphinx) -> dict[str, Any]:
    app.connect("source-read", read)
    app.connect("autodoc-process-docstring", before, priority=400)
    app.connect("autodoc-process-docstring", behind, priority=600)
    app.connect("warn-missing-reference", unresolved)
    return {"parallel_read_safe": True}
